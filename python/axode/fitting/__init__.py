"""Least squares for the parameters of a mechanism: inertial ones from torques, geometric ones from poses."""
