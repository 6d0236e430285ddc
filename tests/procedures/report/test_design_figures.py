"""The map against TP's special case and against a fit of simulated dwells: what it promises is what comes out."""

import re

import numpy as np
import pytest
from report_scene import Scene, run_view

from procedures.report.canvas import Figure, style
from procedures.report.design_figures import variance_map
from procedures.report.view import DesignView

TUMBLE = ((90.0, 0.0), (-90.0, 0.0), (0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, -90.0))


def _map(scene: Scene) -> Figure | None:
    with style():
        return variance_map(run_view(scene).design)


def _ends(figure: Figure) -> tuple[float, float]:
    found = re.search(r"between ([\d.]+) and ([\d.]+)", figure.caption)
    assert found is not None
    return float(found[1]), float(found[2])


def test_the_tumble_with_roll_knows_every_attitude_alike() -> None:
    figure = _map(Scene(points=TUMBLE, replications=3))
    assert figure is not None
    # TP section 4: the variance function of the six-point tumble with roll is 2/3 everywhere
    assert _ends(figure) == pytest.approx((np.sqrt(2 / 3 / 3),) * 2, abs=5e-5)
    assert b"<image" in figure.svg


def test_the_map_is_the_scatter_of_fits_of_simulated_dwells() -> None:
    scene = Scene(replications=1)
    figure, design = _map(scene), run_view(scene).design
    assert figure is not None
    pitch, roll = np.deg2rad(design.pitch_deg), np.deg2rad(design.roll_deg)
    basis = np.stack([np.ones_like(pitch), np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    noise = np.random.default_rng(1).normal(size=(4000, design.points))
    coefficients = np.linalg.lstsq(basis.T, noise.T, rcond=None)[0]
    scatter = (basis.T @ coefficients).std(axis=1)
    assert _ends(figure) == pytest.approx((scatter.min(), scatter.max()), rel=0.05)


@pytest.mark.parametrize("points", [((0.0, 0.0), (30.0, 0.0), (60.0, 0.0), (90.0, 0.0)), TUMBLE[:3]])
def test_attitudes_that_do_not_determine_the_model_have_no_map(points: tuple[tuple[float, float], ...]) -> None:
    pitch_deg, roll_deg = np.array(points).T
    with style():
        assert variance_map(DesignView("D", "raster", 2, np.arange(pitch_deg.size), pitch_deg, roll_deg)) is None
