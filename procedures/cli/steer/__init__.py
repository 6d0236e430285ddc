"""Runs that are there: looking at them, steering them, and what people do beside."""
