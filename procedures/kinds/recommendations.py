"""TP's ten recommendations, each with whether a plan follows it, and why it matters.

Source: TP, concluding remarks, 1 to 10.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees

import numpy as np

from procedures.plan.design_kind import DESIGNS
from procedures.plan.plan import Plan
from procedures.plan.sequential import CALIBRATION_OVER_USAGE
from procedures.solution.beliefs import AxisBelief
from procedures.solution.expected import ExpectedSensor

LEAST_REPLICATIONS = 6
BOTH_WAYS = ("there-and-back", "forward-reverse", "neighbours")
WORST_SIDEWAYS = 10.0
"""How much coarser than x the axes beside it may be, and roll than the pitch that is wanted."""
FULL_CIRCLE_DEG = 270.0
"""What the roll values must span: twelve of them on the circle span 330°."""
SINGULAR_DEG = 80.0
"""Pitch beyond which roll is hardly told."""


@dataclass(frozen=True)
class Recommendation:
    """One of the ten."""

    number: int
    text: str
    reason: str
    is_followed: bool | None
    """None: it is about other sensors or other plans."""
    found: str = ""
    """What stands in its way."""

    @property
    def advice(self) -> str:
        """The sentence where it is not followed, else nothing."""
        if self.is_followed is not False:
            return ""
        return f"{self.found or self.text} (TP recommendation {self.number}): {self.reason}"


def recommendations(
    plan: Plan, believed: Mapping[tuple[str, str], AxisBelief], sensors: Mapping[str, ExpectedSensor]
) -> tuple[Recommendation, ...]:
    """Return all ten."""
    return (*_of_the_design(plan), *_of_the_run(plan), *_of_the_sensors(plan, believed, sensors))


def _of_the_design(plan: Plan) -> Iterator[Recommendation]:
    low, high = min(plan.design.pitch_values_deg), max(plan.design.pitch_values_deg)
    used = plan.usage_pitch_deg
    wide = None if used is None else high - low >= CALIBRATION_OVER_USAGE * (used[1] - used[0]) - 1e-9
    inside = used is not None and low <= used[0] and used[1] <= high
    yield Recommendation(
        1,
        "the calibration range should be 150 % of the usage range",
        "the variance of a prediction grows towards the ends of the calibrated range",
        None if not inside else wide,
    )
    rolls, has_roll = plan.design.roll_values_deg, plan.design.has_roll
    yield Recommendation(
        2,
        "roll should cover the full circle",
        "azimuth and offset are told apart by it, and the variance is the same at every roll",
        max(rolls) - min(rolls) >= FULL_CIRCLE_DEG if has_roll else None,
    )
    design_kind = DESIGNS.get(plan.design.kind)
    is_gridded = design_kind is None or not (design_kind.is_thinned or "file" in design_kind.takes)
    is_even = all(_is_even(values) for values in (plan.design.pitch_values_deg, rolls))
    yield Recommendation(
        3,
        "test points should be uniformly spaced in pitch and roll",
        "periods of the table and of the sensor are seen wherever they lie",
        is_even and is_gridded,
        "the points are not uniformly spaced in pitch and roll",
    )


def _is_even(values: tuple[float, ...]) -> bool:
    """Return whether angles are spaced alike, to what a lattice of the table allows."""
    steps = np.diff(sorted(set(values)))
    return steps.size < 2 or float(steps.max() - steps.min()) <= max(1.0, 0.1 * float(steps.max()))


def _of_the_run(plan: Plan) -> Iterator[Recommendation]:
    yield Recommendation(
        4,
        "pitch should go from its least to its greatest angle and back",
        "a drift and the sense of the approach do not pass for a sensitivity",
        plan.order in BOTH_WAYS or plan.order in ("blocks", "random", "seeded"),
        f'the order "{plan.order}" goes one way only: pitch should go to its greatest angle and back',
    )
    design_kind = DESIGNS.get(plan.design.kind)
    yield Recommendation(
        5,
        "a thinned design should be shown to be adequate",
        "what lies between its points is seen by the test on lack of fit only, which wants two replications or more",
        plan.replications > 1 if design_kind is not None and design_kind.is_thinned else None,
    )
    yield Recommendation(
        6,
        "calibrations should be replicated six times, better ten",
        "drift and lack of fit want them",
        plan.replications >= LEAST_REPLICATIONS,
        f"{plan.replications} replication{'s' if plan.replications > 1 else ''}: {LEAST_REPLICATIONS} or more",
    )
    yield Recommendation(
        7,
        "a tumble test is not recommended for laboratory calibration",
        "four or six points leave nothing to judge the model by",
        design_kind is None or not design_kind.is_tumble,
    )


def _of_the_sensors(
    plan: Plan, believed: Mapping[tuple[str, str], AxisBelief], sensors: Mapping[str, ExpectedSensor]
) -> Iterator[Recommendation]:
    axes = {serial: {axis for name, axis in believed if name == serial} for serial in plan.sensors}
    alone = [serial for serial, senses in axes.items() if senses == {"x"}]
    wanted = [sensors[serial].angles["pitch"].u95_deg for serial in alone if "pitch" in sensors[serial].angles]
    advice = f"roll within {WORST_SIDEWAYS * min(wanted):.2g}°" if wanted else "roll to a tenth as well as pitch"
    yield Recommendation(
        8,
        f"a package of one axis needs {advice} from another instrument at use",
        "its misalignment turns with roll, and a wrong roll is a wrong pitch",
        True if alone else None,
    )
    for number, whose, reason in (
        (9, {"x", "y", "z"}, "roll is told by y and z, and pitch beside them near the vertical"),
        (10, {"x", "y"}, "roll is told by y alone, not at all where it is ±90° or pitch is"),
    ):
        here = [serial for serial, senses in axes.items() if senses == whose]
        worst = max((_sideways(serial, believed, plan.dwell.samples) for serial in here), default=0.0)
        is_steep = number == 10 and max(map(abs, plan.usage_pitch_deg or (0.0,))) > SINGULAR_DEG
        yield Recommendation(
            number,
            f"the axes beside x may be {WORST_SIDEWAYS:g} times as uncertain, no more",
            reason,
            None if not here else worst <= WORST_SIDEWAYS and not is_steep,
            f"the axes beside x scatter {worst:.2g} times as much, or the usage range comes near ±90°: "
            f"at most {WORST_SIDEWAYS:g} times",
        )


def _sideways(serial: str, believed: Mapping[tuple[str, str], AxisBelief], samples: int) -> float:
    """Return how much more than x, as an angle, the worst of the other axes scatters."""
    noise = {
        axis: degrees(belief.noise_v(samples) / float(np.linalg.norm(belief.k_v_per_g)))
        for (name, axis), belief in believed.items()
        if name == serial
    }
    return max(noise.values()) / noise["x"] if noise.get("x") else 1.0
