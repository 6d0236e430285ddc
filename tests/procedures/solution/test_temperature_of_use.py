"""A declared range of use: where the set is valid, and what a data sheet's limit adds to the uncertainties."""

from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from example_files import EXAMPLE_RIG
from stored_runs import DATA, StoredCase

from procedures.journal.journal_reader import JournalReader
from procedures.kinds.expected_lines import forecast_of_points
from procedures.kinds.solve import solve_record
from procedures.solution.expected_points import by_lines, expected_points
from procedures.solution.record import RunRecord, read_record
from procedures.solution.temperature_of_use import use_warnings, warnings_of_use
from procedures.solution.type_b import shared_errors
from rig.description.read import read_rig
from rig.errors import DescriptionError


def _rig(tmp_path, **keys):
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    lines = "".join(f"{key} = {value}\n" for key, value in keys.items())
    path = tmp_path / "rig.toml"
    path.write_text(text.replace("[sensors.SN1047]\n", f"[sensors.SN1047]\n{lines}"), encoding="utf-8")
    return read_rig(path)


def test_a_limit_of_the_data_sheet_counts_up_to_the_farther_end_of_the_range(tmp_path) -> None:
    rig = _rig(
        tmp_path, use_temperature_degc="[15.0, 30.0]", largest_offset_tc_v_per_degc=2e-5,
        largest_sensitivity_tc_per_degc=3e-5,
    )  # fmt: skip
    sensor = rig.sensors["SN1047"]
    errors = {shared_error.name: shared_error for shared_error in shared_errors(rig, sensor, None, 22.0)["x"]}
    offset, gain = errors["temperature of use, offset"], errors["temperature of use, sensitivity"]
    assert (offset.effect, offset.standard_uncertainty) == ("reading", pytest.approx(2e-5 * 8.0 / sqrt(3.0)))
    assert (gain.effect, gain.standard_uncertainty) == ("gain", pytest.approx(3e-5 * 8.0 / sqrt(3.0)))
    assert not any("of use" in shared_error.name for shared_error in shared_errors(rig, sensor, None, None)["x"])
    assert use_warnings(sensor, 22.0) == ()


def test_a_range_without_a_model_or_a_limit_is_said(tmp_path) -> None:
    sensor = _rig(tmp_path, use_temperature_degc="[15.0, 30.0]").sensors["SN1047"]
    assert "15 to 30 °C" in use_warnings(sensor, 22.0)[0]
    assert use_warnings(sensor, None) == ()
    (said,) = use_warnings(sensor, None, is_recorded=False)
    assert said.startswith("the sensor is to be used at 15 to 30 °C, as declared, and no temperature was recorded")


@pytest.mark.parametrize(
    ("used", "temperature", "said"),
    [
        ("[0.0, 40.0]", "estimate", "over 10 to 30 °C: up to 10 °C beyond"),
        ("[12.0, 45.0]", "estimate", "over 10 to 30 °C: up to 15 °C beyond"),
        ("[9.0, 31.0]", "estimate", None),
        ("[0.0, 40.0]", "apply", None),
    ],
)
def test_a_range_of_use_beyond_the_temperatures_of_estimated_coefficients_is_a_reservation(
    tmp_path, used: str, temperature: str, said: str | None
) -> None:
    sensor = _rig(tmp_path, use_temperature_degc=used).sensors["SN1047"]
    found = warnings_of_use(sensor, temperature, np.array([10.0, 20.0, 30.0]))
    assert [said in text for text in found] == [True] if said else found == ()


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"use_temperature_degc": "[30.0, 15.0]"}, "needs a lower and a higher temperature"),
        ({"largest_offset_tc_v_per_degc": 1e-5}, "belong to use_temperature_degc"),
    ],
)
def test_a_range_upside_down_and_a_limit_without_a_range_are_refused(tmp_path, keys, sentence) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        _rig(tmp_path, **keys)


USED_DEGC, AT_DEGC = (10.0, 30.0), 22.0
SENSITIVITY_LIMIT = 2e-4
"""1/°C, as a data sheet limits it."""
OF_LINES = {"tumble_up_down": "gain_g_per_g", "rates_linear": "gain_dps_per_dps", "two_level": "gain_ut_per_ut"}
"""Kinds of runs that are solved by straight lines, and what their gains are called."""


def _used(kind: str, folder: Path, sensitivity_tc: float, degc: float | None) -> RunRecord:
    """A stored run whose sensor is to be used over a range; at a temperature of its dwells, or without any."""
    with JournalReader.open(StoredCase(DATA / "runs_0_1_0" / kind).copy("finished", folder / "run")) as reader:
        record = read_record(reader)
    of_use = {"use_temperature_degc": USED_DEGC, "largest_sensitivity_tc_per_degc": sensitivity_tc}
    sensors = {name: sensor.model_copy(update=of_use) for name, sensor in record.plan.sensors.items()}
    (template,) = read_rig(EXAMPLE_RIG).environment.values()
    rig = record.rig.model_copy(update={"sensors": sensors, "environment": {} if degc is None else {"air": template}})
    dwells = [replace(dwell, temperature_degc={} if degc is None else {"air": degc}) for dwell in record.dwells]
    return replace(record, plan=replace(record.plan, sensors=sensors), rig=rig, dwells=dwells)


def _gains(record: RunRecord, name: str) -> list[tuple[float, float]]:
    (solved,) = solve_record(record).values()
    assert solved.calibration is not None
    parameters = [{p.name: p for p in axis.parameters}[name] for axis in solved.calibration.axes.values()]
    return [(gain.value or 0.0, gain.standard_uncertainty or 0.0) for gain in parameters]


@pytest.mark.parametrize("kind", OF_LINES)
def test_a_limit_of_the_data_sheet_counts_in_straight_lines_as_in_packages(kind: str, tmp_path: Path) -> None:
    """GUM 4.3.7: a rectangle over the 12 °C to the farther end of use; it was in none of their uncertainties."""
    without, limited = (
        _gains(_used(kind, tmp_path / str(limit), limit, AT_DEGC), OF_LINES[kind]) for limit in (0.0, SENSITIVITY_LIMIT)
    )
    u = SENSITIVITY_LIMIT * (AT_DEGC - USED_DEGC[0]) / sqrt(3.0)
    for (gain, u_without), (_, u_limited) in zip(without, limited, strict=True):
        assert sqrt(u_limited**2 - u_without**2) == pytest.approx(abs(gain) * u, rel=1e-3)


@pytest.mark.parametrize("kind", OF_LINES)
@pytest.mark.parametrize(
    ("degc", "limit", "said"),
    [
        (AT_DEGC, 0.0, "is to be used at 10 to 30 °C and was calibrated at 22 °C without a model of temperature"),
        (None, SENSITIVITY_LIMIT, "is to be used at 10 to 30 °C, as declared, and no temperature was recorded"),
        (AT_DEGC, SENSITIVITY_LIMIT, ""),
    ],
)
def test_straight_lines_say_what_of_their_use_is_in_no_figure(
    kind: str, degc: float | None, limit: float, said: str, tmp_path: Path
) -> None:
    (solved,) = solve_record(_used(kind, tmp_path, limit, degc)).values()
    assert solved.calibration is not None
    found = [text for text in solved.calibration.warnings if "is to be used at" in text]
    assert (len(found), said in "".join(found)) == (bool(said), True)


@pytest.mark.parametrize("kind", OF_LINES)
def test_what_points_are_reserved_about_is_said_before_they_are_measured(kind: str, tmp_path: Path) -> None:
    """The middle of the range stands for a temperature that nothing sets, and counts in what is expected."""
    unlimited, limited, unread = (
        _used(kind, tmp_path / name, limit, degc)
        for name, limit, degc in (("a", 0.0, AT_DEGC), ("b", SENSITIVITY_LIMIT, AT_DEGC), ("c", 0.0, None))
    )
    said = {key: forecast_of_points(r.rig, r.plan, None) for key, r in (("no limit", unlimited), ("unread", unread))}
    assert "calibrated at 20 °C without a model" in " ".join(said["no limit"].reservations)
    assert "no temperature was recorded" in " ".join(said["unread"].reservations)
    counted = forecast_of_points(limited.rig, limited.plan, None)
    assert counted.reservations == ()
    assert "counts as if it were 20 °C" in " ".join(counted.remarks)
    without, stated = (
        [
            (gain.value or 0.0, gain.standard_uncertainty or 0.0)
            for name, sensor in record.plan.sensors.items()
            for axis in expected_points(record.rig, record.plan, name, sensor, by_lines).values()
            for gain in axis.solution.parameters
            if gain.name == OF_LINES[kind]
        ]
        for record in (unlimited, limited)
    )
    u = SENSITIVITY_LIMIT * 10.0 / sqrt(3.0)
    assert without
    for (gain, u_without), (_, u_stated) in zip(without, stated, strict=True):
        assert sqrt(u_stated**2 - u_without**2) == pytest.approx(abs(gain) * u, rel=1e-3)
