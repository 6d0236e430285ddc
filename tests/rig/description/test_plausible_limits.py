"""No declared limit is taken that nothing can have: such a number makes every interval empty of sense, or infinite."""

import re
from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG
from file_keys import changed, keys_of, paths_of, toml_of
from key_jobs import jobs

from ams.models.possible_temperature import COLDEST_DEGC, HOTTEST_DEGC
from rig.description.plausible_limits import IS_DECLARED, POSSIBLE_DEGC
from rig.description.read import read_rig, rig_form
from rig.errors import DescriptionError

SETTINGS = {
    "speed_dps", "increment_deg", "arrival_tolerance_deg", "wrap_turns", "k", "tolerance_deg", "microstep_deg",
    "resolution_deg",
}  # fmt: skip
"""Numbers from 0 on that state no uncertainty of anything."""
STATING = ("axes.*:indexing-table", "field", "sensors", "standards", "level", "laboratory", "acceptance", "rig",
           "attitude_reference")  # fmt: skip
"""Tables of which every other number from 0 on states how wrong something is."""
KEYS = {key: field for key, field in keys_of(rig_form()).items() if not key.startswith("twin.")}
DECLARED = [
    key for key in KEYS if IS_DECLARED.search(key.rpartition(".")[2]) and not key.startswith(("interlocks", "index"))
    and ".index_table." not in key
]  # fmt: skip


def _is_magnitude(key: str) -> bool:
    bounds = [bound for bound in KEYS[key].metadata if getattr(bound, "ge", None) == 0.0 or hasattr(bound, "gt")]
    return bool(bounds) and "float" in str(KEYS[key].annotation)


def test_every_number_of_a_table_that_states_uncertainties_is_bounded() -> None:
    """A key that is added to one of them is a setting, by name, or has a bound."""
    of_them = [key for key in KEYS if key.startswith(STATING) and _is_magnitude(key)]
    assert "sensors.*.largest_offset_shift_v" in of_them
    assert {key for key in of_them if key.rpartition(".")[2] not in SETTINGS} <= set(DECLARED)


@pytest.mark.parametrize("key", DECLARED)
@pytest.mark.parametrize("value", [1e300, float("inf"), float("nan")])
def test_an_impossible_limit_is_refused_by_file_line_and_key(key: str, value: float, tmp_path: Path) -> None:
    document, path = next((job.rig, path) for job in jobs().values() for path in paths_of(job.rig, key))
    if key.startswith("sensors.*.largest") and "_tc_" in key:
        document = changed(document, (*path[:-1], "use_temperature_degc"), [10.0, 35.0])
    if key.endswith("_dps_per_g"):
        document = changed(document, (*path[:-1], "measures"), "rate")
        document = changed(document, (*path[:-1], "nominal_sensitivity_v_per_g"), None)
    if key.endswith("index_zero_uncertainty_arcsec"):
        document = changed(document, (*path[:-1], "index_zero_deg"), 0.0)
    file = tmp_path / "rig.toml"
    file.write_text(toml_of(changed(document, path, value)), encoding="utf-8")
    found = "got 1e\\+300" if value == 1e300 else f"got {value}"
    with pytest.raises(DescriptionError, match=rf"{re.escape(str(file))}:\d+: .*{path[-1]}: .*{found}.*allowed"):
        read_rig(file)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (
            "largest_offset_shift_v = 5",
            "got 5 V, allowed is below 5 V (what its output swings by between +1 g and −1 g",
        ),
        ("largest_nonlinearity_v = 1e300", "got 1e+300 V, allowed is below 5 V"),
        ("largest_sensitivity_shift = 3", "got 3, allowed is below 1 (the whole of it); correct the number, or its"),
        ("largest_offset_shift_v = -1e-3", "got -0.001"),
    ],
)
def test_the_bound_is_that_of_the_very_sensor(line: str, words: str, tmp_path: Path) -> None:
    """2.5 V/g: from +1 g to −1 g the output changes by 5 V, by arithmetic."""
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    assert "nominal_sensitivity_v_per_g = 2.5\n" in text
    file = tmp_path / "rig.toml"
    file.write_text(text.replace("[sensors.SN1047]\n", f"[sensors.SN1047]\n{line}\n"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=re.escape(words)):
        read_rig(file)


def test_an_uncertainty_of_a_table_beyond_half_a_turn_is_refused_and_a_poor_one_is_not(tmp_path: Path) -> None:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    old = re.search(r"^uncertainty_arcsec = .*$", text, re.MULTILINE)
    assert old is not None
    file = tmp_path / "rig.toml"
    file.write_text(text.replace(old[0], "uncertainty_arcsec = 1e9", 1), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"uncertainty_arcsec: got 1e\+09 ″, allowed is below 648000 ″ \(half"):
        read_rig(file)
    file.write_text(text.replace(old[0], "uncertainty_arcsec = 7200.0", 1), encoding="utf-8")
    read_rig(file)


@pytest.mark.parametrize(
    ("range_degc", "told"),
    [
        ((291.0, 299.0), "got 291 to 299 °C, allowed is inside of -100 to 200 °C"),
        ((15.0, 201.0), "give both in °C"),
        ((-101.0, 20.0), "give both in °C"),
        (POSSIBLE_DEGC, ""),
    ],
)
def test_a_temperature_of_use_that_no_sensor_stands_is_refused(
    tmp_path: Path, range_degc: tuple[float, float], told: str
) -> None:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    line = f"[sensors.SN1047]\nuse_temperature_degc = [{range_degc[0]}, {range_degc[1]}]\n"
    path = tmp_path / "rig.toml"
    path.write_text(text.replace("[sensors.SN1047]\n", line), encoding="utf-8")
    if not told:
        assert read_rig(path).sensors["SN1047"].use_temperature_degc == range_degc
        return
    with pytest.raises(DescriptionError, match=r"sensors\.SN1047\.use_temperature_degc: ") as caught:
        read_rig(path)
    assert told in str(caught.value)
    assert ("kelvin: subtract 273.15" in str(caught.value)) is (range_degc[0] > 200.0)


def test_what_a_file_may_state_is_what_readings_may_be() -> None:
    assert POSSIBLE_DEGC == (COLDEST_DEGC, HOTTEST_DEGC)
