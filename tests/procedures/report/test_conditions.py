"""Laws of the section on conditions: what the meters proved, in numbers, out of the journal alone."""

import pytest
from report_dwells import event

from procedures.report.conditions import condition_sections


def _check(sequence: int, occasion: str, degc: float, *, anew: bool, off_v: float | None) -> object:
    proof = {
        "what": "reference on 10 V",
        "value_v": None if off_v is None else 10.0 + off_v,
        "expected_v": 10.0,
        "limit_v": 1e-4,
        "is_good": off_v is not None and abs(off_v) <= 1e-4,
    }
    return event(
        sequence, "meter_check", 60.0 * sequence, readout="dmm", occasion=occasion, temperature_degc=degc,
        is_calibrated_anew=anew, proofs=[proof],
    )  # fmt: skip


def test_the_meters_proofs_are_summed_up() -> None:
    events = [
        _check(1, "start", 36.4, anew=True, off_v=1e-5),
        _check(2, "time", 36.9, anew=False, off_v=-3e-5),
        _check(3, "time", 37.0, anew=False, off_v=2e-4),
        _check(4, "temperature", 37.5, anew=True, off_v=None),
    ]
    assert condition_sections(events) == {
        "checks of dmm": {
            "checked": "4 times (1 × start, 2 × time, 1 × temperature)",
            "own temperature": "36.4 to 37.5 °C",
            "calibrated itself": "2 times, last 2026-03-01 22:00 UTC",
            "reference on 10 V": "off by -30 to +200 µV, allowed ±100 µV, 2 beyond it, 1 overloaded",
        }
    }


@pytest.mark.parametrize(
    ("off_v", "expected"),
    [(1e-5, "off by +10 µV, allowed ±100 µV"), (2.5, "off by +2.5 V, allowed ±0.0001 V, 1 beyond it")],
)
def test_small_voltages_are_told_in_microvolts(off_v: float, expected: str) -> None:
    sections = condition_sections([_check(1, "start", 36.4, anew=False, off_v=off_v)])
    assert sections["checks of dmm"]["reference on 10 V"] == expected


def test_a_run_without_any_has_no_section() -> None:
    assert condition_sections([event(1, "note", 0.0, text="hello")]) == {}
