"""What declarations of rig and procedure foil between them: each is sound by itself, and together they cannot work."""

from collections.abc import Iterator

from procedures.kinds.kind import Forecast
from procedures.plan.plan import Plan
from procedures.plan.unjudged_limits import limits_in_words, limits_of_some
from rig.description.rig_file import RigDescription


def foiled(rig: RigDescription, plan: Plan, forecast: Forecast) -> Iterator[str]:
    """Yield what the run would be stopped by though all goes well, and what no sensor can be found to meet."""
    yield from _stable_and_stopped(rig, plan)
    yield from _never_passed(rig, forecast)
    yield from _not_judged(rig, plan, forecast)


def _stable_and_stopped(rig: RigDescription, plan: Plan) -> Iterator[str]:
    environment = plan.environment
    if environment is None or environment.name not in rig.interlocks.temperature:
        return
    lock = rig.interlocks.temperature[environment.name]
    (low, high), within = lock.band_degc, environment.band_degc
    for degc in sorted(set(environment.plateaus_degc)):
        ends = [end for end in (degc - within, degc + within) if not low <= end <= high]
        if ends:
            stopped_at = " and ".join(f"{end:g}" for end in ends)
            yield (
                f"[environment] takes {degc:g} ± {within:g} °C for stable, and "
                f"interlocks.temperature.{environment.name} would {lock.action} the run at {stopped_at} °C (band "
                f"{low:g} to {high:g} °C): widen the interlock's band_degc, or take a smaller band_degc of the plateaus"
            )


def _not_judged(rig: RigDescription, plan: Plan, forecast: Forecast) -> Iterator[str]:
    """Yield limits that the run does not judge, of all its sensors or of some."""
    if not forecast.judged_by:
        yield from limits_of_some(rig, plan.solve, plan.sensors)
        return
    for limit in limits_in_words(rig):
        yield f"{limit} of the rig file is judged of calibrations; this run is held to {forecast.judged_by}"


def _never_passed(rig: RigDescription, forecast: Forecast) -> Iterator[str]:
    """Yield limits that are no wider than what the calibration alone leaves: the guard band takes all of them."""
    if rig.acceptance.decision_rule != "guard-band":
        return
    for name, limit_deg in (("pitch", rig.acceptance.pitch_limit_deg), ("roll", rig.acceptance.roll_limit_deg)):
        left = {serial: angles[name].calibration_deg for serial, angles in forecast.angles.items() if name in angles}
        missed = {serial: u95_deg for serial, u95_deg in left.items() if limit_deg is not None and u95_deg >= limit_deg}
        if missed:
            least_deg = min(missed.values())
            yield (
                f"acceptance.{name}_limit_deg = {limit_deg:g} cannot be passed by {', '.join(missed)}: the guard band "
                f"wants |error| + U95 inside the limit, and U95 is {least_deg:.2g}° or more for a perfect sensor; "
                "widen the limit, or calibrate better"
            )
