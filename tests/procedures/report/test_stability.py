import numpy as np
import pytest
from report_dwells import dwell

from procedures.report.stability import check_comparisons, reference_traces, temperature_traces

LABELS = {"dmm.x": ("SN1 x", 2.5)}


def test_the_check_set_is_compared_attitude_by_attitude() -> None:
    before = [dwell(n, "check", 0, 0, pitch_deg=p, volts={"dmm.x": (p, p + 2e-6)}) for n, p in enumerate((0.0, 90.0))]
    after = [
        dwell(50, "check", 0, 0, pitch_deg=0.0, epoch=2, volts={"dmm.x": (1e-6, 3e-6)}),
        dwell(51, "check", 0, 0, pitch_deg=90.0, epoch=2, volts={"dmm.x": (90.0 + 5e-6, 90.0 + 7e-6)}),
    ]
    (found,) = check_comparisons([*before, *after], LABELS)
    assert found.attitudes == 2
    assert found.mean_change == pytest.approx(3e-6, abs=1e-12)
    assert found.largest_change == pytest.approx(5e-6, abs=1e-12)
    assert found.largest_at == "pitch 90°, roll 0°"
    # two samples 2 µV apart: s² = 2 µV², the mean's variance 1 µV², of a difference 2 µV²
    assert found.scatter == pytest.approx(np.sqrt(2.0) * 1e-6, rel=1e-6)


def test_one_epoch_has_nothing_to_compare() -> None:
    assert check_comparisons([dwell(0, "check", 0, 0)], LABELS) == ()


def test_reference_traces_start_at_zero_and_leave_out_rejected_visits() -> None:
    visits = [
        dwell(place, "reference", volts={"dmm.x": (volt, volt)}, accepted=place != 2)
        for place, volt in enumerate((1.0, 1.5, 9.0, 1.25))
    ]
    (trace,) = reference_traces(visits, LABELS)
    assert trace.change.tolist() == [0.0, 0.5, 0.25]
    assert trace.label == "SN1 x"


def test_temperature_is_traced_where_it_was_read() -> None:
    (trace,) = temperature_traces([dwell(0, degc=20.0), dwell(1, degc=None), dwell(2, degc=20.5)])
    assert trace.temperature_degc.tolist() == [20.0, 20.5]
    assert temperature_traces([dwell(0, degc=None)]) == ()
