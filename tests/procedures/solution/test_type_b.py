"""Certificates of a rig file as standard uncertainties: the divisors of GUM 4.3, on what each instrument acts on."""

from math import radians, sqrt
from pathlib import Path

import pytest
from planning_files import AIR, rig_file

from ams.inputs.request import CalibrationRequest
from ams.sets.verdict_conditions import NO_DIRECTIONS, NO_GRAVITY, NO_STANDARD_OF_RATES, NO_TABLE
from procedures.description.procedure_file import Solve
from procedures.records.declared_gaps import (
    direction_remarks,
    gravity_remarks,
    meter_remarks,
    rate_remarks,
    table_remarks,
)
from procedures.solution.request import reference_of
from procedures.solution.type_b import (
    gravity_of,
    on_table,
    shared_errors,
    single_approach,
    standard_uncertainty_arcsec,
    table_in_words,
    table_uncertainty,
)
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import DescriptionError

EXAMPLES = Path(__file__).parents[3] / "examples"
METER = ("nplc = 10", 'nplc = 10\nstandard = "meter"')
STANDARDS = """
[standards.meter]
serial = "1"
certificate = "1"
due = 2999-12-31
kind = "expanded"
k = 2.0
uncertainty_v = 1.2e-5
[standards.probe]
serial = "2"
certificate = "2"
due = 2999-12-31
kind = "limit"
uncertainty_degc = 0.3
[standards.resistor]
serial = "3"
certificate = "3"
due = 2999-12-31
kind = "standard"
uncertainty_ohm = 0.02
[chain."dmm.y"]
load_resistor_ohm = 2000.0
standard = "resistor"
[level]
uncertainty_arcsec = 0.5
before = { about_pitch_arcsec = -1.2, about_roll_arcsec = 0.0 }
after = { about_pitch_arcsec = 0.9, about_roll_arcsec = 0.4 }
"""


def declared(folder: Path, *changes: tuple[str, str]) -> RigDescription:
    chamber = AIR.replace('driver = "watlow-f4"', 'driver = "watlow-f4"\nstandard = "probe"')
    gravity = ("gravity_mps2 = 9.80665", "gravity_mps2 = 9.80665\ngravity_uncertainty_mps2 = 3e-6")
    return rig_file(folder, METER, gravity, *changes, more=chamber + STANDARDS)


def test_each_certificate_is_divided_as_it_states(tmp_path: Path) -> None:
    rig = declared(tmp_path)
    errors = shared_errors(rig, rig.sensors["SN1"], "air")
    found = {error.name: (error.effect, error.standard_uncertainty) for error in errors["y"]}
    assert found == {
        "multimeter zero": ("reading", pytest.approx(0.6e-5)),
        "multimeter gain": ("gain", pytest.approx(0.6e-6)),  # of the 10 V range
        "load resistor": ("gain", pytest.approx(0.02 / 2000.0)),
        "level of the base about pitch": ("pitch", pytest.approx(radians(1.3 / sqrt(3.0) / 3600.0))),
        "level of the base about roll": ("base-tilt", pytest.approx(radians(sqrt(0.41) / sqrt(3.0) / 3600.0))),
        "thermometer": ("temperature", pytest.approx(0.3 / sqrt(3.0))),
    }
    assert "load resistor" not in {error.name for error in errors["x"]}
    assert next(e.stated for e in errors["x"]) == "standards.meter: expanded 12 µV, k = 2"


def test_a_meter_is_told_of_wherever_its_volts_bring_no_error_into_the_budget(tmp_path: Path) -> None:
    """The budget is asked: a remark stands exactly where it has no line of the meter."""
    without_volts = STANDARDS.replace("uncertainty_v", "uncertainty_degc")
    for changes, more in (((METER,), STANDARDS), ((), STANDARDS), ((METER,), without_volts), ((), "")):
        rig = rig_file(tmp_path, *changes, more=more)
        counted = {error.name for error in shared_errors(rig, rig.sensors["SN1"])["x"]}
        said = meter_remarks(rig, rig.sensors["SN1"])
        assert len(said) == ("multimeter zero" not in counted), (changes, more)
        lacking = "standards.meter.uncertainty_v" if changes else "readouts.dmm.standard and uncertainty_v of that"
        assert all(lacking in gap.what_to_do for gap in said)
        assert all(("readouts.dmm.standard" in gap.what_to_do) != bool(changes) for gap in said)
    assert len(meter_remarks(declared(tmp_path), None)) == 1


def test_a_gyro_is_told_of_every_axis_that_turns_without_a_standard() -> None:
    rig = read_rig(EXAMPLES / "rate-table" / "rig.toml")
    gyro, turned = rig.sensors["ENC03J"], ("pitch", "yaw")
    (said,) = rate_remarks(rig, gyro, turned)
    assert said.fact.startswith(f"{NO_STANDARD_OF_RATES} (pitch, yaw): ")
    assert said.what_to_do.startswith("declare axes.pitch.standard and axes.yaw.standard")
    (of_yaw,) = rate_remarks(_behind(rig, "pitch"), gyro, turned)
    assert of_yaw.fact.startswith(f"{NO_STANDARD_OF_RATES} (yaw): ")
    assert rate_remarks(_behind(rig, "pitch", "yaw"), gyro, turned) == ()
    assert rate_remarks(rig, gyro.model_copy(update={"measures": "acceleration"}), turned) == ()


def test_a_gyro_is_told_of_every_axis_that_turns_of_whose_direction_nothing_is_declared() -> None:
    """The errors are asked: a remark stands exactly where they have none of that axis."""
    rig = read_rig(EXAMPLES / "rate-table" / "rig.toml")
    gyro, turned = rig.sensors["ENC03J"], ("pitch", "yaw")
    (said,) = direction_remarks(rig, gyro, turned)
    assert said.fact.startswith(f"{NO_DIRECTIONS} (pitch, yaw): ")
    assert said.what_to_do.startswith("declare axes.pitch.direction_uncertainty_arcsec and axes.yaw.direction_unc")
    axes = {name: axis.model_copy(update={"direction_uncertainty_arcsec": 3.0}) for name, axis in rig.axes.items()}
    leaning = rig.model_copy(update={"axes": axes})
    assert direction_remarks(leaning, gyro, turned) == ()
    errors = {error.name: error for error in shared_errors(leaning, gyro)["x"]}
    for name in turned:
        error = errors[f"direction of the {name} axis"]
        assert error.standard_uncertainty == pytest.approx(radians(3.0 / 3600.0) / sqrt(3.0))  # a limit
    assert not any("direction" in error.name for error in shared_errors(rig, gyro)["x"])
    assert direction_remarks(rig, gyro.model_copy(update={"measures": "acceleration"}), turned) == ()


def _behind(rig: RigDescription, *names: str) -> RigDescription:
    """Return the rig with a standard behind these axes."""
    standard = {"standard": "table"}
    axes = {name: axis.model_copy(update=standard if name in names else {}) for name, axis in rig.axes.items()}
    return rig.model_copy(update={"axes": axes})


@pytest.mark.parametrize("declares", [(), ("pitch",), ("roll",), ("pitch", "roll")])
def test_a_table_is_told_of_wherever_an_axis_that_turned_brings_no_index_error(declares: tuple[str, ...]) -> None:
    """The uncertainty of the table is asked: an axis is named exactly where it counts none of it."""
    rig = read_rig(EXAMPLES / "rig.toml")
    axes = {
        name: axis.model_copy(update={"uncertainty_arcsec": 1.0 if name in declares else 0.0, "index_table": None})
        for name, axis in rig.axes.items()
    }
    rig = rig.model_copy(update={"axes": axes})
    said = table_remarks(rig, rig.sensors["SN1047"], ("pitch", "roll"))
    missing = [name for name in ("pitch", "roll") if standard_uncertainty_arcsec(rig, name) == 0.0]
    assert [gap.fact.startswith(f"{NO_TABLE} ({', '.join(missing)}): ") for gap in said] == [True] * bool(missing)
    assert all(f"axes.{name}.uncertainty_arcsec" in gap.what_to_do for gap in said for name in missing)
    assert table_remarks(rig, rig.sensors["SN1047"].model_copy(update={"measures": "rate"}), ("pitch",)) == ()


def test_gravity_is_carried_with_its_uncertainty(tmp_path: Path) -> None:
    gravity = gravity_of(declared(tmp_path))
    assert (gravity.value_mps2, gravity.standard_uncertainty_mps2) == (9.80665, 3e-6)


def test_gravity_by_latitude_and_height_counts_what_anomalies_do_and_one_stated_alone_is_said(tmp_path: Path) -> None:
    """GRS 80 at 45°: 9.806199 m/s², which WGS 84 keeps to 2e-6; free air takes 3.086e-6 off it each metre."""
    stated = "gravity_mps2 = 9.80665"
    by_formula = gravity_of(rig_file(tmp_path, (stated, "latitude_deg = 45.0\nheight_m = 100.0")))
    assert by_formula.value_mps2 == pytest.approx(9.806199 - 3.086e-4, abs=8e-6)
    assert by_formula.standard_uncertainty_mps2 == 0.0005
    known = "latitude_deg = 45.0\nheight_m = 100.0\ngravity_uncertainty_mps2 = 2e-4"
    assert gravity_of(rig_file(tmp_path, (stated, known))).standard_uncertainty_mps2 == 2e-4
    for change, is_said in ((stated, True), (known, False), (f"{stated}\ngravity_uncertainty_mps2 = 3e-6", False)):
        rig = rig_file(tmp_path, (stated, change))
        said = gravity_remarks(rig, senses_gravity=True)
        assert [gap.fact.startswith(NO_GRAVITY) for gap in said] == [True] * is_said, change
        assert gravity_remarks(rig, senses_gravity=False) == ()


@pytest.mark.parametrize("key", ["latitude_deg = 45.0", 'latitude_deg = 45.0\nheight_m = 0.0\ngravity_source = "a"'])
def test_a_gravity_that_is_left_out_is_refused_where_nothing_gives_it(key: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="gravity_mps2"):
        rig_file(tmp_path, ("gravity_mps2 = 9.80665", key))


def test_a_rig_that_declares_nothing_adds_nothing(tmp_path: Path) -> None:
    rig = rig_file(tmp_path)
    assert shared_errors(rig, rig.sensors["SN1"]) == {"x": (), "y": (), "z": ()}
    assert table_in_words(rig) == ""


def test_an_index_without_a_certificate_is_a_limit(tmp_path: Path) -> None:
    rig = rig_file(tmp_path, ("increment_deg = 1.0", "increment_deg = 1.0\nuncertainty_arcsec = 1.0"))
    assert standard_uncertainty_arcsec(rig, "pitch") == pytest.approx(1.0 / sqrt(3.0))
    assert standard_uncertainty_arcsec(rig, "yaw") == 0.0
    assert table_in_words(rig) == ("pitch u 0.58″ (shape unknown: 0.9 of the limit as teeth, once and twice a turn)")


def test_an_axis_with_an_approach_comes_from_one_side_either_way(tmp_path: Path) -> None:
    assert single_approach(rig_file(tmp_path)) == frozenset()
    assert on_table(CalibrationRequest(), None) == CalibrationRequest()
    for approach_deg in (2.0, -2.0):
        changed = ("increment_deg = 1.0", f"increment_deg = 1.0\napproach_deg = {approach_deg}")
        rig = rig_file(tmp_path, changed)
        assert on_table(CalibrationRequest(), rig).single_approach == single_approach(rig) == {"pitch"}


def test_a_list_of_index_errors_is_turned_with_the_sign_of_its_axis(tmp_path: Path) -> None:
    """Machine angle = −attitude + 10°: −50° on the scale is 60°, and what stands too far there is too little."""
    (tmp_path / "index.csv").write_text(
        "angle_deg,error_arcsec,uncertainty_arcsec\n-170,0.0,0.3\n-50,0.9,0.3\n70,-0.6,0.6\n"
    )
    changed = 'uncertainty_arcsec = 1.0\nsign = -1\nzero_deg = 10.0\nindex_zero_deg = 70.0\nindex_table = "index.csv"'
    rig = rig_file(tmp_path, ("increment_deg = 1.0", f"increment_deg = 1.0\n{changed}"))
    table = table_uncertainty(rig)
    assert table is not None
    declared = table.declared("pitch")
    assert declared.zero_rad == pytest.approx(radians(-60.0))
    assert declared.known is not None
    assert declared.known.angle_rad == pytest.approx([radians(-60.0), radians(60.0), radians(180.0)])
    assert declared.known.error_rad * 3600.0 == pytest.approx([radians(0.6), radians(-0.9), 0.0], abs=1e-12)
    assert declared.known.standard_uncertainty_rad[0] * 3600.0 == pytest.approx(radians(0.6 / sqrt(3.0)))
    assert "zero at -60°; corrected by a list of 3 angles" in table_in_words(rig)


def test_an_input_of_ten_megohm_loads_the_resistor(tmp_path: Path) -> None:
    # docs/devices/hp3458a.md (FIXEDZ): 10 MΩ on 100 V; docs/devices/scpi-daq.md: 2.5 kΩ on 10 MΩ are 249.9 ppm.
    loaded = ("y = { scanner = 2, range_v = 10.0 }", "y = { scanner = 2, range_v = 100.0 }")
    rig = rig_file(tmp_path, loaded, more='[chain."dmm.y"]\nload_resistor_ohm = 2500.0\n')
    (error,) = shared_errors(rig, rig.sensors["SN1"])["y"]
    assert (error.name, error.effect) == ("multimeter input", "gain")
    assert error.standard_uncertainty == pytest.approx(250e-6 / sqrt(3.0))
    assert error.stated == "2500 Ω on an input of 1e+07 Ω"


def test_the_reference_attitude_is_what_the_rig_declares_of_table_and_level(tmp_path: Path) -> None:
    rig = declared(tmp_path, ("speed_dps = 5.0", "speed_dps = 5.0\nuncertainty_arcsec = 1.0"))
    found = reference_of(rig, Solve(), shared_errors(rig, rig.sensors["SN1"], "air"))
    assert found.errors.pitch_zero_rad == pytest.approx(radians(1.3 / sqrt(3.0) / 3600.0))
    assert found.errors.base_tilt_rad == pytest.approx(radians(sqrt(0.41) / sqrt(3.0) / 3600.0))
    assert found.errors.table == table_uncertainty(rig)
    assert found.parts == {"table", "level of the base about pitch", "level of the base about roll"}
    assert found.in_words.counted.startswith(
        f"table: {table_in_words(rig)}; level of the base about pitch (read up to 1.2″, instrument ±0.5″); level"
    )
    assert found.in_words.not_counted == "the index errors of roll"


def test_what_nobody_declared_of_the_reference_is_named(tmp_path: Path) -> None:
    of_pitch = ("speed_dps = 5.0", "speed_dps = 5.0\nuncertainty_arcsec = 1.0")
    of_roll = ("speed_dps = 10.0", "speed_dps = 10.0\nuncertainty_arcsec = 1.0")
    none = [(new.partition("\n")[0], new.replace("= 1.0", "= 0.0")) for _, new in (of_pitch, of_roll)]
    for changes, missing in (
        ((of_pitch, of_roll), "the level of the base"),
        ((of_pitch, none[1]), "the index errors of roll and the level of the base"),
        (none, "the index errors of the table and the level of the base"),
    ):
        rig = rig_file(tmp_path, *changes)
        found = reference_of(rig, Solve(), shared_errors(rig, rig.sensors["SN1"]))
        assert found.in_words.not_counted == missing
        assert bool(found.in_words.counted) == (list(changes) != none)
