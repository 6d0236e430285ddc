"""What teeth of a table leave has the form of several memories at once: an output is told one of them at most."""

from pathlib import Path

import numpy as np

from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

SHIPPED = Path(__file__).parents[4] / "examples" / "observations.csv"


def test_one_memory_at_most_is_told_of_an_output() -> None:
    """The shipped readings are of a table with uneven teeth, solved here as if its certificate were not known."""
    read = np.genfromtxt(SHIPPED, delimiter=",", names=True)
    rows = Observations(
        read["replication"].astype(int), read["point"].astype(int), np.deg2rad(read["pitch_deg"]),
        np.deg2rad(read["roll_deg"]), {axis: read[f"s{axis}_v"] for axis in "xyz"},
    )  # fmt: skip
    told = [
        [found for found in axis.findings if found.is_significant and "remembers the attitudes" in found.text]
        for axis in calibrate(rows, CalibrationRequest()).axes.values()
    ]
    assert any(told), "the scene shows no memory at all"
    assert max(map(len, told)) == 1
