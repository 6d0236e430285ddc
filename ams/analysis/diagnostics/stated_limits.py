"""What the stated uncertainties of an axis hold of what its tests find, where it depends on the size."""

from dataclasses import dataclass, replace
from typing import Final

from ams.analysis.diagnostics.beliefs import AT_A_LOCATION, DRIFT_OF, LACK_OF_FIT, ROBUST, AxisTests, BeliefTest

LARGEST_LACK: Final = 0.01
"""Of the sensitivity, or half a degree near level: no table, base or mount that is declared does as much, and no sensor
whose nonlinearity is not. Of a straight line, of half of what it spans."""
MOST_MOVED: Final = 6.0
"""How many times the difference of a robust fit dwells to one side move an offset: simulated for 5 to 20 % of them at 4
to 8 standard deviations, 1.2 to 7."""


@dataclass(frozen=True)
class StatedLimits:
    """Of one axis, in the unit of its output."""

    lack_of_fit: float
    """The largest that the stated uncertainties may hold."""
    offset_expanded: float
    """The expanded uncertainty of the offset."""
    is_of_other_angles: bool = False
    """Whether other signs or another order of the angles are told to explain a lack of fit: nothing holds that."""

    is_differing: bool = False
    """Whether replications differ by more than a scatter that is stated may be: their drift is no such scatter."""

    is_alike: bool = False
    """Whether a lack of fit goes alike over the attitudes of an index: it is stated as one that differs between them.
    """

    departure: float = 0.0
    """The largest from its equation that is declared of the sensor."""

    def judged(self, tests: AxisTests) -> AxisTests:
        """Return the tests, each with whether what it finds is held."""
        return replace(tests, tests={name: self._judged(test) for name, test in tests.tests.items()})

    def _judged(self, test: BeliefTest) -> BeliefTest:
        is_held = test.is_held
        if test.name == LACK_OF_FIT:
            is_held = not (
                self.is_of_other_angles
                or (self.is_alike and test.size > self.departure)
                or test.size > self.lack_of_fit
            )
        elif test.name == AT_A_LOCATION:
            is_held = test.size <= self.departure
        elif test.name == ROBUST:
            is_held = MOST_MOVED * abs(test.size) <= self.offset_expanded
        elif self.is_differing and test.name.startswith(DRIFT_OF):
            is_held = False
        return test if is_held == test.is_held else test._replace(is_held=is_held)
