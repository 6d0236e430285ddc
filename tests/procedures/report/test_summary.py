from dataclasses import replace
from io import StringIO

from report_scene import Scene, run_view
from rich.console import Console

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
