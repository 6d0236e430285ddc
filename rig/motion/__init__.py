"""Move and arrive; by hand; where home is."""
