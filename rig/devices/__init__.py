"""Abilities (axis, readout, environment, stream, field) and one file a device family; no port."""
