"""Temperatures of chambers, which speak °C or °F. Twins have their own: what both shared, no law would see."""


def degc_of(value: float, *, is_fahrenheit: bool) -> float:
    """Return in °C what a chamber says in its own unit."""
    return (value - 32.0) / 1.8 if is_fahrenheit else value


def of_degc(degc: float, *, is_fahrenheit: bool) -> float:
    """Return in a chamber's own unit what is meant in °C; not rounded."""
    return degc * 1.8 + 32.0 if is_fahrenheit else degc
