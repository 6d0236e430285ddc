"""Which inputs of a meter a key or a switch at its panel selects: no command turns it, and a hand does at any time."""

from typing import Literal

from rig.errors import DeviceRefused

Inputs = Literal["front", "rear"]


class SelectedInputs:
    """The inputs that a burst of the readout ``name`` needs: those of its file, else the first that were seen selected.

    They hold as long as the line is open, however often the meter is prepared anew. What was selected at an earlier
    opening stands in the identity, which whoever opens the line compares. ``declared``: ``terminals`` of its file.
    """

    def __init__(self, name: str, declared: Inputs | None) -> None:
        self._name = name
        self._declared = declared
        self._needed = declared

    def require_declared(self, selected: Inputs) -> None:
        """Compare with the file alone: an identity says what is selected now. Raises: DeviceRefused."""
        self._compare(selected, self._declared, "nothing was measured")
        self._needed = self._needed or selected

    def require(self, selected: Inputs, outcome: str) -> None:
        """Compare with what is needed. Raises: DeviceRefused, which says ``outcome`` and what to do."""
        self._needed = self._needed or selected
        self._compare(selected, self._needed, outcome)

    def _compare(self, selected: Inputs, need: Inputs | None, outcome: str) -> None:
        if need not in (None, selected):
            left_out = "terminals is left out, and those were selected first"
            by = left_out if self._declared is None else "terminals"
            raise DeviceRefused(
                f"{self._name}: the {selected} inputs are selected, need those at the {need}"
                f" (readouts.{self._name}: {by}); {outcome}; press the key at the meter"
            )
