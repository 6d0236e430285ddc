"""``calrig attitude``: readings of a calibrated package to angles, from files and streams."""
