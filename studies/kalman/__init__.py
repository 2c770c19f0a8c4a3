"""The Kalman filter's passes over a whole recording: likelihood, densities, smoother."""
