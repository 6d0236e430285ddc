"""A package of calibrated sensors: its lines and terms, how it sits in a model, the attitude that fits its outputs."""
