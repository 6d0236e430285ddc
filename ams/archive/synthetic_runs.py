"""The synthetic archive as runs: every calibration measured on a grid, solved, and published like a real one.

What :mod:`ams.archive.synthetic` draws as coefficients becomes observations of a small grid in three replications, and
those go the whole way: solution, coefficient set with its test vectors, as found, as left, archive. All of it is
stamped simulated.
"""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import timedelta
from itertools import groupby

import numpy as np

from ams.archive.runs import MeasuredSensor, RunEntry, publish_run
from ams.archive.synthetic import AXES, GRAVITY_MPS2, RIG, SyntheticArchive, campaigns
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance
from ams.surveillance.series import PointLabel
from ams.units import RAD_PER_ARCSEC

PITCH_DEG = (-60.0, -30.0, 0.0, 30.0, 60.0)
ROLL_DEG = (-180.0, -90.0, 0.0, 90.0)
REPLICATIONS = 3
READING_ARCSEC = 1.0
LIMIT_DEG = 0.02
SOFTWARE = "synthetic"


@dataclass(frozen=True)
class Campaign:
    """One run on the rig with every sensor in it."""

    run: RunEntry
    sensors: Sequence[MeasuredSensor]


def publish_synthetic(archive_url: str, archive: SyntheticArchive, chance: np.random.Generator) -> int:
    """Publish every campaign, oldest first; returns how many sets there are. Raises: ArchiveError."""
    count = 0
    for campaign in measured_campaigns(archive, chance):
        publish_run(archive_url, campaign.run, campaign.sensors, campaign.run.ended_utc)
        count += len(campaign.sensors)
    return count


def measured_campaigns(archive: SyntheticArchive, chance: np.random.Generator) -> Iterator[Campaign]:
    """Yield every campaign with its sensors measured and solved, oldest first."""
    for run_id, rows in groupby(campaigns(archive), key=lambda row: row[0].run_id):
        calibrations = list(rows)
        digest = hashlib.sha256(str(run_id).encode()).hexdigest()
        sensors = [_measured(label, primary, digest, chance) for label, primary in calibrations]
        started, ended = (pick(label.created_utc for label, _ in calibrations) for pick in (min, max))
        entry = RunEntry(
            journal_sha256=digest,
            run_id=str(run_id),
            title="synthetic calibration",
            rig=RIG,
            operator="synthetic",
            simulated=True,
            started_utc=started - timedelta(hours=1),
            ended_utc=ended,
            folder="",
            software_version=SOFTWARE,
        )
        yield Campaign(entry, sensors)


def _measured(label: PointLabel, primary: FloatArray, digest: str, chance: np.random.Generator) -> MeasuredSensor:
    observations = _observed(primary, chance)
    solved = calibrate(observations, CalibrationRequest(nominal_axes={axis: axis for axis in AXES}, extended="no"))
    return MeasuredSensor(build_set(solved, _provenance(label, digest)), observations, label.is_check)


def _observed(primary: FloatArray, chance: np.random.Generator) -> Observations:
    pitch, roll = (part.ravel() for part in np.meshgrid(np.radians(PITCH_DEG), np.radians(ROLL_DEG), indexing="ij"))
    points = pitch.size
    clean = np.concatenate([np.ones((points, 1)), specific_force(pitch, roll)], axis=1) @ primary.T
    noise = 2.5 * READING_ARCSEC * RAD_PER_ARCSEC * chance.normal(size=(REPLICATIONS, points, len(AXES)))
    outputs = (clean + noise).reshape(-1, len(AXES))
    return Observations(
        np.repeat(np.arange(1, REPLICATIONS + 1), points),
        np.tile(np.arange(1, points + 1), REPLICATIONS),
        np.tile(pitch, REPLICATIONS),
        np.tile(roll, REPLICATIONS),
        {axis: outputs[:, index].copy() for index, axis in enumerate(AXES)},
        source=f"synthetic, {points} points",
    )


def _provenance(label: PointLabel, digest: str) -> Provenance:
    return Provenance(
        sensor=label.sensor,
        serial=label.sensor.removeprefix("SN"),
        sensor_model="three-axis package",
        gravity_mps2=GRAVITY_MPS2,
        gravity_source="synthetic",
        pitch_range_deg=(min(PITCH_DEG), max(PITCH_DEG)),
        roll_range_deg=(-180.0, 180.0),
        created_utc=label.created_utc,
        software_version=SOFTWARE,
        rig=RIG,
        procedure="synthetic calibration",
        simulated=True,
        operator="synthetic",
        run_id=label.run_id,
        journal_sha256=digest,
        acceptance={"pitch_limit_deg": LIMIT_DEG, "decision_rule": "guard-band"},
    )
