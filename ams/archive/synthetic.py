"""A synthetic archive: what fifty three-axis packages, calibrated twice a year for eight years, leave behind.

Truth: every sensor has offsets, sensitivities and small misalignments of its own. Every calibration adds a day (offset
and sensitivity of every axis, the same for nobody), a remount (one small rotation) and the calibration's own noise.
Among them a few *drift* in one sensitivity, one *dropped* (offset and an angle between axes), two were *mixed up* in
one campaign. A check sensor stays mounted on the rig and is calibrated in every campaign.

All numbers are drawn from the generator that is passed; the same seed gives the same archive.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np

from ams.arrays import FloatArray
from ams.surveillance.characteristics import PackageNumbers
from ams.surveillance.series import PointLabel, Population
from ams.units import RAD_PER_ARCSEC

AXES = ("x", "y", "z")
CHECK_SENSOR = "CHECK-1"
RIG = "synthetic laboratory"
GRAVITY_MPS2 = 9.79826
START = datetime(2018, 1, 15, 6, 0, tzinfo=UTC)


@dataclass(frozen=True)
class Story:
    """What is told, and how large."""

    sensors: int = 50
    years: int = 8
    per_year: int = 2
    drifting: int = 3
    day_arcsec: float = 2.0
    """Standard deviation of offset and sensitivity from campaign to campaign, each as an angle."""
    remount_arcsec: float = 30.0
    noise_arcsec: float = 0.5
    """Standard uncertainty of b and of each component of k from one calibration."""
    drift_arcsec_per_year: float = 4.0
    drop_arcsec: float = 40.0

    @property
    def campaigns(self) -> int:
        return self.years * self.per_year


@dataclass(frozen=True)
class SyntheticArchive:
    """The calibrations, and who did what."""

    population: Population
    drifting: tuple[str, ...]
    dropped: tuple[str, ...]
    mixed_up: tuple[str, str]

    @property
    def sound(self) -> tuple[str, ...]:
        """Sensors that nothing happened to, the check sensor among them."""
        guilty = {*self.drifting, *self.dropped, *self.mixed_up}
        names = dict.fromkeys(label.sensor for label in self.population.labels)
        return tuple(name for name in names if name not in guilty)


def synthetic_archive(chance: np.random.Generator, story: Story | None = None) -> SyntheticArchive:
    """Make calibrations of every sensor in every campaign."""
    chosen = story or Story()
    names = [f"SN{1001 + index}" for index in range(chosen.sensors)]
    picked = [names[index] for index in chance.permutation(chosen.sensors)[: chosen.drifting + 3]]
    drifting, (dropped, *mixed) = tuple(picked[: chosen.drifting]), picked[chosen.drifting :]
    levels = {name: _levels_of_a_sensor(chance) for name in (*names, CHECK_SENSOR)}
    fall, swap = (int(chance.integers(low, chosen.campaigns - 2)) for low in (3, 4))
    rows: list[tuple[PointLabel, FloatArray]] = []
    for campaign in range(chosen.campaigns):
        for index, name in enumerate((*names, CHECK_SENSOR)):
            measured = _really_measured(name, mixed, campaign == swap)
            primary = _as_it_is(levels[measured], measured in drifting, measured == dropped, (campaign, fall), chosen)
            calibrated = _calibrated(primary, chance, chosen, is_remounted=name != CHECK_SENSOR)
            rows.append((_label(name, campaign, index, chosen), calibrated))
    rows.sort(key=lambda row: (row[0].sensor, row[0].created_utc))
    primary = np.stack([values for _, values in rows])
    spread = np.broadcast_to(np.eye(4) * (chosen.noise_arcsec * RAD_PER_ARCSEC * 2.5) ** 2, (*primary.shape, 4)).copy()
    numbers = PackageNumbers(AXES, primary, spread, spread)
    population = Population([label for label, _ in rows], numbers)
    return SyntheticArchive(population, drifting, (dropped,), (mixed[0], mixed[1]))


def _really_measured(name: str, mixed: list[str], is_swap: bool) -> str:
    if is_swap and name in mixed:
        return mixed[1 - mixed.index(name)]
    return name


def _levels_of_a_sensor(chance: np.random.Generator) -> FloatArray:
    """Draw (3, 4) offset and k.

    2.5 V/g within half a percent, offsets of millivolts, misalignments of minutes of arc.
    """
    offset = chance.normal(0.0, 0.005, (3, 1))
    gain = 2.5 * (1.0 + chance.normal(0.0, 0.005, (3, 1)))
    return np.concatenate([offset, gain * (np.eye(3) + chance.normal(0.0, 0.003, (3, 3)))], axis=1)


def _as_it_is(
    level: FloatArray, is_drifting: bool, has_dropped: bool, when: tuple[int, int], story: Story
) -> FloatArray:
    """Return the true parameters of a sensor at a campaign, its drift and accident included."""
    (campaign, fall), primary = when, level.copy()
    if is_drifting:
        primary[0, 1:] *= 1.0 + story.drift_arcsec_per_year * RAD_PER_ARCSEC * campaign / story.per_year
    if has_dropped and campaign >= fall:
        primary[1, 0] += 2.5 * story.drop_arcsec * RAD_PER_ARCSEC
        primary[2, 2] += 2.5 * story.drop_arcsec * RAD_PER_ARCSEC
    return primary


def _calibrated(primary: FloatArray, chance: np.random.Generator, story: Story, *, is_remounted: bool) -> FloatArray:
    """Return what a calibration says: turned by the remount, moved by the day, blurred by its noise."""
    angle = chance.normal(0.0, story.remount_arcsec * RAD_PER_ARCSEC, 3) if is_remounted else np.zeros(3)
    k = primary[:, 1:] + np.cross(angle, primary[:, 1:])
    day = chance.normal(0.0, story.day_arcsec * RAD_PER_ARCSEC, (3, 2))
    offset = primary[:, :1] + 2.5 * day[:, :1]
    whole = np.concatenate([offset, k * (1.0 + day[:, 1:])], axis=1)
    return np.asarray(whole + 2.5 * story.noise_arcsec * RAD_PER_ARCSEC * chance.normal(size=whole.shape))


def _label(name: str, campaign: int, index: int, story: Story) -> PointLabel:
    start = START + timedelta(days=365.25 * campaign / story.per_year)
    when = start + timedelta(hours=index) if name != CHECK_SENSOR else start
    digest = f"{campaign:04d}{index:04d}".ljust(64, "0")
    return PointLabel(digest, name, f"campaign-{campaign:02d}", when, RIG, name == CHECK_SENSOR, GRAVITY_MPS2)


def campaigns(archive: SyntheticArchive) -> Iterator[tuple[PointLabel, FloatArray]]:
    """Yield every calibration with its (3, 4) numbers, oldest first."""
    rows = zip(archive.population.labels, archive.population.numbers.primary, strict=True)
    yield from sorted(rows, key=lambda row: (row[0].created_utc, row[0].sensor))
