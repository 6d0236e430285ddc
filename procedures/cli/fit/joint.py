"""``calrig fit --joint``: package and table in one fit, under what the rig and the operator state of the table."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ams.calibration.joint_document import joint_calibration, joint_document, read_mountings
from ams.calibration.jointly import solve_jointly, with_level
from ams.calibration_result import with_findings
from ams.inputs.copied_replications import refuse_copies
from ams.inputs.csv_table import CsvForm
from ams.inputs.possible_outputs import refuse_impossible_outputs, refuse_overloads
from ams.inputs.request import CalibrationRequest
from ams.solve.table_errors import TablePriors
from ams.units import RAD_PER_ARCSEC
from procedures.cli.fit.coefficient_set import WishedSet, write_set
from procedures.errors import RequestError
from procedures.plan.undeclared import LEVEL_PRIORS
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.meter_reach import meter_reach
from procedures.solution.request import budgets_of, joint_priors_in_words
from procedures.solution.said_of_file import recorded_temperatures, said_of_file
from procedures.solution.sensor_of_file import sensor_of
from procedures.solution.temperature_of_use import at_use
from procedures.solution.type_b import table_uncertainty
from rig.description.rig_file import RigDescription

PRIORS = {
    "pitch-zero": "pitch_zero_rad",
    "roll-zero": "roll_zero_rad",
    "base-tilt": "base_tilt_rad",
    "squareness": "squareness_rad",
    "droop": "droop_rad",
    "seat": "seat_rad",
}
"""Name on the command line to its prior."""


def joint(
    file: Path,
    form: CsvForm,
    columns: Mapping[str, str],
    rig: RigDescription,
    priors: Mapping[str, float],
    mount: str | None,
    wish: WishedSet | None,
    *,
    sensor: str | None,
    request: CalibrationRequest,
    doubts: tuple[str, ...],
) -> dict[str, Any]:
    """Solve the file with the table's errors as unknowns, and write the set wished for.

    ``doubts``: of the rig's standards on the day of the readings. Raises: ams.errors.AmsError.
    """
    mountings, measured = read_mountings(file, columns, mount, form), sensor_of(rig, sensor)
    for mounting in mountings:
        refuse_copies(mounting.observations)
        refuse_overloads(mounting.observations, columns)
        refuse_impossible_outputs(mounting.observations, columns, meter_reach(rig, measured))
    given = {PRIORS[name]: value * RAD_PER_ARCSEC for name, value in priors.items()}
    mountings = [
        replace(mounting, observations=with_scanned_volts(mounting.observations, rig, measured))
        for mounting in mountings
    ]
    rows = [mounting.observations for mounting in mountings]
    request = at_use(request, measured, recorded_temperatures(rows))
    stated = with_level(TablePriors(table=table_uncertainty(rig), **given), request.shared_errors)
    found, diagnosis = solve_jointly(mountings, tuple(columns), request, stated)
    stands_level = {name.replace("-", "_") for name in priors} >= LEVEL_PRIORS
    said = said_of_file(rows, columns, request, rig, sensor, stands_level=stands_level)
    calibration = joint_calibration(found, diagnosis, (*doubts, *said.warnings), said.remarks)
    budgets = budgets_of(calibration, request, rig, priors_in_words=joint_priors_in_words(priors.items()))
    solved = with_findings(calibration, said.undeclared.findings)
    if wish is not None:
        write_set(wish, rows[0], solved, sum(mounting.rows for mounting in rows))
    return {**joint_document(found, solved, budgets), "model": "pitch-roll", "convention": "TP"}


def check_joint(request: CalibrationRequest, rig: RigDescription | None) -> RigDescription:
    """Return the rig of a joint fit.

    Raises: RequestError where the joint fit does not go with what else is asked for.
    """
    if rig is None:
        raise RequestError("--joint: needs --rig RIG: the table's uncertainties are the priors of its errors")
    if request.model != "pitch-roll" or request.temperature != "none" or request.extended == "test":
        raise RequestError("--joint: goes with --model pitch-roll, --temperature none and --extended yes or no")
    if request.time_term or request.residual_curvature:
        raise RequestError("--joint: has no --time-term and no --hessian; fit without --joint for these")
    return rig


def parse_priors(pairs: list[str] | None) -> dict[str, float]:
    """``["roll-zero=10"]`` as ``{"roll-zero": 10.0}``, arc seconds."""
    found: dict[str, float] = {}
    for pair in pairs or ():
        name, _, text = pair.partition("=")
        try:
            value = float(text)
        except ValueError:
            value = -1.0
        if name not in PRIORS or name in found or not 0.0 < value < 36_000.0:
            raise RequestError(
                f"--prior {pair}: allowed is NAME=ARCSEC, above 0 and below 36000 arc seconds, each of "
                f"{', '.join(PRIORS)} at most once"
            )
        found[name] = value
    return found


def joint_lines(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table's own errors for a person.

    Those of the whole table and the seat, then what stays confounded.
    """
    whole = {name: entry for name, entry in document["nuisances"].items() if " tooth " not in name}
    yield ""
    yield f"table: {len(document['nuisances']) - len(whole)} teeth and {len(whole)} errors of the whole"
    for name, entry in whole.items():
        remark = "" if entry["is_observed"] else "   (not told by these rows)"
        yield (
            f"  {name:<28} {entry['estimate_arcsec']:+.2f}″   u {entry['standard_deviation_arcsec']:.2g}″"
            f"   (prior {entry['prior_arcsec']:.3g}″){remark}"
        )
    yield from (f"  confounded: {sentence}" for sentence in document["confounded"])
