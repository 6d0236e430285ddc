"""Deliveries without their report: figures, page and paper are two thirds of a small job."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


def _write_nothing(view: object, folder: Path, attachments: object = ()) -> Path:
    return folder / "report.html"


@contextmanager
def reports_left_out() -> Iterator[None]:
    """Deliver in this process without reports for the length of the context; everything else is as ever."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("procedures.delivery.deliver.write_report", _write_nothing)
        yield
