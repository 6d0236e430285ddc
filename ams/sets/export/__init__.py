"""Exports of a coefficient set, one file a format: written whole, each read back by ``verify``."""
