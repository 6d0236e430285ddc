"""Has a run measured enough? The rule of ``[stop] half_width_deg``, evaluated after a replication.

U95 is foreseen, as `calrig check` does, from what the replications have shown: the precision inside them and the lack
of fit of the points. The spread between replications is not looked at, for it is what the intervals are made from: a
rule that stopped where that spread happens to be small would state intervals that hold the truth in 91 to 93 of 100
runs instead of 95. Where a drift is significant the run goes on to its last replication, and its intervals show it.
"""

from collections.abc import Sequence
from dataclasses import replace

from ams.calibration.solving.expectation import Shown, shown
from ams.errors import AmsError
from procedures.errors import ProcedureError
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord
from procedures.records.sufficiency import Sufficiency
from procedures.solution.beliefs import AxisBelief, beliefs_of
from procedures.solution.by_model import observed
from procedures.solution.expected import Believed, PlannedRows, Usage, expected_sensor
from procedures.solution.request import SensorRows, request_of
from procedures.solution.wild_temperatures import without_wild_temperatures
from rig.defects import defect_text
from rig.description.rig_file import RigDescription
from rig.errors import RigError


def sufficient(rig: RigDescription, plan: Plan, dwells: Sequence[DwellRecord]) -> Sufficiency:
    """Judge whole replications of the design; what cannot be solved is not enough, and says why.

    That of a defect too: all replications are measured then, and no run that goes on ends by it.
    """
    replications = max(dwell.replication for dwell in dwells)
    try:
        return _judged(rig, plan, dwells, replications)
    except (ProcedureError, RigError):
        raise
    except Exception as error:  # noqa: BLE001  a rim: what is judged in between costs no dwell
        found = str(error) if isinstance(error, AmsError) else defect_text(error)
        why = f"replication {replications}: not judged: {found}: one more"
        return Sufficiency(replications, is_enough=False, text=why, half_width_deg={})


def _judged(rig: RigDescription, plan: Plan, dwells: Sequence[DwellRecord], replications: int) -> Sufficiency:
    rule = plan.sequential
    assert rule is not None
    usage = Usage(rule.usage_pitch_deg, rule.usage_noise_arcsec)
    believed = beliefs_of(rig, plan.solve, plan.dwell.samples, replications, plan.sensors)
    halves: dict[str, float] = {}
    drifting: list[str] = []
    for serial, sensor in plan.sensors.items():
        every = SensorRows(serial, sensor, tuple(dwells), rig, plan, f"replication {replications}, {serial}")
        item = without_wild_temperatures(every).item
        observations = observed(item)
        found = shown(observations, request_of(serial, rig, sensor, plan.solve, observations))
        shown_axes = {axis: _as_shown(believed[serial, axis], belief) for axis, belief in found.items()}
        measured = observations.temperature_degc
        degc = None if measured is None else [float(measured.mean())] * replications
        rows = PlannedRows(plan.design.points, replications, degc)
        angles = expected_sensor(rig, plan.solve, serial, sensor, rows, Believed(shown_axes, 1), usage).angles
        halves[serial] = max((angle.u95_deg for angle in angles.values()), default=0.0)
        drifting += [f"{serial} {axis} {name}" for axis, axis_belief in found.items() for name in axis_belief.drifting]
    worst = max(halves, key=lambda name: halves[name])
    sentence = f"replication {replications}: U95 {halves[worst]:.3g}° ({worst}), wanted {rule.half_width_deg:g}°"
    is_met = halves[worst] <= rule.half_width_deg
    if is_met and drifting:
        sentence += f"; a drift is significant ({', '.join(drifting)}), so all replications are measured"
    is_enough = is_met and not drifting and replications >= rule.least_replications
    return Sufficiency(replications, is_enough, f"{sentence}: {'enough' if is_enough else 'one more'}", halves)


def _as_shown(belief: AxisBelief, found: Shown) -> AxisBelief:
    plain = replace(belief, reading_v=0.0, offset_drift_v=0.0, sensitivity_drift=0.0)
    seen = found.belief
    return replace(plain, dwell_v=seen.precision, lack_of_fit_v=seen.lack_of_fit, sampled=seen.sampled)
