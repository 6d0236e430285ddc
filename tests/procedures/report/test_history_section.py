"""A sensor that was dropped says so in its report; one that stayed as it was says that, too."""

import re
from dataclasses import replace

import numpy as np
import pytest
from report_scene import Scene, run_view

from ams.archive.histories import SensorHistory
from ams.archive.synthetic import SyntheticArchive, synthetic_archive
from ams.surveillance.control_chart import history_of
from procedures.report.figures import Figures, draw_figures
from procedures.report.page import render_page
from procedures.report.view import RunView


@pytest.fixture(scope="module")
def archive() -> SyntheticArchive:
    return synthetic_archive(np.random.default_rng(3))


def _view(archive: SyntheticArchive, sensor: str) -> RunView:
    view = run_view(Scene(axes=("x",)))
    past = SensorHistory(history_of(archive.population, sensor), None, None, None)
    return replace(view, sensors=(replace(view.sensors[0], history=past),))


def _text(view: RunView) -> str:
    page = render_page(view, Figures((), {sensor.name: () for sensor in view.sensors}))
    return " ".join(re.sub(r"<[^>]+>", " ", page).split())


def test_a_drop_stands_in_the_report_with_its_date(archive: SyntheticArchive) -> None:
    (sensor,) = archive.dropped
    view = _view(archive, sensor)
    past = view.sensors[0].history
    assert past is not None
    (step,) = (finding for finding in past.history.findings if finding.kind == "step")
    assert f"Step: {step.sentence}" in _text(view)
    assert any(figure.name == f"{view.sensors[0].slug}-history" for figure in draw_figures(view).all())


def test_a_quiet_past_is_told_as_such(archive: SyntheticArchive) -> None:
    quiet = next(
        name
        for name in sorted({label.sensor for label in archive.population.labels})
        if not history_of(archive.population, name).findings
    )
    unseen = history_of(archive.population, quiet).unseen_deg
    assert unseen is not None
    assert (
        "Nothing was found: no calibration left the prediction interval of those before, and no drift shows (a step "
        f"below {unseen[0]:.4f}° or a drift below {unseen[1]:.4f}° a year would not be seen)."
        in _text(_view(archive, quiet))
    )


def test_a_first_calibration_has_no_history() -> None:
    assert "History" not in _text(run_view(Scene(axes=("x",))))
