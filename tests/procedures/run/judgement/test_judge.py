"""Every reason to reject a dwell, each alone; and how often a sound dwell is rejected."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.records.dwells import ChannelReading, Look, Measurement, NoiseReference
from procedures.run.judgement.judge import Band, Limits, judge
from rig.abilities.abilities import AxisState

SIGMA_V = 2e-5
HERE = AxisState(position_deg=10.0, is_moving=False, is_homed=True, is_seated=True, fault="")
LOOK = Look({"pitch": HERE}, {"air": 20.0})
LIMITS = Limits({"pitch": 10.0}, {"pitch": 0.001}, 3.0, {"air": Band(20.0, 1.0)})


def _reading(values_v: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> ChannelReading:
    return ChannelReading("dmm.x", values_v, 100.0, 0.4)


def _measured(values_v: "np.ndarray[tuple[int], np.dtype[np.float64]]", **other: object) -> Measurement:
    sound = Measurement(LOOK, LOOK, {"dmm.x": _reading(values_v)}, is_settled=True, settle_s=3.0)
    return replace(sound, **other)  # type: ignore[arg-type]


def _known_noise(samples: int = 20, dwells: int = 50) -> NoiseReference:
    reference, chance = NoiseReference(), np.random.default_rng(1)
    for _ in range(dwells):
        reference.learn({"dmm.x": _reading(chance.normal(2.5, SIGMA_V, samples))})
    return reference


def _good() -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    return np.random.default_rng(8).normal(2.5, SIGMA_V, 20)


def test_a_sound_dwell_has_no_reason() -> None:
    assert judge(_measured(_good()), LIMITS, _known_noise()) == ()


def test_fault_64_an_unsettled_dwell_is_rejected() -> None:
    assert judge(_measured(_good(), is_settled=False, settle_s=60.0), LIMITS, _known_noise()) == (
        "not settled after 60 s",
    )


def test_fault_57_one_overloaded_reading_is_enough() -> None:
    values_v = _good()
    values_v[7] = np.nan
    assert judge(_measured(values_v), LIMITS, _known_noise()) == ("dmm.x: 1 of 20 readings overloaded",)


def test_a_noisy_dwell_is_told_with_both_figures() -> None:
    (reason,) = judge(_measured(2.5 + 4.0 * (_good() - 2.5)), LIMITS, _known_noise())
    assert reason.startswith("dmm.x: noise: standard deviation ")
    assert "3 × that of the dwells before" in reason


@pytest.mark.parametrize("values_v", [np.full(20, 2.5), 2.5 + 0.05 * (_good() - 2.5)])
def test_fault_59_stuck_is_rejected(values_v: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> None:
    (reason,) = judge(_measured(values_v), LIMITS, _known_noise())
    assert "dmm.x: stuck" in reason


def test_a_channel_without_any_noise_is_not_stuck_where_none_is_known() -> None:
    reference = NoiseReference()
    for _ in range(20):
        reference.learn({"dmm.x": _reading(np.full(20, 0.1))})
    assert judge(_measured(np.full(20, 0.1)), LIMITS, reference) == ()


def test_readings_that_drift_are_rejected() -> None:
    values_v = _good() + np.linspace(0.0, 10 * SIGMA_V, 20)
    reasons = judge(_measured(values_v), LIMITS, NoiseReference())
    assert reasons == ("dmm.x: the readings drift within the dwell",)


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize(
    ("state", "expected"),
    [
        (
            replace(HERE, position_deg=10.002),
            "pitch: at 10.002° {when} the readings, allowed within",
        ),
        (replace(HERE, is_moving=True), "pitch: moving {when} the readings"),
        (replace(HERE, is_seated=False), "pitch: not seated {when} the readings"),
        (replace(HERE, is_homed=False), "pitch: not homed {when} the readings"),
        (replace(HERE, fault="LIMIT"), "pitch: at fault (LIMIT) {when} the readings"),
    ],
)
def test_a_position_that_is_not_trusted_is_rejected(when: str, state: AxisState, expected: str) -> None:
    measured = _measured(_good(), **{when: replace(LOOK, axes={"pitch": state})})
    (reason,) = judge(measured, LIMITS, _known_noise())
    assert reason.startswith(expected.format(when=when))


@pytest.mark.parametrize(
    ("degc", "expected"),
    [
        (21.2, "air: 21.20 °C after the readings, allowed 20 ± 1 °C"),
        (float("nan"), "air: no temperature after the readings"),
    ],
)
def test_a_temperature_outside_its_band_is_rejected(degc: float, expected: str) -> None:
    measured = _measured(_good(), after=replace(LOOK, temperature_degc={"air": degc}))
    assert judge(measured, LIMITS, _known_noise()) == (expected,)


def test_without_a_plateau_any_temperature_is_a_record() -> None:
    measured = _measured(_good(), after=replace(LOOK, temperature_degc={"air": 35.0}))
    assert judge(measured, replace(LIMITS, bands={}), _known_noise()) == ()


def test_noise_is_judged_from_the_fifth_dwell_on() -> None:
    loud = _measured(2.5 + 10.0 * (_good() - 2.5))
    assert judge(loud, LIMITS, _known_noise(dwells=4)) == ()
    assert judge(loud, LIMITS, _known_noise(dwells=5)) != ()


@pytest.mark.parametrize("samples", [2, 3, 5, 20])
def test_the_reference_estimates_the_noise_at_any_number_of_samples(samples: int) -> None:
    found = _known_noise(samples, dwells=4000).standard_deviation("dmm.x")
    assert found == pytest.approx(SIGMA_V, rel=0.04)


def test_a_loud_dwell_does_not_raise_the_reference() -> None:
    reference = _known_noise(dwells=99)
    before = reference.standard_deviation("dmm.x")
    reference.learn({"dmm.x": _reading(_good() * 1e3)})
    assert before is not None
    assert reference.standard_deviation("dmm.x") == pytest.approx(before, rel=0.02)


@pytest.mark.parametrize("samples", [3, 5, 20])
def test_sound_dwells_are_hardly_ever_rejected(samples: int) -> None:
    reference, chance = _known_noise(samples, dwells=500), np.random.default_rng(3)
    rejected = sum(bool(judge(_measured(chance.normal(2.5, SIGMA_V, samples)), LIMITS, reference)) for _ in range(3000))
    assert rejected <= 3


@pytest.mark.parametrize("samples", [2, 3, 5])
@pytest.mark.parametrize("dwells", [5, 20])
def test_few_readings_and_a_young_reference_reject_no_sound_dwell(samples: int, dwells: int) -> None:
    """At 1e-5 each; three times the reference alone gives 7 to 40 in a thousand at two and three readings."""
    chance, rejected = np.random.default_rng(5), 0
    for _run in range(20):
        reference = NoiseReference()
        for _ in range(dwells):
            reference.learn({"dmm.x": _reading(chance.normal(2.5, SIGMA_V, samples))})
        for _ in range(100):
            rejected += bool(judge(_measured(chance.normal(2.5, SIGMA_V, samples)), LIMITS, reference))
    assert rejected <= 1


def test_the_limit_is_that_of_fisher_where_it_has_a_closed_form() -> None:
    """Of three readings, two degrees of freedom each: P(F > x) = (1 + x/K)^-K for K dwells."""
    reference = NoiseReference()
    for _ in range(10):
        reference.learn({"dmm.x": _reading(np.array([2.5, 2.5 + SIGMA_V, 2.5 - SIGMA_V]))})
    by_hand_v = SIGMA_V * np.sqrt(10.0 * (1e5**0.1 - 1.0))
    assert reference.largest_by_chance("dmm.x", 2, 1e-5) == pytest.approx(by_hand_v, rel=1e-6)


@pytest.mark.parametrize(("samples", "least_share"), [(3, 0.8), (5, 0.95), (20, 1.0)])
def test_a_dwell_ten_times_as_noisy_is_found(samples: int, least_share: float) -> None:
    reference, chance = _known_noise(samples, dwells=20), np.random.default_rng(7)
    found = [bool(judge(_measured(chance.normal(2.5, 10.0 * SIGMA_V, samples)), LIMITS, reference)) for _ in range(500)]
    assert np.mean(found) >= least_share


def test_a_loud_dwell_among_the_first_does_not_hide_the_next() -> None:
    reference, chance = _known_noise(dwells=4), np.random.default_rng(9)
    reference.learn({"dmm.x": _reading(chance.normal(2.5, 1000.0 * SIGMA_V, 20))})
    assert judge(_measured(chance.normal(2.5, 10.0 * SIGMA_V, 20)), LIMITS, reference)


@pytest.mark.parametrize("dwells", [0, 50])
def test_three_readings_that_a_meters_digits_put_in_a_line_do_not_drift(dwells: int) -> None:
    in_line_v = 2.5 + SIGMA_V * np.array([-1.0, 0.0, 1.0])
    assert judge(_measured(in_line_v), LIMITS, _known_noise(3, dwells)) == ()


def test_digits_in_a_line_do_not_drift_where_the_noise_is_known_to_be_as_large() -> None:
    in_line_v = 2.5 + SIGMA_V * np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    assert judge(_measured(in_line_v), LIMITS, _known_noise(5)) == ()
