"""A small run on twins whose lines, axes or sensors suffer a stated fault; a second package where others must go on."""

from pathlib import Path

from small_run import Bench, bench
from unattended_run import UnattendedRun

from procedures.run.begin import begin
from procedures.run.ending import Outcome
from procedures.run.services import RunServices
from rig.assembly.open_rig import open_rig
from rig.description.fault_plan import FaultPlan

SECOND = (
    (
        "z = { scanner = 3, range_v = 10.0 } }",
        "z = { scanner = 3, range_v = 10.0 }, u = { scanner = 4, range_v = 10.0 }, "
        "v = { scanner = 5, range_v = 10.0 } }",
    ),
    (
        "[twin]\nseed = 7",
        '[sensors.SN2]\nmodel = "two-axis package"\nchannels = { x = "dmm.u", y = "dmm.v" }\n'
        "nominal_sensitivity_v_per_g = 2.5\n[twin]\nseed = 7",
    ),
    (
        "[twin.truth.SN1]",
        "[twin.truth.SN2]\n"
        "x = { offset_v = 0.002, sensitivity_v_per_g = 2.51, coning_deg = 0.2, azimuth_deg = 15.0, noise_v = 2e-5 }\n"
        "y = { offset_v = 0.001, sensitivity_v_per_g = 2.49, coning_deg = 0.6, azimuth_deg = 80.0, noise_v = 2e-5 }\n"
        "[twin.truth.SN1]",
    ),
)
"""Changes of the small rig that put a second package beside the first."""


def two_packages(folder: Path, procedure: tuple[tuple[str, str], ...] = ()) -> Bench:
    return bench(folder, rig=SECOND, procedure=procedure)


def faults(**rules: dict[str, object]) -> FaultPlan:
    """A fault file: rule name to its keys, as in :mod:`rig.description.fault_plan`."""
    return FaultPlan.model_validate({"seed": 3, "fault": rules})


def run_with_faults(
    small: Bench, unattended: UnattendedRun, plan: FaultPlan, services: RunServices | None = None
) -> tuple[Outcome, list[str]]:
    """Run with nobody there and with the faults; return also what the faulty lines told."""
    unattended.run_dir.mkdir()
    messages: list[str] = []
    with open_rig(small.rig, faults=plan, tell_fault=messages.append) as rig:
        unattended.rig = rig
        header = small.header(unattended.run_dir)
        return begin(unattended.run_dir, header, small.plan, rig, unattended, unattended, services), messages
