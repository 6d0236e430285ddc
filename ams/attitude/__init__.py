"""Attitude from outputs, on plain arrays: static packages, gyro, quaternion, Kalman filter, filters."""
