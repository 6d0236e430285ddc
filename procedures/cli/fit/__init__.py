"""``calrig fit``: observations in a file to coefficients."""
