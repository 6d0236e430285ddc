"""What was known of the sensors of a run before it, and when it ended."""

from collections.abc import Mapping
from contextlib import suppress

from ams.archive.histories import history
from ams.archive.runs import PublishedRun
from ams.archive.signatures import sign_off
from ams.errors import ArchiveError, OutsideValidity
from ams.sets.coefficients import CoefficientSet
from ams.surveillance.adjustment import Adjustment, acceptance_of, adjust
from procedures.report.view import Past
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor


def past_of(
    record: RunRecord,
    sensors: Mapping[str, SolvedSensor],
    sets: Mapping[str, CoefficientSet],
    archived: PublishedRun | None,
    archive_url: str | None,
) -> Past:
    """Return as found, as left and the calibrations before, as the archive knew them when this run ended."""
    standing = {name: coefficients for name, coefficients in sets.items() if coefficients.withdrawal is None}
    if archived is None or archive_url is None:
        gone = () if archive_url is None else tuple(made for made in sets.values() if made.withdrawal is not None)
        withdrawn = {made.sensor: sign_off(str(archive_url), made.sha256) for made in gone}
        return Past(as_left(record, sensors, standing), signed=withdrawn)
    try:
        histories = {name: history(archive_url, name, until_utc=made.created_utc) for name, made in standing.items()}
    except ArchiveError:  # what was published stands; the look at the years before is told where the command looks
        histories = {}
    signed = {}
    for name, coefficients in sets.items():
        with suppress(ArchiveError):
            signed[name] = sign_off(archive_url, coefficients.sha256)
    before = {name: past for name, past in histories.items() if len(past.history.labels) > 1}
    return Past(archived.adjustments, before, signed)


def as_left(
    record: RunRecord, sensors: Mapping[str, SolvedSensor], sets: Mapping[str, CoefficientSet]
) -> dict[str, Adjustment]:
    """Return the new sets on their own data: without an archive nothing is known of before."""
    adjustments = {}
    for name, coefficients in sets.items():
        accepted = acceptance_of(coefficients.provenance)
        with suppress(OutsideValidity):  # a set that tells no angles (gyros, packages of CR)
            solved = sensors[name]
            adjustments[name] = adjust(
                None, coefficients, solved.observations, accepted, record.plan.usage_pitch_deg, None, solved.reference
            )
    return adjustments
