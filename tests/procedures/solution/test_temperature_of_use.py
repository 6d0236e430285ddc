"""A declared range of use: where the set is valid, and what a data sheet's limit adds to the uncertainties."""

from math import sqrt

import pytest
from example_files import EXAMPLE_RIG

from procedures.solution.type_b import shared_errors, use_warnings
from rig.description.read import read_rig
from rig.errors import DescriptionError


def _rig(tmp_path, **keys):
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    lines = "".join(f"{key} = {value}\n" for key, value in keys.items())
    path = tmp_path / "rig.toml"
    path.write_text(text.replace("[sensors.SN1047]\n", f"[sensors.SN1047]\n{lines}"), encoding="utf-8")
    return read_rig(path)


def test_a_limit_of_the_data_sheet_counts_up_to_the_farther_end_of_the_range(tmp_path) -> None:
    rig = _rig(
        tmp_path, use_temperature_degc="[15.0, 30.0]", largest_offset_tc_v_per_degc=2e-5,
        largest_sensitivity_tc_per_degc=3e-5,
    )  # fmt: skip
    sensor = rig.sensors["SN1047"]
    errors = {shared_error.name: shared_error for shared_error in shared_errors(rig, sensor, None, 22.0)["x"]}
    offset, gain = errors["temperature of use, offset"], errors["temperature of use, sensitivity"]
    assert (offset.effect, offset.standard_uncertainty) == ("reading", pytest.approx(2e-5 * 8.0 / sqrt(3.0)))
    assert (gain.effect, gain.standard_uncertainty) == ("gain", pytest.approx(3e-5 * 8.0 / sqrt(3.0)))
    assert not any("of use" in shared_error.name for shared_error in shared_errors(rig, sensor, None, None)["x"])
    assert use_warnings(sensor, 22.0) == ()


def test_a_range_without_a_model_or_a_limit_is_said(tmp_path) -> None:
    sensor = _rig(tmp_path, use_temperature_degc="[15.0, 30.0]").sensors["SN1047"]
    assert "15 to 30 °C" in use_warnings(sensor, 22.0)[0]
    assert use_warnings(sensor, None) == ()
    (said,) = use_warnings(sensor, None, is_recorded=False)
    assert said.startswith("the sensor is to be used at 15 to 30 °C, as declared, and no temperature was recorded")


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"use_temperature_degc": "[30.0, 15.0]"}, "needs a lower and a higher temperature"),
        ({"largest_offset_tc_v_per_degc": 1e-5}, "belong to use_temperature_degc"),
    ],
)
def test_a_range_upside_down_and_a_limit_without_a_range_are_refused(tmp_path, keys, sentence) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        _rig(tmp_path, **keys)
