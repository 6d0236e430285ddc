"""Quantiles by NumPy alone, held against scipy's and against published tables; angles where there is no scipy."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.special
from solved_sets import tp_set

import ams
from ams.exports.formats import export_set
from ams.statistics import without_scipy

WITHOUT = """
import sys
for blocked in ("scipy", "pandas", "jsonschema"):
    sys.modules[blocked] = None
import ams, json
angles = ams.load(sys.argv[1]).attitude([0.1, 0.2, 2.4])
print(json.dumps([float(angles.pitch_deg), float(angles.pitch_sd_deg), float(angles.roll_deg), int(angles.codes)]))
"""


@pytest.mark.parametrize("dof", [1.0, 1.5, 2.0, 3.7, 12.0, 503.0, 9_999.0, 10_001.0, 4e6, np.inf])
@pytest.mark.parametrize("probability", [1e-6, 0.025, 0.4, 0.5, 0.975, 0.9995])
def test_student_s_quantile(dof: float, probability: float) -> None:
    known = scipy.special.ndtri(probability) if np.isinf(dof) else scipy.special.stdtrit(dof, probability)
    assert without_scipy.stdtrit(dof, probability) == pytest.approx(known, rel=1e-10, abs=1e-12)


def test_published_values() -> None:
    """NIST/SEMATECH e-Handbook, tables 1.3.6.7.2, .3 and .4."""
    assert without_scipy.stdtrit([1, 10, 100], 0.975) == pytest.approx([12.706, 2.228, 1.984], abs=5e-4)
    assert without_scipy.chdtri([1, 10, 100], 0.05) == pytest.approx([3.841, 18.307, 124.342], abs=5e-4)
    assert without_scipy.fdtrc(5, 10, 3.326) == pytest.approx(0.05, abs=5e-5)


@pytest.mark.parametrize("numerator", [1.0, 2.0, 17.0])
@pytest.mark.parametrize("denominator", [1.0, 30.0, 4e4, np.inf])
def test_tails(numerator: float, denominator: float) -> None:
    ratio = np.array([0.01, 0.9, 1.0, 3.0, 40.0])
    known = (
        scipy.special.chdtrc(numerator, numerator * ratio)
        if np.isinf(denominator)
        else scipy.special.fdtrc(numerator, denominator, ratio)
    )
    assert without_scipy.fdtrc(numerator, denominator, ratio) == pytest.approx(known, rel=1e-9, abs=1e-300)
    share = np.array([0.5, 0.95, 0.999])
    quantile = (
        scipy.special.chdtri(numerator, 1.0 - share) / numerator
        if np.isinf(denominator)
        else scipy.special.fdtri(numerator, denominator, share)
    )
    assert without_scipy.fdtri(numerator, denominator, share) == pytest.approx(quantile, rel=1e-8)
    tail = np.array([1e-12, 1e-3, 0.5, 0.99])
    assert without_scipy.chdtri(numerator, tail) == pytest.approx(scipy.special.chdtri(numerator, tail), rel=1e-11)
    assert without_scipy.ndtr(ratio) == pytest.approx(scipy.special.ndtr(ratio), rel=1e-14)


def test_a_tunnel_s_computer_has_the_same_angles_with_numpy_alone(tmp_path: Path) -> None:
    three_axis_set = tmp_path / "tp.json"
    export_set(tp_set(), "json", three_axis_set)
    angles = ams.load(three_axis_set).attitude([0.1, 0.2, 2.4])
    said = subprocess.run(
        [sys.executable, "-c", WITHOUT, str(three_axis_set)], capture_output=True, text=True, check=True
    )
    here = [float(angles.pitch_deg), float(angles.pitch_sd_deg), float(angles.roll_deg), int(angles.codes)]
    assert json.loads(said.stdout) == pytest.approx(here, rel=1e-9)
