"""Deliveries without their report: figures, page and paper are two thirds of a small job."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


def _draw_nothing(view: object, tell: object = None) -> object:
    return view


def _write_no_screen(drawn: object, folder: Path) -> Path:
    return folder / "report.html"


def _write_no_paper(drawn: object, folder: Path, attachments: object = ()) -> Path:
    return folder / "report.pdf"


def _write_no_documents(*_: object) -> None:
    return None


@contextmanager
def reports_left_out() -> Iterator[None]:
    """Deliver in this process without reports for the length of the context; everything else is as ever."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("procedures.delivery.deliver.draw_report", _draw_nothing)
        patch.setattr("procedures.delivery.deliver.write_screen", _write_no_screen)
        patch.setattr("procedures.delivery.deliver.write_paper", _write_no_paper)
        patch.setattr("procedures.delivery.deliver._write_sensor_documents", _write_no_documents)
        yield
