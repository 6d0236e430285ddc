"""Laws of what stands between sensor and meter: a reading is brought to the declared supply and load resistor."""

from pathlib import Path

import pytest
from pydantic import ValidationError
from table_bench import rig_file

from rig.description.read import read_rig
from rig.description.signal_chain import Chain
from rig.errors import DescriptionError


def test_a_ratiometric_reading_follows_its_supply() -> None:
    chain = Chain(ratiometric=True, supply_channel="dmm.s", supply_nominal_v=5.0)
    # 2.5 V/g at 5 V is 2.525 V/g at 5.05 V.
    assert 2.525 / chain.factor(5.05, None) == pytest.approx(2.5, rel=1e-15)
    assert Chain(supply_channel="dmm.s", supply_nominal_v=5.0).factor(5.05, None) == 1.0


def test_a_load_resistor_follows_its_temperature() -> None:
    # 1 mA in 2500 ohm with 25 ppm/°C, 8 °C warmer than declared: 2.5005 V.
    chain = Chain(load_resistor_ohm=2500.0, load_resistor_tc_per_degc=25e-6, load_resistor_at="rack")
    assert 2.5005 / chain.factor(None, 31.0) == pytest.approx(2.5, rel=1e-15)
    assert chain.factor(None, 23.0) == chain.factor(None, None) == 1.0


def test_the_nominal_supply_is_the_middle_of_its_band_unless_it_is_given() -> None:
    assert Chain(supply_band_v=(4.9, 5.1)).reference_supply_v == 5.0
    assert Chain(supply_band_v=(4.9, 5.1), supply_nominal_v=4.99).reference_supply_v == 4.99


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"ratiometric": True}, "needs supply_channel"),
        ({"ratiometric": True, "supply_channel": "dmm.s"}, "needs supply_channel and supply_nominal_v"),
        ({"ratiometric": True, "supply_channel": "dmm.s", "supply_band_v": [-1.0, 1.0]}, "other than 0 V"),
        ({"load_resistor_tc_per_degc": 1e-5}, "load_resistor_ohm is missing"),
        ({"load_resistor_at": "rack"}, "load_resistor_ohm is missing"),
        ({"load_resistor_ohm": 100.0, "load_resistor_tc_per_degc": 25.0}, "less than or equal to 0.01"),  # ppm
    ],
)
def test_a_chain_that_could_not_be_corrected_for_is_refused(wrong: dict[str, object], told: str) -> None:
    with pytest.raises(ValidationError, match=told):
        Chain.model_validate(wrong)


def test_a_resistor_stands_in_an_environment_of_the_file(tmp_path: Path) -> None:
    chain = '[chain."dmm.x"]\nload_resistor_ohm = 2500.0\nload_resistor_at = "rack"\n[twin]\n'
    with pytest.raises(DescriptionError, match=r"load_resistor_at: no environment 'rack' \(allowed: air\)"):
        read_rig(rig_file(tmp_path, ("[twin]\n", chain)))
