"""The Kalman filter of any mechanism: one filter for each joint, one for each muscle."""
