"""The physical world behind all twins: what turns, what is sensed, what meters find, and its chance."""
