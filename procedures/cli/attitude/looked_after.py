"""Angles with an eye on the outputs that they are read from, and the further readings of a file that this asks for."""

from collections.abc import Callable, Iterator, Sequence

from ams.inference.gyros.aided_rates import AidedAngles
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.monitored import MonitoredAngles
from ams.inference.gyros.rates import GyroAngles
from ams.inference.inference import Inference, Package
from ams.inference.rows.angle_stream import AngleStream
from ams.inference.watch.clipped_outputs import NO_RAILS, Rails
from ams.inference.watch.frozen_outputs import FrozenOutputs, noise_by_column
from ams.inference.watch.standing_outputs import StandingOutputs, can_stand
from ams.inference.watch.watched_axes import Stretch, watch_of
from procedures.cli.attitude.source import OfSamples


class LookedAfter:
    """Angles of a package, of a second one where there is one, and what looks after their outputs.

    ``angles_with`` makes the angles, with what was proven of the rows where they were read before. ``stated``: filters
    and averages as they were asked for, and ``before`` as they are at the rate of a stream.
    """

    def __init__(
        self,
        angles_with: Callable[[Sequence[Stretch] | None], AngleStream],
        package: Package,
        second: Package | None,
        reading_sd_v: float | None,
        stated: OfSamples,
        before: OfSamples,
    ) -> None:
        self._angles_with, self._stated, self._before = angles_with, stated, before
        self._package, self._second, self._reading_sd_v = package, second, reading_sd_v
        self._begin(NO_RAILS)

    def _begin(self, rails: Rails) -> None:
        """Make the angles anew, with the levels that outputs are known to be clipped at."""
        self._rails, self.angles = rails, self._angles_with(None)
        self.watched = _watched(self.angles, self._package)
        self.packages = _packages_of(self.angles, self._package, self._second)
        self.found = self._with_eye_on_outputs(self.watched)

    def _with_eye_on_outputs(self, inner: AngleStream) -> FrozenOutputs:
        return FrozenOutputs(
            self._stated.held_to(self._before.before(inner)),
            noise_by_column(self.packages, self._reading_sd_v),
            packages=self.packages,
            is_by_row=self._before.average_s is None or self._before.low_pass_hz is None,
            untested=_untested(self.angles, self.watched),
            rails=self._rails,
        )

    def again(self) -> Iterator[AngleStream]:
        """Yield what the rows of a file are to be answered with again, once all were answered with the one before.

        First without clipped rows that nothing told of yet, so that no other test takes them for readings.
        """
        if self.found.clipped.has_unflagged():
            self._begin(self.found.clipped.rails())
            yield self.found
        again = _again(self.watched, self.angles, self._angles_with)
        if again is not None:
            yield self._with_eye_on_outputs(again)


def _watched(angles: AngleStream, package: Package) -> AngleStream | StandingOutputs:
    """Return the angles with an eye on outputs that no other output tests: one or two accelerometers alone."""
    return StandingOutputs(angles) if isinstance(angles, Inference) and can_stand(package) else angles


def _again(
    watched: AngleStream, angles: AngleStream, angles_with: Callable[[Sequence[Stretch] | None], AngleStream]
) -> AngleStream | None:
    """Return the angles of rows that were read before, with what all of them prove; None where that is nothing."""
    if isinstance(watched, StandingOutputs):
        return watched.again()
    watch = watch_of(angles)
    proven = () if watch is None else watch.proven()
    return angles_with(proven) if proven or (watch is not None and watch.flagged_rows) else None


def _untested(angles: AngleStream, watched: AngleStream | StandingOutputs) -> tuple[str, ...]:
    """Return the columns that no other output tests: one or two accelerometers, and gyros."""
    if isinstance(watched, StandingOutputs):
        return tuple(watched.package.columns.values())
    if isinstance(angles, MonitoredAngles):
        angles = angles.gyros
    gyros = (
        angles.package if isinstance(angles, GyroAngles) else angles.gyros if isinstance(angles, AidedAngles) else None
    )
    return () if gyros is None else tuple(gyros.columns.values())


def _packages_of(angles: AngleStream, package: Package, second: Package | None) -> list[Package | GyroPackage]:
    """Return every package that rows are read from."""
    found: list[Package | GyroPackage] = [package, *([] if second is None else [second])]
    if isinstance(angles, AidedAngles):
        found.append(angles.accelerometers)
    if isinstance(angles, MonitoredAngles) and isinstance(angles.gyros, GyroAngles):
        found.append(angles.gyros.package)
    return found
