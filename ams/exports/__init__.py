"""One file a format in which a coefficient set leaves, and the reading back that verifies it."""
