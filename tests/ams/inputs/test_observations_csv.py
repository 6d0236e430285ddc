"""A CSV file is read exactly or refused in a sentence with file, line and column."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ams.errors import ObservationsError
from ams.inputs.csv_table import CsvForm
from ams.inputs.observations_csv import read_csv, unit_warnings

HEADER = "replication,point,pitch_deg,roll_deg,temperature_degc,sx_v,sy_v"
ROWS = ["1,1,-30,0,20.5,0.1,0.2", "1,2,30,90,20.6,0.3,-4.5e-3", "2,1,-30,0,20.7,.11,0.21", "2,2,30,90,20.8,0.31,+0.4"]
AXES = {"x": "sx_v", "y": "sy_v"}


@pytest.fixture
def written(tmp_path: Path):
    def write(text: str | bytes) -> Path:
        path = tmp_path / "obs.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def text_of(*rows: str, header: str = HEADER) -> str:
    return "\n".join([header, *rows]) + "\n"


def with_row(number: int, row: str) -> str:
    return text_of(*ROWS[:number], row, *ROWS[number + 1 :])


def test_every_number_arrives_and_degrees_become_radians(written) -> None:
    found = read_csv(written(text_of(*ROWS)), AXES)
    np.testing.assert_array_equal(found.replication, [1, 1, 2, 2])
    np.testing.assert_array_equal(found.point, [1, 2, 1, 2])
    np.testing.assert_array_equal(found.pitch_rad, np.deg2rad([-30, 30, -30, 30]))
    np.testing.assert_array_equal(found.roll_rad, np.deg2rad([0, 90, 0, 90]))
    np.testing.assert_array_equal(found.temperature_degc, [20.5, 20.6, 20.7, 20.8])
    np.testing.assert_array_equal(found.outputs["y"], [0.2, -4.5e-3, 0.21, 0.4])
    assert found.yaw_rad is None
    assert found.source.endswith("obs.csv")


@pytest.mark.parametrize(
    "text",
    [
        text_of(*ROWS).replace("\n", "\r\n"),
        "\ufeff" + text_of(*ROWS),
        text_of(*ROWS).rstrip("\n"),
        text_of(*ROWS[:2], "", ",,,,,,", *ROWS[2:]),
        text_of(*ROWS).replace(",", " , "),
        text_of(*ROWS).replace("0.31", '"0.31"'),
    ],
    ids=["CR LF", "byte order mark", "no last newline", "blank lines", "spaces", "quotes"],
)
def test_what_spreadsheets_do_to_a_file_changes_nothing(written, text: str) -> None:
    found, plain = read_csv(written(text), AXES), read_csv(written(text_of(*ROWS)), AXES)
    np.testing.assert_array_equal(found.outputs["x"], plain.outputs["x"])


def test_numbers_survive_to_the_last_bit(written) -> None:
    values = np.random.default_rng(1).standard_normal(50) * 10.0 ** np.random.default_rng(2).integers(-9, 3, 50)
    rows = [f"1,{i + 1},0,0,20,{value!r},0" for i, value in enumerate(map(float, values))]
    np.testing.assert_array_equal(read_csv(written(text_of(*rows)), AXES).outputs["x"], values)


LOCAL = CsvForm(";", ",")


def local(text: str) -> str:
    return text.replace(",", ";").replace(".", ",")


def test_decimal_commas_survive_to_the_last_bit(written) -> None:
    values = np.random.default_rng(1).standard_normal(50) * 10.0 ** np.random.default_rng(2).integers(-9, 3, 50)
    text = text_of(*(f"1,{i + 1},0.5,0,20.25,{value!r},0" for i, value in enumerate(map(float, values))))
    found, plain = read_csv(written(local(text)), AXES, form=LOCAL), read_csv(written(text), AXES)
    np.testing.assert_array_equal(found.outputs["x"], values)
    np.testing.assert_array_equal(found.pitch_rad, plain.pitch_rad)
    np.testing.assert_array_equal(found.temperature_degc, plain.temperature_degc)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (local(with_row(1, "1,2,30,90,20.6,0.3,0.2")).replace("0,3", "1.234"), r"column sx_v: got '1\.234', allowed a"),
        (local(with_row(1, "1,2,30,90,20.6,0.3,0.2")).replace("0,3", "1.234,5"), r"got '1\.234,5', allowed a finite n"),
        (
            local(with_row(1, "1,2,30,90,20.6,0.3,0.2")).replace("1;2;", "1;2,5;"),
            r"column point: got '2,5', allowed a w",
        ),
        (text_of(*ROWS), r"line 1: columns are separated by commas; allowed: semicolons, with decimal commas"),
    ],
)
def test_a_point_among_decimal_commas_is_refused(written, text: str, match: str) -> None:
    """Whether 1.234 were one or a thousand, nobody knows."""
    with pytest.raises(ObservationsError, match=match):
        read_csv(written(text), AXES, form=LOCAL)


def named(column: str, otherwise: str) -> str:
    return text_of(*ROWS, header=HEADER.replace(column, otherwise))


REFUSED = {
    "missing column": (named("roll_deg", "rol_deg"), r"line 1: column 'roll_deg' missing; found: replication, p"),
    "missing output": (named("sy_v", "sz_v"), r"line 1: column 'sy_v' missing; found: .*sz_v"),
    "not a number": (with_row(1, "1,2,30,90,20.6,abc,0"), r"line 3: column sx_v: got 'abc', allowed a finite number"),
    "nan": (with_row(2, "2,1,-30,0,20.7,0.1,nan"), r"line 4: column sy_v: got 'nan'"),
    "inf": (with_row(2, "2,1,-30,0,20.7,0.1,-inf"), r"line 4: column sy_v: got '-inf'"),
    "overflow": (with_row(2, "2,1,-30,0,20.7,0.1,1e999"), r"line 4: column sy_v: got '1e999'"),
    "underscore": (with_row(0, "1,1,-30,0,20.5,1_0,0.2"), r"line 2: column sx_v: got '1_0'"),
    "other digits": (with_row(0, "1,1,-30,0,20.5,١,0.2"), r"line 2: column sx_v: got"),
    "overload token": (with_row(0, "1,1,-30,0,20.5,OVLD,0.2"), r"line 2: column sx_v: got 'OVLD'"),
    "empty cell": (with_row(3, "2,2,30,90,20.8,,0.4"), r"line 5: column sx_v: the cell is empty"),
    "repeated": (
        text_of(*ROWS, "1,2,30,90,20.6,0.3,0.2"),
        r"line 6: columns replication and point: replication 1, point 2 stands on line 3",
    ),
    "wandering point": (
        with_row(3, "2,2,40,90,20.8,0.31,0.4"),
        r"line 5: column pitch_deg: point 2 has 40° here and 30° on line 3",
    ),
    "fractional label": (with_row(0, "1.5,1,-30,0,20.5,0.1,0.2"), r"line 2: column replication: got '1.5', allowed"),
    "negative label": (with_row(0, "1,-1,-30,0,20.5,0.1,0.2"), r"line 2: column point: got '-1'"),
    "beyond a turn": (with_row(0, "1,1,-30,400,20.5,0.1,0.2"), r"line 2: column roll_deg: got '400', allowed −360° to"),
    "below absolute zero": (with_row(0, "1,1,-30,0,-300,0.1,0.2"), r"line 2: column temperature_degc: got '-300'"),
    "hotter than a sensor": (with_row(0, "1,1,-30,0,300,0.1,0.2"), r"temperature_degc: got .300., allowed −100 to"),
    "short line": (text_of(*ROWS[:3], "2,2,30,90"), r"line 5: 4 cells, allowed 7"),
    "decimal comma": (with_row(0, "1,1,-30,0,20,5,0.1,0.2"), r"line 2: 8 cells, allowed 7.*decimal comma"),
    "semicolons": (text_of(*ROWS).replace(",", ";"), r"line 1: columns are separated by semicolons; allowed: commas"),
    "tabs": (text_of(*ROWS).replace(",", "\t"), r"line 1: columns are separated by tabs"),
    "duplicate header": (named("sy_v", "sx_v"), r"line 1: column 'sx_v' stands 2 times"),
    "header only": (HEADER + "\n", r"a header and no rows"),
    "empty": ("", r"empty: no header"),
    "only blank": ("\n\n", r"empty: no header"),
    "nul": (text_of(*ROWS).replace("0.31", "0\x00"), r"line 5: a NUL character"),
    "open quote": (text_of(*ROWS[:3], '2,2,30,90,20.8,"0.31,0.4'), r"not a CSV line"),
    "not UTF-8": (text_of(*ROWS).encode().replace(b"0.3,", b"\xb50,"), r"line 3: not UTF-8: byte 0xb5"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_wrong_file_is_refused_with_file_line_and_column(written, case: str) -> None:
    text, match = REFUSED[case]
    with pytest.raises(ObservationsError, match=match) as refusal:
        read_csv(written(text), AXES)
    assert str(refusal.value).startswith(str(written(text)))
    assert "nothing was solved" in str(refusal.value)


def test_a_file_that_is_not_there_or_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ObservationsError, match=r"none\.csv: cannot be read: No such file"):
        read_csv(tmp_path / "none.csv", AXES)
    with pytest.raises(ObservationsError, match="cannot be read: Is a directory"):
        read_csv(tmp_path, AXES)


def test_roll_may_be_missing_where_only_pitch_is_asked_for(written) -> None:
    text = "replication,point,pitch_deg,aoa_v\n1,1,-30,0.5\n1,2,30,-0.5\n"
    found = read_csv(written(text), {"aoa": "aoa_v"}, angles=("pitch",))
    np.testing.assert_array_equal(found.roll_rad, [0.0, 0.0])


def test_the_same_index_a_turn_apart_is_the_same_point(written) -> None:
    found = read_csv(written(with_row(2, "2,1,-30,360,20.7,0.1,0.2")), AXES)
    assert found.roll_rad[2] == 2 * np.pi


@settings(max_examples=75, deadline=None)
@given(content=st.one_of(st.binary(max_size=300), st.text(max_size=300).map(lambda t: t.encode("utf-8", "replace"))))
def test_rubbish_is_refused_and_never_a_traceback(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "rubbish.csv"
    path.write_bytes(HEADER.encode() + b"\n" + content)
    with suppress(ObservationsError):
        read_csv(path, AXES)


def test_radians_draw_a_warning_that_names_the_columns(written) -> None:
    pitch = np.deg2rad(np.arange(-90, 91, 10))
    rows = [f"1,{i + 1},{angle!r},0,20,{float(2.5 * np.sin(angle))!r},0.1" for i, angle in enumerate(map(float, pitch))]
    (warning,) = unit_warnings(read_csv(written(text_of(*rows)), AXES), AXES)
    assert "pitch_deg and roll_deg" in warning
    assert "radians?" in warning


@pytest.mark.parametrize("pitch_deg", [np.arange(-90.0, 91.0, 10.0), np.arange(-5.0, 6.0, 1.0), np.linspace(-2, 2, 9)])
def test_right_units_draw_no_warning(written, pitch_deg) -> None:
    rows = [f"1,{i + 1},{angle!r},0,20,0.2,0.1" for i, angle in enumerate(map(float, pitch_deg))]
    assert unit_warnings(read_csv(written(text_of(*rows)), AXES), AXES) == ()


@pytest.mark.parametrize(
    ("read", "likely"), [(295.0, "kelvin: subtract 273.15"), (1e30, "give the temperature in °C"), (385.0, "kelvin")]
)
def test_a_temperature_that_no_sensor_stands_is_refused_with_its_likely_unit(written, read: float, likely: str) -> None:
    rows = [row.split(",") for row in ROWS]
    text = text_of(*(",".join([*row[:4], f"{read}", *row[5:]]) for row in rows))
    with pytest.raises(ObservationsError, match=rf"line 2: column temperature_degc: .*200 °C.*{likely}"):
        read_csv(written(text), AXES)


def test_the_limits_of_every_servo_accelerometer_are_taken(written) -> None:
    for read in ("-55", "125", "177"):
        found = read_csv(written(with_row(0, f"1,1,-30,0,{read},0.1,0.2")), AXES)
        assert found.temperature_degc[0] == float(read)
