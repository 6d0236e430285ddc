"""A line that damages what a device says: an answer is right, or there is none; never a wrong number."""

from collections.abc import Callable, Mapping
from pathlib import Path

from rig.assembly.open_rig import Rig, open_rig
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.description.read import read_rig
from rig.errors import RigError
from rig.testing.law import expect

DAMAGES: Mapping[str, Mapping[str, object]] = {
    "drop": {},
    "truncate": {"keep": 4},
    "flip-bit": {"byte": 5, "bit": 6},
    "echo": {},
    "freeze": {"delay_s": 1.5},
    "stale": {"text": "0"},
}
"""Kinds of a fault file, with what each needs."""
MISTAKEN: Mapping[str, Mapping[str, object]] = {"previous": {}}
"""Besides, where an answer repeats its question: the answer before it."""
LONGEST_S = 600.0


def survive_damage(
    path: Path,
    key: str,
    ask: Callable[[Rig], float],
    tolerance: float,
    *,
    damages: Mapping[str, Mapping[str, object]] = DAMAGES,
    times: int = 9,
) -> None:
    """Ask ``times`` while every third answer of the device at ``key`` is damaged, in each way there is.

    ``ask`` asks for a number that does not change, such as ``lambda rig: rig.environments["air"].setpoint_degc()``; an
    error of the rig is an answer. Raises: AssertionError.
    """
    with open_rig(read_rig(path)) as rig:
        right = ask(rig)
    for kind, needs in damages.items():
        rule = FaultRule(line=key, kind=kind, every=3, **needs)  # type: ignore[arg-type]
        with open_rig(read_rig(path), faults=FaultPlan(fault={"damage": rule})) as rig:
            began_s = rig.clock.monotonic_s()
            for _ in range(times):
                try:
                    reading = ask(rig)
                except RigError:
                    continue
                expect(abs(reading - right) <= tolerance, f"{key}: {kind}: it tells {reading:g}, right is {right:g}")
            took_s = rig.clock.monotonic_s() - began_s
            expect(took_s < LONGEST_S, f"{key}: {kind}: {times} questions took {took_s:g} s")
