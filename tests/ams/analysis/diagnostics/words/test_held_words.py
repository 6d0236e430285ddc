"""The page says of a lack of fit what its finding says."""

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import rows_of_package, table_of

from ams.analysis.diagnostics.beliefs import LACK_OF_FIT
from ams.analysis.diagnostics.words.held_words import held_words
from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest

TOO_LARGE = "more than 1 % of the sensitivity"


@pytest.mark.parametrize(("size_ug", "is_large"), [(30.0, False), (3e4, True)])
@pytest.mark.parametrize("has_table", [False, True])
def test_a_lack_of_fit_is_too_large_only_by_its_size(size_ug: float, is_large: bool, has_table: bool) -> None:
    """Of 30 µg it goes alike over the indices of pitch, so that nothing holds it; memory or order explain it first."""
    drawn = campaigns(
        "wave-along-pitch", size_ug, np.random.default_rng(31), 8, pitch_count=7, roll_count=8, replications=4
    )
    request = CalibrationRequest(table=table_of(1.0) if has_table else None)
    axis = calibrate(rows_of_package(drawn, 4), request).axes["x"]
    (lack,) = [said for said in axis.findings if said.is_significant and said.details.get("test") == LACK_OF_FIT]
    words = held_words(axis.findings, is_drift=False)
    assert not lack.is_held
    assert words in lack.text
    assert (TOO_LARGE in words) is is_large
