"""What the rows of ``calrig attitude`` cannot tell of their outputs, said after the last one."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Final

import numpy as np

from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.inference import Package
from ams.inference.package.counted_shifts import undeclared_shifts
from ams.inference.rows.angle_stream import AngleStream
from ams.inference.watch.reliability import unseen_of
from ams.inference.watch.reliability_words import unseen_in_words
from procedures.cli.attitude.answered_rows import one_thread
from procedures.cli.output import note, print_json

_SEED: Final = 0
"""Of the draws by which it is found."""


def tell_unseen(
    sensor: str, angles: AngleStream, rows: int, packages: Sequence[Package | GyroPackage], *, json: bool
) -> None:
    """Say what the rows cannot tell of the outputs, and print the document of the answers where one is meant.

    ``packages``: those that the rows were read from.
    """
    with one_thread():
        unseen = unseen_of(angles, np.random.default_rng(_SEED))
    said = None if unseen is None else unseen_in_words(unseen)
    if said is not None:
        note(said)
    if json:
        print_json(
            {
                "sensor": sensor,
                "rows": rows,
                "undeclared_shifts": {
                    used.coefficients.sensor: undeclared_shifts(used.coefficients, used.columns) for used in packages
                },
                "unseen": None if unseen is None else {**asdict(unseen), "text": said},
            }
        )
