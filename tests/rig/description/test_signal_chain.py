"""Laws of what stands between sensor and meter: a reading is brought to the declared supply and load resistor."""

from pathlib import Path

import pytest
from pydantic import ValidationError
from table_bench import rig_file

from rig.description.read import read_rig
from rig.description.signal_chain import Chain
from rig.errors import DescriptionError
from rig.twins.physics.chain import ChainTruth


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
    ("wrong", "expected"),
    [
        ({"ratiometric": True}, "needs supply_channel"),
        ({"ratiometric": True, "supply_channel": "dmm.s"}, "needs supply_channel and supply_nominal_v"),
        ({"ratiometric": True, "supply_channel": "dmm.s", "supply_band_v": [-1.0, 1.0]}, "other than 0 V"),
        ({"load_resistor_tc_per_degc": 1e-5}, "load_resistor_ohm is missing"),
        ({"load_resistor_at": "rack"}, "load_resistor_ohm is missing"),
        ({"load_resistor_ohm": 100.0, "load_resistor_tc_per_degc": 25.0}, "less than or equal to 0.01"),  # ppm
    ],
)
def test_a_chain_that_could_not_be_corrected_for_is_refused(wrong: dict[str, object], expected: str) -> None:
    with pytest.raises(ValidationError, match=expected):
        Chain.model_validate(wrong)


def test_a_resistor_stands_in_an_environment_of_the_file(tmp_path: Path) -> None:
    chain = '[chain."dmm.x"]\nload_resistor_ohm = 2500.0\nload_resistor_at = "rack"\n[twin]\n'
    with pytest.raises(DescriptionError, match=r"load_resistor_at: no environment 'rack' \(allowed: air\)"):
        read_rig(rig_file(tmp_path, ("[twin]\n", chain)))


X = "x = { scanner = 1, range_v = 10.0 }"
SUPPLY_METER = (X, f"s = {{ scanner = 4, range_v = 100.0 }}, {X}")


@pytest.mark.parametrize("keys", ['serial = "PS-1"', "supply_band_v = [14.0, 16.0]", "warm_up_s = 60.0", ""])
def test_a_chain_of_no_sensors_output_is_refused_and_told_where_it_belongs(tmp_path: Path, keys: str) -> None:
    chain = f'[chain."dmm.s"]\n{keys}\n[twin]\n'
    with pytest.raises(DescriptionError, match=r'dmm\.s is no output of a sensor.*supply_channel = "dmm\.s"'):
        read_rig(rig_file(tmp_path, SUPPLY_METER, ("[twin]\n", chain)))


def test_a_supply_that_a_chain_names_may_have_to_warm_up(tmp_path: Path) -> None:
    chain = '[chain."dmm.x"]\nsupply_channel = "dmm.s"\n[chain."dmm.s"]\nwarm_up_s = 60.0\n[twin]\n'
    assert read_rig(rig_file(tmp_path, SUPPLY_METER, ("[twin]\n", chain))).chain["dmm.s"].warm_up_s == 60.0


def test_a_supply_that_is_only_watched_is_healthy_on_the_twin(tmp_path: Path) -> None:
    watched = '[interlocks.voltage."dmm.s"]\nband_v = [14.9, 15.1]\n[twin.supplies."dmm.s"]\nerror_v = 0.02\n[twin]\n'
    rig = read_rig(rig_file(tmp_path, SUPPLY_METER, ("[twin]\n", watched)))
    assert ChainTruth(rig).supply_v("dmm.s", 0.0) == pytest.approx(15.02, rel=1e-15)
    assert ChainTruth(rig).supply_v("dmm.x", 0.0) is None


def test_the_truth_of_a_supply_that_nobody_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"twin\.supplies\.dmm\.s: no supply_channel of a \[chain\]"):
        read_rig(rig_file(tmp_path, SUPPLY_METER, ("[twin]\n", '[twin.supplies."dmm.s"]\nerror_v = 0.02\n[twin]\n')))


@pytest.mark.parametrize(
    ("stated", "band_v", "is_refused"),
    [
        ("supply_nominal_v = 15.0", "[4.9, 5.1]", True),
        ("supply_nominal_v = 15.0", "[14.9, 15.1]", False),
        ("supply_band_v = [14.8, 15.2]", "[4.9, 5.1]", True),
        ("supply_band_v = [14.8, 15.2]", "[15.1, 15.3]", False),
    ],
)
def test_an_interlock_that_leaves_out_what_its_supply_should_be_is_refused(
    tmp_path: Path, stated: str, band_v: str, *, is_refused: bool
) -> None:
    """It would stop every run at once."""
    chain = f'[chain."dmm.x"]\nsupply_channel = "dmm.s"\n{stated}\n'
    more = f'{chain}[interlocks.voltage."dmm.s"]\nband_v = {band_v}\n[twin]\n'
    file = rig_file(tmp_path, SUPPLY_METER, ("[twin]\n", more))
    if not is_refused:
        assert "dmm.s" in read_rig(file).interlocks.voltage
        return
    with pytest.raises(DescriptionError, match=r"4\.9 to 5\.1 V leaves out .*every run would hold at once"):
        read_rig(file)


def _chains(folder: Path, **keys_of: str) -> Path:
    tables = "".join(
        f'[chain."dmm.{channel}"]\nsupply_channel = "dmm.s"\n{keys}\n' for channel, keys in keys_of.items()
    )
    return rig_file(folder, SUPPLY_METER, ("[twin]\n", f"{tables}[twin]\n"))


def test_bands_of_one_supply_that_exclude_one_another_are_refused_with_both_keys(tmp_path: Path) -> None:
    """The last one written won, and the others were watched by nobody."""
    file = _chains(tmp_path, x="supply_band_v = [11.8, 12.2]", y="supply_band_v = [23.8, 24.2]")
    with pytest.raises(DescriptionError) as refused:
        read_rig(file)
    lines = file.read_text(encoding="utf-8").splitlines()
    first, second = (lines.index(f"supply_band_v = {band}") + 1 for band in ("[11.8, 12.2]", "[23.8, 24.2]"))
    said = str(refused.value)
    assert said.startswith(f"{file}:{first}: chain.dmm.x.supply_band_v: dmm.s is to stay at or below 12.2 V here ")
    assert f"at or above 23.8 V by chain.dmm.y.supply_band_v ({file}:{second})" in said


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (
            "supply_nominal_v = 15.0\nsupply_band_v = [4.9, 5.1]",
            r"chain\.dmm\.x\.supply_nominal_v: got 15 V, allowed 4\.9 to 5\.1 V",
        ),
        ("supply_band_v = [5.1, 4.9]", r"chain\.dmm\.x\.supply_band_v: got \[5\.1, 4\.9\], allowed is a lower end"),
    ],
)
def test_a_band_that_leaves_out_its_nominal_or_holds_nothing_is_refused(tmp_path: Path, keys: str, said: str) -> None:
    with pytest.raises(DescriptionError, match=said):
        read_rig(_chains(tmp_path, x=keys))
