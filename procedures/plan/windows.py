"""How many readings a window of the settling test may have."""

FEWEST_READINGS, MOST_READINGS = 5, 10
