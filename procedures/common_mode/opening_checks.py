"""The check set that an epoch opened with: what its first reference visit is compared with.

Before that visit nothing else was measured twice, so a table that slips in between is seen here or not at all.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from procedures.common_mode.sensed_axes import attitude_of
from procedures.records.dwells import DwellRecord


@dataclass(frozen=True)
class CheckedVisit:
    """The dwells of a visit that stand where the check set stood, and those of the check set, pair by pair."""

    before: tuple[DwellRecord, ...]
    after: tuple[DwellRecord, ...]
    taken: int
    """Dwells learned from when the check set began."""
    since: tuple[int, ...]
    """Steps of the design since then."""

    @property
    def between(self) -> str:
        """What the visit is compared with, but for its own number."""
        epoch = self.before[0].epoch
        return "between the check set and visit" if epoch == 1 else f"between the check set of epoch {epoch} and visit"


class OpeningChecks:
    """Of the epoch that is measured. One package stands in it, so there is one mounting."""

    def __init__(self, plateau_of: Mapping[int, int]) -> None:
        self._plateau_of = plateau_of
        self._epoch, self._taken = 0, 0
        self._plateau: int | None = None
        self._dwells: dict[int, DwellRecord] = {}
        self._since: list[int] = []

    def saw(self, dwell: DwellRecord, taken: int) -> None:
        """Take any dwell in, whether it counts or not. ``taken``: how many were learned from before it."""
        if dwell.epoch != self._epoch:
            self._epoch, self._taken, self._plateau = dwell.epoch, taken, None
            self._dwells, self._since = {}, []
        if dwell.purpose != "check" and self._plateau is None:
            # A run that is taken up again measures the check set at the plateau of what it measures next.
            self._plateau = self._plateau_of.get(dwell.step, 0)
        if dwell.accepted and dwell.purpose == "check":
            self._dwells[dwell.step] = dwell
        elif dwell.accepted and dwell.purpose == "design":
            self._since.append(dwell.step)

    def take_back(self, steps: Iterable[int]) -> None:
        """Forget voided dwells, which are measured again."""
        gone = set(steps)
        self._dwells = {step: dwell for step, dwell in self._dwells.items() if step not in gone}
        self._since = [step for step in self._since if step not in gone]

    def paired(self, visit: Sequence[DwellRecord]) -> CheckedVisit | None:
        """Return what of a visit can be compared with the check set of its epoch; None where nothing can.

        Neither what an earlier epoch measured of the visit, nor what stood at another plateau, can be.
        """
        checked = {attitude_of(dwell): dwell for dwell in self._dwells.values()}
        after = tuple(
            dwell
            for dwell in visit
            if dwell.epoch == self._epoch
            and self._plateau_of.get(dwell.step, 0) == self._plateau
            and attitude_of(dwell) in checked
        )
        if not after:
            return None
        before = tuple(checked[attitude_of(dwell)] for dwell in after)
        return CheckedVisit(before, after, self._taken, tuple(self._since))
