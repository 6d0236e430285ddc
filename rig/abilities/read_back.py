"""What a meter or scanner is held to when it is asked for its settings and its errors, whatever language it speaks."""

from typing import Final

READ_BACK_TOLERANCE: Final = 1e-3
"""By which part of itself a setting may read back otherwise: units round what they are told."""
LONGEST_ERROR_LIST: Final = 40
"""More than any unit keeps: a list that goes on says the same error again and again."""
