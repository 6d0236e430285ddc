"""Coefficients as lines of text: what is remarked of every axis stands once."""

from typing import Any

from procedures.cli.results.coefficients_text import axes_lines

OF_BOTH, OF_X = "no temperature was recorded", "axis x: so few dwells do not tell a transient"


def _axis(*remarks: str) -> dict[str, Any]:
    return {
        "degrees_of_freedom": 4,
        "standard_error_v": 1e-5,
        "parameters": {},
        "replication": None,
        "warnings": [],
        "remarks": list(remarks),
    }


def test_a_remark_of_every_axis_stands_once_after_the_last() -> None:
    lines = list(axes_lines({"x": _axis(OF_X, OF_BOTH), "y": _axis(OF_BOTH)}))
    assert [line for line in lines if "remark" in line] == [f"  remark: {OF_X}", f"  remark: {OF_BOTH}"]
    assert lines.index(f"  remark: {OF_X}") < next(at for at, line in enumerate(lines) if line.startswith("axis y"))
    assert lines[-3:] == ["", "axes x, y", f"  remark: {OF_BOTH}"]


def test_the_remarks_of_a_single_axis_stand_under_it() -> None:
    lines = list(axes_lines({"x": _axis(OF_BOTH)}))
    assert lines[-1] == f"  remark: {OF_BOTH}"
    assert not any(line.startswith("axes") for line in lines)
