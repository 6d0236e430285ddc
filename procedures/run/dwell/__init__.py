"""One dwell performed: settle, measure, turn, follow a motion, record streams."""
