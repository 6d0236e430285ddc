"""``calrig devices``: what is plugged in here."""
