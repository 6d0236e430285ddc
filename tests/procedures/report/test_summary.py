from dataclasses import replace
from io import StringIO

import pytest
from report_scene import Scene, run_view
from rich.console import Console

from procedures.kinds.section import SensorPage, TextTable
from procedures.report.summary import print_summary
from procedures.report.view import RunView


def _printed(view: RunView) -> str:
    console = Console(file=StringIO(), width=110, color_system=None)
    print_summary(view, console)
    file = console.file
    assert isinstance(file, StringIO)
    return file.getvalue()


def test_coefficients_stand_beside_the_twins_truth() -> None:
    text = _printed(run_view(Scene()))
    assert text.count("sensitivity") == 3
    assert "truth" in text
    assert "2.500095" in text
    assert text.startswith("SIMULATED · ENGINEERING")


def test_at_the_bench_there_is_no_truth_to_show() -> None:
    assert "truth" not in _printed(run_view(Scene(simulated=False)))


def test_a_name_that_looks_like_markup_is_text() -> None:
    view = run_view(Scene(axes=("x",)))
    named = replace(view, sensors=(replace(view.sensors[0], name="[red]SN[/]"),))
    assert "[red]SN[/]" in _printed(named)


def test_what_is_not_determined_is_said() -> None:
    assert _printed(run_view(Scene(axes=("x",), null_azimuth=True))).count("not determined") >= 2


def test_eighty_columns_hold_every_name_whole() -> None:
    console = Console(file=StringIO(), width=80, color_system=None)
    print_summary(run_view(Scene()), console)
    assert isinstance(console.file, StringIO)
    lines = console.file.getvalue().splitlines()
    assert sum("coning angle" in line for line in lines) == 3
    assert not any("…" in line for line in lines)


@pytest.mark.parametrize(("width", "simulated"), [(40, False), (80, False), (80, True), (120, True)])
def test_no_coefficient_of_a_sensor_is_cut(width: int, *, simulated: bool) -> None:
    view = run_view(Scene(axes=("x",), simulated=simulated))
    axis = view.sensors[0].axes[0]
    cold = replace(
        axis.parameters[0], label="sensitivity temperature coefficient", unit="1/°C", value=-0.0000061234,
        expanded_uncertainty=0.000000031, truth=-0.0000061221,
    )  # fmt: skip
    rows = (*axis.parameters, cold)
    warmed = replace(view, sensors=(replace(view.sensors[0], axes=(replace(axis, parameters=rows),)),))
    console = Console(file=StringIO(), width=width, color_system=None)
    print_summary(warmed, console)
    assert isinstance(console.file, StringIO)
    found = console.file.getvalue()
    assert "…" not in found
    wanted = ("-0.000006123", "0.000000031", "1/°C", *(("-0.000006122", "truth", "inside") if simulated else ()))
    assert all(cell in found for cell in wanted)
    words = ["sensitivity", "temperature", "coefficient"]
    assert all(word in found for word in words)


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_no_digit_is_cut_in_a_table_of_lines_or_rates(width: int) -> None:
    row = ("x", "sensitivity", "V/(°/s)", "1.2499995", "0.0000064", "1.0", "1.2500000", "yes")
    headings = ("axis", "parameter", "unit", "value", "± (95 %)", "ν", "twin's truth", "95 % interval holds it")
    console = Console(file=StringIO(), width=width, color_system=None)
    section = SensorPage("gyro", (), (TextTable("lines", headings, (row, row[:3])),), ())
    view = run_view(Scene())
    print_summary(replace(view, sensors=(replace(view.sensors[0], axes=(), section=section),)), console)
    assert isinstance(console.file, StringIO)
    found = console.file.getvalue()
    assert all(cell in found for cell in row)
    assert "…" not in found
