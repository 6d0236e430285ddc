"""What the layout of points and replications keeps a calibration from telling, as warnings."""

from collections.abc import Iterator

from ams.observations import Observations
from ams.solve.layout import Layout
from ams.solve.whole_plots import visit_warnings, visits_of
from ams.units import dof_words

_LONGEST_LIST = 8
"""Points that a sentence lists; more are "…"."""


def few_replications(replications: int) -> Iterator[str]:
    """Yield what is held against two or three replications; nothing for more."""
    if replications in (2, 3):
        yield (
            f"{replications} replications only: intervals rest on {dof_words(replications - 1)} and are wide; four or "
            "more make them much narrower"
        )


def layout_warnings(layout: Layout, rows: Observations) -> Iterator[str]:
    if layout.replications == 1:
        yield "one replication only: precision, lack of fit and drift cannot be told apart; measure two or more"
    yield from few_replications(layout.replications)
    for label, points in layout.missing().items():
        some = ", ".join(map(str, points[:_LONGEST_LIST])) + (" …" if len(points) > _LONGEST_LIST else "")
        yield f"replication {label} lacks {len(points)} of {layout.points} points ({some}): used as it is"
    visits = visits_of(rows)
    if visits is not None:
        yield from visit_warnings(layout, visits)
