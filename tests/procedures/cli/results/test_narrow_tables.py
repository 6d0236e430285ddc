"""Coefficients and budgets stand in a terminal of 80 columns, each number beside its name."""

import re

from procedures.cli.results.coefficients_text import axes_lines
from procedures.cli.results.findings_text import findings_lines

SOURCES = 7
PARAMETERS = ("offset_v", "sensitivity_v_per_g", "q_xx_v_per_g2", "offset_traceless_v")


def test_a_budget_of_many_sources_goes_on_below_itself() -> None:
    """Numbers are of source and parameter: source 3 of the second parameter is 3.2e-06."""
    of = {name: index for index, name in enumerate(PARAMETERS, start=1)}
    lines = [
        {"type": "B", "source": f"source {n}", "stated": "", "degrees_of_freedom": None,
         "standard_uncertainty": {name: (n + 0.1 * of[name]) * 1e-6 for name in PARAMETERS}}
        for n in range(1, SOURCES + 1)
    ]  # fmt: skip
    whole, expanded = dict.fromkeys(PARAMETERS, 2.5e-5), dict.fromkeys(PARAMETERS, 5.1e-5)
    budget = {"lines": lines, "combined_standard_uncertainty": whole, "expanded_uncertainty_95": expanded}
    said = [f"  {line}" for line in findings_lines({"budget": budget})]
    table = said[1 + SOURCES :]
    assert max(map(len, said)) <= 80
    headings = " ".join(line.split("by")[1] for line in table if "standard uncertainty by" in line)
    assert headings.split()[:SOURCES] == [str(n) for n in range(1, SOURCES + 1)]
    sensitivity = " ".join(line.split("V/g ", 1)[1] for line in table if line.strip().startswith("sensitivity"))
    assert sensitivity.split()[:SOURCES] == [f"{n}.2e-06" for n in range(1, SOURCES + 1)]
    assert sensitivity.split()[SOURCES:] == ["2.5e-05", "5.1e-05"]


def test_a_coefficient_stands_in_one_line_with_both_uncertainties() -> None:
    parameters = {
        "offset_v": {"value": -0.00299938, "standard_uncertainty": 2.1e-6, "tp_standard_uncertainty": 6.1e-7},
        "sensitivity_v_per_g": {"value": 2.5000019, "standard_uncertainty": 7.1e-6, "tp_standard_uncertainty": 1e-6},
        "azimuth_deg": {"value": None, "standard_uncertainty": None},
    }
    axis = {"degrees_of_freedom": 4, "standard_error_v": 1e-5, "parameters": parameters, "replication": None,
            "warnings": [], "remarks": []}  # fmt: skip
    said = list(axes_lines({"x": axis}))
    assert re.fullmatch(r"  offset +-0\.0029994 V +u 2\.1e-06 +TP 6\.1e-07", said[2])
    assert re.fullmatch(r"  sensitivity +\+2\.5000019 V/g +u 7\.1e-06 +TP 1\.0e-06", said[3])
    assert re.fullmatch(r"  azimuth +not determined", said[4])
    assert "u: standard uncertainty; TP:" in said[-1]
    assert max(map(len, said)) <= 80
