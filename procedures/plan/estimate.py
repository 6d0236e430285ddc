"""How long a plan takes: by what past runs of the rig taught, else by what the files say about the devices.

By the files alone, p50 lets every dwell settle at the earliest time its settings allow and repeats none. p90 adds one
more window to every settling and repeats one dwell in twenty: a bad night of a sound rig.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from procedures.description.dwell_settings import DwellSettings
from procedures.plan.adaptive import Reading
from procedures.plan.learned_times import REPEATED, LearnedTimes
from procedures.plan.plan import Expectation
from procedures.plan.step_times import MOVE, SOAK, step_parts, window_s
from procedures.plan.steps import Dwell, Step
from rig.description.rig_file import RigDescription

NOTHING_LEARNED = LearnedTimes()


def expected_duration(
    rig: RigDescription,
    steps: Sequence[Step],
    dwell: DwellSettings,
    channels: Sequence[str],
    learned: LearnedTimes = NOTHING_LEARNED,
    readings: Mapping[str, Reading] = MappingProxyType({}),
) -> Expectation:
    """Return the duration of ``steps`` in the order given, as a whole and part by part.

    ``readings``: of channels that are not read as ``[dwell]`` says.
    """
    parts = list(step_parts(rig, steps, dwell, channels, readings))
    p50_s, p90_s, by_part = learned.durations(parts)
    if not learned.is_known:
        dwells = sum(isinstance(step, Dwell) for step in steps)
        single_window_s = window_s(rig, dwell, channels[0])
        taken_s = sum(part.expected_s for part in parts if part.name != SOAK and not part.name.startswith(MOVE))
        p90_s = p50_s + dwells * single_window_s + REPEATED * (taken_s + dwells * single_window_s)
    return Expectation(p50_s, p90_s, by_part, learned.runs)
