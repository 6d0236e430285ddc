"""Rows of readings on their way: piece by piece, their times, averages and filters, and where sets are not valid."""
