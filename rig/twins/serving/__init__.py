"""Twins on real ports, with the faults of their lines, told by the engine which step it measures."""
