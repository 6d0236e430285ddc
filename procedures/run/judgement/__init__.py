"""Whether a dwell, a restart or a mount is to be believed."""
