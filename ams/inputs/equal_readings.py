"""How likely chance puts readings on the very same number, by the step that they come in and their noise."""

from math import pi, sqrt


def chance_of_a_number(step: float, sd: float) -> float:
    """Return the largest probability that a reading of standard deviation ``sd`` is one number, a ``step`` wide.

    It is the density of a normal distribution at its middle times the step, and at most 1. Two readings of one quantity
    are equal with that of their difference, whose standard deviation is √2 times as large.
    """
    return min(step / (sqrt(2.0 * pi) * sd), 1.0) if sd > 0.0 else 1.0
