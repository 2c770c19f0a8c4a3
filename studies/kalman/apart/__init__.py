"""The Kalman filters of joints and of muscles over a whole recording of a mechanism."""
