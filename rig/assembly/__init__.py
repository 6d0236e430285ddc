"""The one place that chooses real, twin or replayed; twins on real ports; what is plugged in."""
