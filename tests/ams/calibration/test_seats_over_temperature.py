"""What the sensitivities of gyros absorb stays nothing where a thermometer scatters: no seat is seen at lone positions.

Three sensitivities absorb three seats. A temperature that scatters from dwell to dwell tells the two apart by a hundred
thousandth, and what noise shows of that is no angle.
"""

from functools import cache
from typing import Literal

import calrig
import numpy as np
import pytest
from turned_gyros import gyros
from warm_gyros import COLUMNS, REFERENCE_DEGC, warm_gyros

from ams.calibration import askew_seats, calibrate
from ams.calibration.askew_seats import ASKEW_SEATS, AskewSeats

SEEDS = range(4, 12)


def solved(seed: int, scatter_degc: float, order: Literal[1, 2] = 1) -> tuple[dict, dict[str, float]]:
    """Document, and true sensitivities."""
    table, true = warm_gyros(seed, scatter_degc, bend_per_degc2=2e-6 * (order - 1))
    found = calrig.fit(
        table,
        COLUMNS,
        model="gyro",
        temperature="estimate",
        temperature_order=order,
        reference_temperature_degc=REFERENCE_DEGC,
    )
    return found.document, dict(true)


def half_widths(document: dict) -> np.ndarray:
    """(3,) of the sensitivities, of 95 %."""
    axes = document["axes"].values()
    return np.array([axis["budget"]["expanded_uncertainty_95"]["sensitivity_v_per_dps"] for axis in axes])


@cache
def widths_at_exact(seed: int, order: Literal[1, 2]) -> np.ndarray:
    """Half-widths of the same gyros at temperatures that repeat, (3,)."""
    return half_widths(solved(seed, 0.0, order)[0])


@pytest.mark.parametrize(
    ("scatter_degc", "order", "widest"), [(0.001, 1, 1.2), (0.02, 1, 1.5), (0.02, 2, 1.5), (0.5, 1, 4.0)]
)
def test_a_scatter_of_temperature_makes_no_seats_and_no_jump(
    scatter_degc: float, order: Literal[1, 2], widest: float
) -> None:
    """Against the same gyros at temperatures that repeat; a tenth of campaigns had widths a thousand times as large."""
    held = []
    for seed in SEEDS:
        document, true = solved(seed, scatter_degc, order)
        widths = half_widths(document)
        assert ASKEW_SEATS not in str(document)
        assert np.all(widths < widest * widths_at_exact(seed, order))
        values = [axis["parameters"]["sensitivity_v_per_dps"]["value"] for axis in document["axes"].values()]
        held += list(np.abs(np.array(values) - list(true.values())) <= widths)
    assert np.mean(held) >= 0.8  # 0.95 of 24, less three standard deviations


def a_package(monkeypatch: pytest.MonkeyPatch, seats_deg: float) -> dict:
    """The document of a package whose seats are taken to be shown with such a standard deviation."""
    shown = AskewSeats(p_value=0.0, sd_rad=np.deg2rad(seats_deg), freedom=9.0)
    monkeypatch.setattr(calibrate, "judge_seats", lambda *_: shown)
    return calrig.fit(gyros(0)[0], COLUMNS, model="gyro").document


def test_what_no_seat_can_be_is_not_stated_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    document = a_package(monkeypatch, seats_deg=3.0)
    assert document["verdict"] == "not usable"
    for axis in document["axes"].values():
        (said,) = (finding for finding in axis["findings"] if finding.get("test") == ASKEW_SEATS)
        assert "more than a package can sit askew" in said["text"]
        assert "seats_arcsec" not in said
        assert all(line["source"] != ASKEW_SEATS for line in axis["budget"]["lines"])


def test_no_sensitivity_is_usable_that_an_error_shown_by_the_rows_hides(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seats of ten thousand turns, were they counted, leave nothing of a sensitivity, whatever else the rows show."""
    monkeypatch.setattr(askew_seats, "_LARGEST_RAD", np.inf)
    document = a_package(monkeypatch, seats_deg=3.6e6)
    assert document["verdict"] == "not usable"
    for axis in document["axes"].values():
        sensitivity = axis["parameters"]["sensitivity_v_per_dps"]
        assert sensitivity["standard_uncertainty"] > sensitivity["value"]
        assert [finding["kind"] for finding in axis["findings"]].count("axis-undetermined") == 1
