"""The section ``use``: what follows from the coefficients and from what the rig declares."""

import numpy as np
import pytest
from solved import provenance, solved_axis, solved_package

from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.instructions import use_of


def used(coefficients: CoefficientSet) -> dict:
    section = use_of(coefficients.document)
    assert section is not None
    return section


def test_polarity_is_what_the_output_does_when_the_axis_is_turned_upwards() -> None:
    coefficients = build_set(solved_package(), provenance())
    upwards = {"x": (np.pi / 2, 0.0), "y": (0.0, -np.pi / 2), "z": (0.0, np.pi)}
    level_v = {name: numbers.primary["offset_v"] for name, numbers in coefficients.axes.items()}
    seen = {
        name: np.sign(float(apply(coefficients, *attitude)[name]) - level_v[name]) for name, attitude in upwards.items()
    }
    assert seen == used(coefficients)["polarity"] == {"x": 1, "y": 1, "z": -1}


def test_the_installation_turns_coefficients_into_package_axes() -> None:
    """A package with its y to the right and its x down, as on a bracket: body x along +z, y along +y, z along −x."""
    mount = {"x": "+z", "y": "+y", "z": "-x", "datum": "face B"}
    installation = used(build_set(solved_package(), provenance(mount=mount)))["installation"]
    rotation = np.array(installation["fixture_to_package"])
    assert rotation.tolist() == [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert (rotation @ [0.0, 0.0, -1.0]).tolist() == [-1.0, 0.0, 0.0]
    assert installation["datum"] == "face B"


@pytest.mark.parametrize("mount", [None, {"x": "+pitch"}, {"x": "+x", "y": "+y"}])
def test_a_mount_that_is_not_declared_as_axes_has_no_rotation(mount: dict | None) -> None:
    assert used(build_set(solved_package(), provenance(mount=mount)))["installation"]["fixture_to_package"] is None


def test_chain_thermometer_and_rezeroing_are_stated() -> None:
    thermometer = {"channel": "dmm.t", "offset_degc": -273.15, "slope_degc_per_v": 100.0}
    chain = {"dmm.x": {"serial": "C-17"}, "dmm.y": {"ratiometric": True}}
    section = used(build_set(solved_package(), provenance(temperature_conversion=thermometer, chain=chain)))
    assert section["chain_serials"] == {"dmm.x": "C-17", "dmm.y": None}
    assert section["temperature_conversion"]["slope_degc_per_v"] == 100.0
    assert section["temperature_conversion"]["text"].startswith("T in degC = offset_degc + slope_degc_per_v * volts")
    assert section["wind_off_rezero"]["terms"] == ["offset_v"]


def test_rezeroing_as_the_text_says_restores_a_shifted_sensor() -> None:
    """Wind-off at 12° of pitch the output is 3 mV off; offset_v = output − k·f takes it up everywhere."""
    axis = solved_axis("x")
    f = np.array([np.sin(np.radians(12.0)), 0.0, -np.cos(np.radians(12.0))])
    output_v = axis.primary[0] + 0.003 + axis.primary[1:] @ f
    assert output_v - axis.primary[1:] @ f == pytest.approx(axis.primary[0] + 0.003, rel=1e-14)
