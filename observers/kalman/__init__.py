"""The Kalman filter of a pair of muscles, and its form with constant gains."""
