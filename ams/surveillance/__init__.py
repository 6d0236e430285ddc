"""Sensors over the years: comparison, control charts, as found and as left, advice on intervals."""
