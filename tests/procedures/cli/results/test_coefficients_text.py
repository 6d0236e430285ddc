"""Coefficients as lines of text: what is remarked of every axis stands once."""

from typing import Any

import pytest

from ams.rounding import with_uncertainty
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


@pytest.mark.parametrize(
    ("value", "uncertainty", "printed"),
    [
        (1.23456, 0.0998, "offset  +1.23 V  u 0.10"),
        (-12345.6, 350.0, "offset  -12350 V  u 350"),
        (2.5, 0.00001, "offset  +2.500000 V  u 1.0e-05"),
        (3.2, float("inf"), "offset  +3.2 V  u —"),
        (3.2, None, "offset  +3.2 V"),
    ],
)
def test_a_coefficient_is_told_to_the_place_of_a_certificate(
    value: float, uncertainty: float | None, printed: str
) -> None:
    """1.23456 with 0.0998 was +1.235 here and 1.23 on the certificate; a coefficient without bound was a defect."""
    axis = _axis() | {"parameters": {"offset_v": {"value": value, "standard_uncertainty": uncertainty}}}
    lines = [line.strip() for line in axes_lines({"x": axis})]
    assert printed in lines
    assert with_uncertainty(value, uncertainty)[0] == printed.split()[1].removeprefix("+")
