"""A report drawn: every figure and the page of one package and of eight, in processor time of this process.

Beside it stands what a script of one's own takes for pictures of that kind: pyplot, a panel an axis with the points,
bands and second scale of a figure of residuals, saved as SVG. A busy machine slows both.
"""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib import pyplot as plt

from bench.figure import MOST_S, Effort, Figure
from bench.resolve import finished
from procedures.delivery.deliver import solve_run
from procedures.report.view import RunView
from procedures.report.write import draw_report, view_of

ALONE_S, OF_EIGHT_S = 2.0, 8.0
REPEATS = 3
LEAST_BESIDE_PYPLOT = 0.7


def figures(effort: Effort) -> Iterator[Figure]:
    """Seconds of one package and of eight, and of a figure of ours beside one of pyplot."""
    with TemporaryDirectory() as folder:
        finished(Path(folder))
        run = solve_run(Path(folder) / "run")
    view = view_of(run.record, run.sensors)
    eight = of_several(view, effort.amount(8, 2))
    counts: list[int] = []
    alone_s = processor_s(lambda: draw_report(view), effort)
    of_eight_s = processor_s(lambda: counts.append(len(draw_report(eight).figures.all())), effort)
    drawn = counts[0]
    plain_s = processor_s(lambda: pyplot_figure(eight), effort) * drawn
    yield Figure("report of one package drawn (processor)", alone_s, "s", ALONE_S, at_most=True)
    yield Figure("report of eight packages drawn (processor)", of_eight_s, "s", OF_EIGHT_S, at_most=True)
    note = f"{drawn} figures, the page with them"
    beside = plain_s / of_eight_s
    yield Figure("  pyplot, as many / ours", beside, "×", LEAST_BESIDE_PYPLOT, at_most=False, note=note, is_gated=True)


def of_several(view: RunView, count: int) -> RunView:
    """Return the run as if it had measured so many sensors: each is drawn for itself."""
    (sensor,) = view.sensors
    several = tuple(replace(sensor, name=f"SN{number}", number=number) for number in range(1, count + 1))
    return replace(view, sensors=several)


def processor_s(work: Callable[[], object], effort: Effort) -> float:
    """Return the least processor time of several calls, user and system; of fewer where they take long."""
    taken: list[float] = []
    while len(taken) < effort.amount(REPEATS, 1) and sum(taken) < MOST_S:
        before = os.times()
        work()
        after = os.times()
        taken.append(after.user + after.system - before.user - before.system)
    return min(taken)


def pyplot_figure(view: RunView) -> bytes:
    """Draw residuals as a script of one's own would."""
    sensor, content = view.sensors[0], BytesIO()
    rows = sensor.observations
    assert rows is not None
    pitch_deg = np.rad2deg(rows.pitch_rad)
    stations_deg = np.linspace(pitch_deg.min(), pitch_deg.max(), 91)
    figure, panels = plt.subplots(len(sensor.axes), 1, sharex=True, squeeze=False, figsize=(7.3, 6.2))
    for panel, axis in zip(panels[:, 0], sensor.axes, strict=True):
        for replication in np.unique(rows.replication):
            chosen = rows.replication == replication
            panel.plot(pitch_deg[chosen], axis.calibration.residuals_v[chosen], "o", label=f"repl. {replication}")
        for half in (1.0, 2.0):
            for sign in (half, -half):
                panel.plot(stations_deg, np.full(91, sign * axis.calibration.standard_error_v), "k--")
        panel.set_ylabel("residual (V)")
        panel.set_title(f"{axis.axis} axis")
        panel.grid(visible=True)
        panel.twinx().set_ylabel("arc seconds")
    panels[-1, 0].set_xlabel("pitch (°)")
    figure.legend()
    figure.savefig(content, format="svg")
    plt.close(figure)
    return content.getvalue()
