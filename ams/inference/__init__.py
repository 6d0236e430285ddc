"""From a coefficient set and readings to angles with standard deviations."""
