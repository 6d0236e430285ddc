"""A set is used with the chain and at the place it was calibrated for, or not at all."""

import re

import numpy as np
import pytest
from solved import provenance, solved_package

from ams.errors import OutsideValidity
from ams.exports.formats import FORMATS
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set

CHAIN = {"dmm.x": {"serial": "C-17", "load_resistor_ohm": 2500.0}, "dmm.y": {"serial": "C-17"}, "dmm.z": {}}


def calibrated(**changes: object) -> CoefficientSet:
    return build_set(solved_package(), provenance(**changes))


def test_the_calibrated_chain_and_site_are_accepted() -> None:
    coefficients = calibrated(chain={name: {"serial": "C-17"} for name in ("dmm.x", "dmm.y", "dmm.z")})
    apply(coefficients, 0.0, 0.0, chain_serial="C-17", site_gravity_mps2=9.79826)
    apply(coefficients, 0.0, 0.0, chain_serial={"dmm.y": "C-17"}, site_gravity_mps2=9.79827)


@pytest.mark.parametrize("used", ["C-18", {"dmm.x": "C-18"}])
def test_another_chain_is_refused(used: str | dict[str, str]) -> None:
    sentence = (
        "SN1047: chain of dmm.x: is not shown to be the calibrated one: got serial 'C-18', calibrated with 'C-17'"
    )
    with pytest.raises(OutsideValidity, match=re.escape(sentence)):
        apply(calibrated(chain=CHAIN), 0.0, 0.0, chain_serial=used)


@pytest.mark.parametrize("used", ["C-17", {"dmm.z": "C-17"}, {"dmm.w": "C-17"}])
def test_a_chain_that_the_set_does_not_state_is_refused(used: str | dict[str, str]) -> None:
    with pytest.raises(OutsideValidity, match="got serial 'C-17', the set states no serial of it; nothing was"):
        apply(calibrated(chain=CHAIN), 0.0, 0.0, chain_serial=used)


def test_a_set_without_any_chain_belongs_to_none() -> None:
    with pytest.raises(OutsideValidity, match=r"chain of the sensor: .*the set states no serial of it"):
        apply(calibrated(chain=None), 0.0, 0.0, chain_serial="C-17")


@pytest.mark.parametrize("site_mps2", [9.80665, 9.79823, 9.79829, np.nan])
def test_another_site_is_refused(site_mps2: float) -> None:
    """2e-5 m/s² is six metres of height by the free-air gradient, 3.1e-6 per second squared."""
    with pytest.raises(OutsideValidity, match=r"SN1047: site gravity: is not that of the calibration: got .* 9\.79826"):
        apply(calibrated(), 0.0, 0.0, site_gravity_mps2=site_mps2)


def test_the_factor_in_the_sentence_carries_the_sensitivity_to_the_site() -> None:
    """A sensor of 0.25 V per m/s²: 2.4496 V per g of 9.7983, 2.4517 V per g of 9.80665."""
    with pytest.raises(OutsideValidity) as caught:
        apply(calibrated(), 0.0, 0.0, site_gravity_mps2=9.80665)
    text = re.search(r"multiply every k by ([\d.]+)", str(caught.value))
    assert text is not None
    assert 0.25 * 9.79826 * float(text[1]) == pytest.approx(0.25 * 9.80665, rel=1e-14)


@pytest.mark.parametrize("name", FORMATS)
def test_a_set_from_every_format_is_applied_and_refused_alike(name: str) -> None:
    coefficients = calibrated(chain=CHAIN)
    back = FORMATS[name].from_bytes(FORMATS[name].to_bytes(coefficients), "file")
    pitch, roll = np.radians([20.0, -40.0]), np.radians([-75.0, 110.0])
    for axis, expected_v in apply(coefficients, pitch, roll).items():
        assert apply(back, pitch, roll)[axis].tolist() == expected_v.tolist()
    with pytest.raises(OutsideValidity, match=r"chain of dmm\.x"):
        apply(back, pitch, roll, chain_serial="C-18")
    with pytest.raises(OutsideValidity, match="site gravity"):
        apply(back, pitch, roll, site_gravity_mps2=9.81)
