"""Dwells with motion, fields and streams, judged: every reason in words, and none where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.plan.steps import Dwell, Rest, Turn
from procedures.records.dwells import ChannelReading, Look, Measurement, MotionRecord, NoiseReference, StreamTiming
from procedures.run.judgement.judge import Limits, judge_dwell
from rig.abilities.abilities import AxisState
from rig.description.rig_file import AttitudeReference

STREAM = StreamTiming("imu", 60, 1.0, 1e-3, 0.0, 1e-6, missing=0, doubled=0, doubtful=0, first_gap="")
TURN = Turn("roll", 40.0, 9.0, 1, None, 0, 0.02)
DWELL = Dwell(3, "design", 1, 2, {"pitch": 0.0, "roll": 0.0}, TURN)
LIMITS = Limits({"pitch": 0.0, "roll": 0.0}, {"pitch": 0.01, "roll": 0.01}, 3.0, {})


def _state(position_deg: float, **changes: object) -> AxisState:
    return replace(AxisState(position_deg, False, True, True, ""), **changes)  # type: ignore[arg-type]


def _measured(samples: np.ndarray | None = None, **changes: object) -> Measurement:
    values = np.random.default_rng(3).normal(1.0, 0.1, 60) if samples is None else samples
    rest = Look({"pitch": _state(0.0), "roll": _state(0.0)}, {})
    turned = Look({"pitch": _state(0.0), "roll": _state(371.0)}, {})
    readings = {"imu.gx": ChannelReading("imu.gx", values, 0.0, 1.0)}
    return replace(Measurement(rest, turned, readings, True, 0.0, MotionRecord(streams=(STREAM,))), **changes)  # type: ignore[arg-type]


def _judged(
    measured: Measurement,
    dwell: Dwell = DWELL,
    noise: NoiseReference | None = None,
    expected: AttitudeReference | None = None,
) -> tuple[str, ...]:
    return judge_dwell(dwell, measured, LIMITS, noise or NoiseReference(), expected)


def test_a_sound_turn_has_no_reason_against_it() -> None:
    assert _judged(_measured()) == ()


@pytest.mark.parametrize(
    ("lost", "expected"),
    [
        ({"missing": 1}, "1 missing"),
        ({"doubled": 2}, "2 sent twice"),
        ({"doubtful": 3}, "3 in doubt"),
        ({"missing": 1, "doubled": 2}, "1 missing, 2 sent twice"),
    ],
)
def test_fault_67_one_lost_sample_is_one_too_many(lost: dict[str, int], expected: str) -> None:
    stream = replace(STREAM, first_gap="before sample 7: the count goes on by 2", **lost)  # type: ignore[arg-type]
    (reason,) = _judged(_measured(motion=MotionRecord(streams=(stream,))))
    assert reason == f"imu: of 60 samples {expected} (before sample 7: the count goes on by 2), allowed none"


def test_a_number_that_is_none_is_told() -> None:
    samples = np.ones(60)
    samples[3] = np.nan
    assert _judged(_measured(samples)) == ("imu.gx: 1 of 60 readings overloaded",)


def test_fault_59_a_sensor_that_scattered_before_and_now_stands_still_is_stuck() -> None:
    noise = NoiseReference()
    still = np.full(60, 0.25)
    assert _judged(_measured(still), noise=noise) == ()  # maybe too coarse for its noise: nothing is known yet
    for seed in range(6):
        values = np.random.default_rng(seed).normal(1.0, 0.1, 60)
        noise.learn({"imu.gx": ChannelReading("imu.gx", values, 0.0, 1.0)})
    assert _judged(_measured(still), noise=noise) == ("imu.gx: stuck: 60 times 0.25",)


def test_an_axis_that_turned_may_stand_anywhere_but_must_stand() -> None:
    after = Look({"pitch": _state(0.5), "roll": _state(400.0, is_moving=True)}, {})
    assert _judged(_measured(after=after)) == (
        "pitch: at 0.5° after the readings, allowed within 0.01° of 0°",
        "roll: moving after the readings",
    )


def test_a_reference_says_where_it_is_and_the_axes_need_not() -> None:
    reference = AttitudeReference(
        channels={"pitch": "ahrs.pitch", "roll": "ahrs.roll"}, uncertainty_deg=0.05, closes_loop=True
    )
    rest = Dwell(3, "design", 1, 2, {"pitch": 0.0, "roll": 0.0}, Rest(60.0))
    moved = Look({"pitch": _state(-0.75), "roll": _state(0.5)}, {})
    measured = _measured(before=moved, after=moved, reference_deg={"pitch": 0.02, "roll": -0.05})
    assert _judged(measured, rest, expected=reference) == ()
    assert measured.mean_position_deg() == {"pitch": 0.02, "roll": -0.05}  # measured, not commanded
    off = replace(measured, reference_deg={"pitch": 0.3, "roll": 360.0})  # 0.1 and three times 0.05 are allowed
    assert _judged(off, rest, expected=reference) == (
        "pitch: the reference tells 0.3°, allowed within 0.25° of its target",
    )
