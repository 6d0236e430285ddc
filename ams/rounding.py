"""A value and its uncertainty as a certificate prints them: two digits of the uncertainty, the value to the same place.

Source: JCGM 100 (GUM) 7.2.6.
"""

import math
from decimal import ROUND_HALF_UP, Decimal

MOST_DECIMALS = 12
"""Beyond this a decimal is below what a double resolves in the values printed here."""


def last_place(uncertainty: float) -> int:
    """Return the exponent of ten of the second significant digit: −4 for 0.0012. 0.0998 rounds to 0.10, so −2."""
    exponent = math.floor(math.log10(uncertainty)) - 1
    return exponent + (round(uncertainty / 10.0**exponent) >= 100)


def to_place(value: float, index: int) -> str:
    """Return the decimal notation with the last digit at 10**index; −0 is printed as 0."""
    index = max(index, -MOST_DECIMALS)
    rounded = Decimal(repr(float(value))).quantize(Decimal(1).scaleb(index), rounding=ROUND_HALF_UP)
    text = f"{rounded:f}"
    return text.removeprefix("-") if not rounded else text


def with_uncertainty(value: float, uncertainty: float | None) -> tuple[str, str]:
    """Return the value and uncertainty as printed; nine digits of the value where no uncertainty is known."""
    if uncertainty is None or not math.isfinite(uncertainty) or uncertainty <= 0.0:
        return f"{value:.9g}", "—"
    decimal_place = last_place(uncertainty)
    printed = to_place(uncertainty, decimal_place) if decimal_place >= -MOST_DECIMALS else f"{uncertainty:.1e}"
    return to_place(value, decimal_place), printed


def significant(value: float, digits: int = 2) -> str:
    """Return a number of a sentence to so many significant digits, without an exponent where that is readable."""
    text = f"{value:.{digits}g}"
    is_readable = math.isfinite(value) and (value == 0.0 or abs(value) >= 10.0**-MOST_DECIMALS)
    return (f"{Decimal(text):f}" if is_readable else text).replace("-", "−")


def signed(value: float, decimals: int) -> str:
    """Return a number of a sentence with its sign, a minus and no hyphen, to so many decimals."""
    return f"{value:+.{decimals}f}".replace("-", "−")


def two_digits(value: float) -> str:
    """Return a magnitude alone as tables have it: two significant digits, a zero among them too, no exponent where
    that is readable; a dash where it is no number.
    """
    if not math.isfinite(value):
        return "—"
    if value == 0.0:
        return "0"
    return to_place(value, last_place(abs(value))) if abs(value) >= 10.0**-MOST_DECIMALS else f"{value:.1e}"
