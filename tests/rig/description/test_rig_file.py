"""Laws of the rig file: every mistake is named by file, line and key, before any port is opened."""

import re
from pathlib import Path

import pytest
from example_files import EXAMPLE_PROCEDURE, EXAMPLE_RIG, changed
from hypothesis import given, settings
from hypothesis import strategies as st

from procedures.kinds.read import read_procedure
from rig.description.read import read_rig, rig_from_json
from rig.errors import DescriptionError

MISTAKES = [
    ("unknown key", "speed_dps", "sped_dps", "axes.pitch.sped_dps: unknown key; did you mean speed_dps?"),
    (
        "a key of the file's head in a table",
        "[rig]\n",
        '[rig]\napproved_by = "A. Person"\n',
        "rig.approved_by: unknown key: approved_by stands at the head of the file, above its first table",
    ),
    (
        "missing unit",
        "limits_deg =",
        "limits =",
        "axes.pitch.limits: unknown key: the unit is missing; write limits_deg",
    ),
    (
        "another unit",
        'kind = "limit"\nuncertainty_arcsec = 1.0',
        'kind = "limit"\nuncertainty_deg = 0.001',
        "standards.table.uncertainty_deg: unknown key; did you mean uncertainty_arcsec?",
    ),
    (
        "missing unit deep inside",
        "range_v = 10.0",
        "range = 10.0",
        "readouts.dmm.channels.x.range: unknown key: the unit is missing",
    ),
    ("duplicate key", "seed = 7", "seed = 7\nseed = 8", "twin.seed: is written twice, first on line "),
    ("wrong type", "noise_v = 0.00002", 'noise_v = "small"', "twin.truth.SN1047.x.noise_v: got 'small'"),
    ("text for a number", "nplc = 10", 'nplc = "10"', "readouts.dmm.nplc: got '10'"),
    ("out of range", "coning_deg = 0.5", "coning_deg = 95.0", "twin.truth.SN1047.x.coning_deg: got 95.0"),
    ("not a number", "gravity_mps2 = 9.79826", "gravity_mps2 = nan", "rig.gravity_mps2: got nan"),
    ("infinite", "speed_dps = 5.0", "speed_dps = inf", "axes.pitch.speed_dps: got inf"),
    ("gravity in g", "gravity_mps2 = 9.79826", "gravity_mps2 = 1.0", "rig.gravity_mps2: got 1.0"),
    ("unknown driver", '"hp3458a"', '"hp3457a"', "readouts.dmm.driver: got 'hp3457a'"),
    ("driver misspelt", '"hp3458a"', '"hp3548a"', "; did you mean 'hp3458a'?"),
    (
        "driver missing",
        'driver = "hp3458a"\n',
        "",
        "readouts.dmm.driver: is missing, allowed 'angle-meter', 'hp3458a', ",
    ),
    ("word misspelt", 'kind = "limit"', 'kind = "limits"', "; did you mean 'limit'?"),
    (
        "mount in part",
        'model = "three-axis package"',
        'mount = { x = "+z" }',
        "y = '+y' and z = '+z' was taken, since nothing is given there: give x, y and z",
    ),
    (
        "limits reversed",
        "[-180.0, 180.0]",
        "[180.0, -180.0]",
        "axes.pitch.limits_deg: got [180.0, -180.0], allowed is [low, high]",
    ),
    ("unknown channel", '"dmm.x"', '"dmm.w"', "sensors.SN1047.channels.x: no channel 'dmm.w'"),
    ("channel used twice", 'y = "dmm.y"', 'y = "dmm.x"', "channel 'dmm.x' already belongs to SN1047.x"),
    (
        "scanner channel used twice",
        "scanner = 2",
        "scanner = 1",
        "dmm.channels: scanner channel 101 is used by x, y;",
    ),
    (
        "corrections of a standard",
        'kind = "limit"',
        'kind = "limit"\ncorrection_file = "no-such-file.csv"',
        "standards.table.correction_file: a standard states an uncertainty, and corrections stand where they are used; "
        "remove it. Errors that a table's certificate lists at angles are corrected by axes.NAME.index_table",
    ),
    (
        "a coverage factor below 1",
        'kind = "limit"\nuncertainty_arcsec = 1.0',
        'kind = "expanded"\nk = 0.5\nuncertainty_arcsec = 1.0',
        "standards.table.k: got 0.5: allowed is 1 or more: an expanded uncertainty is k times the standard one",
    ),
    ("unknown standard", 'standard = "table"', 'standard = "tabel"', "axes.pitch.standard: no standard 'tabel'"),
    (
        "two-axis package of three",
        "three-axis package",
        "two-axis package",
        "a two-axis package has 2 channels, got x, y, z",
    ),
    ("truth missing", "[twin.truth.SN1047.z]", "[twin.truth.SN1048.z]", "[twin.truth.SN1047.z] is missing"),
    ("no sensitivity", "nominal_sensitivity_v_per_g = 2.5", "nominal_sensitivity_v_per_g = 0.0", "must not be 0"),
    (
        "an axis without sensitivity",
        "nominal_sensitivity_v_per_g = 2.5",
        "nominal_sensitivity_v_per_g = { x = 2.5, y = 0.5 }",
        "names x, y; needed is one number for all axes, or one for each of x, y, z",
    ),
    (
        "a sensitivity of zero",
        "nominal_sensitivity_v_per_g = 2.5",
        "nominal_sensitivity_v_per_g = { x = 2.5, y = 0.0, z = 0.5 }",
        "must not be 0 (axis y)",
    ),
    (
        "a sensitivity in words",
        "nominal_sensitivity_v_per_g = 2.5",
        'nominal_sensitivity_v_per_g = { x = "much", y = 0.5, z = 0.5 }',
        "sensors.SN1047.nominal_sensitivity_v_per_g",
    ),
    (
        "a range too small for one axis",
        "nominal_sensitivity_v_per_g = 2.5",
        "nominal_sensitivity_v_per_g = { x = 2.5, y = 0.5, z = -50.0 }",
        "SN1047.z is declared to make 50 V at one g",
    ),
    ("not TOML", "[rig]", "[rig", "not valid TOML"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), [m[1:] for m in MISTAKES], ids=[m[0] for m in MISTAKES])
def test_a_mistake_is_named_by_file_line_and_key(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    path = changed(EXAMPLE_RIG, old, new, tmp_path / "rig.toml")
    with pytest.raises(DescriptionError, match=re.escape(sentence)) as caught:
        read_rig(path)
    assert all(re.match(rf"{re.escape(str(path))}:\d+: ", line) for line in str(caught.value).splitlines())


def test_the_line_is_the_line_of_the_key(tmp_path: Path) -> None:
    path = changed(EXAMPLE_RIG, "coning_deg = 0.4", "coning_deg = -0.4", tmp_path / "rig.toml")
    line = path.read_text().splitlines().index("coning_deg = -0.4") + 1
    with pytest.raises(DescriptionError, match=rf"rig\.toml:{line}: twin\.truth\.SN1047\.z\.coning_deg"):
        read_rig(path)


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    first = changed(EXAMPLE_RIG, "coning_deg = 0.4", "coning_deg = -0.4", tmp_path / "one.toml")
    both = changed(first, "nplc = 10", "nplc = 0", tmp_path / "two.toml")
    with pytest.raises(DescriptionError) as caught:
        read_rig(both)
    assert "coning_deg" in str(caught.value)
    assert "nplc" in str(caught.value)


def test_two_axes_of_one_controller_need_two_numbers(tmp_path: Path) -> None:
    text = EXAMPLE_RIG.read_text().replace('port = "twin"', 'port = "/dev/serial/by-id/table"', 2)
    path = tmp_path / "rig.toml"
    path.write_text(text.replace("axis = 2", "axis = 1"))
    with pytest.raises(DescriptionError, match=r"axes\.roll\.axis: axis 1 at /dev/serial/by-id/table is already pitch"):
        read_rig(path)


def test_a_missing_file_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="no such file"):
        read_rig(tmp_path / "nowhere.toml")


def test_a_file_that_is_not_text_is_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_bytes(b"\xff\xfe\x00binary")
    with pytest.raises(DescriptionError, match="not UTF-8"):
        read_rig(path)


def test_the_rehearsal_of_a_real_rig_touches_no_address(tmp_path: Path) -> None:
    text = EXAMPLE_RIG.read_text().replace(
        'driver = "watlow-f4"\nport = "twin"', 'driver = "watlow-f4"\nport = "socket://10.0.0.9:4002"'
    )
    text = text.replace('port = "twin"', 'port = "socket://10.0.0.9:4001"')
    text = text.replace('resource = "twin"', 'resource = "prologix+socket://10.0.0.9:1234#22"')
    path = tmp_path / "rig.toml"
    path.write_text(text[: text.index("\n[twin]\n")])
    rehearsed = read_rig(path).all_on_twins()
    assert rehearsed.uses_twins
    assert "10.0.0.9" not in rehearsed.model_dump_json()
    assert set(rehearsed.twin.truth["SN1047"]) == {"x", "y", "z"}


@settings(max_examples=100, deadline=None)
@given(position=st.integers(0, len(EXAMPLE_RIG.read_bytes()) - 1), byte=st.integers(0, 255))
def test_any_changed_byte_is_accepted_or_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, position: int, byte: int
) -> None:
    data = bytearray(EXAMPLE_RIG.read_bytes())
    data[position] = byte
    path = tmp_path_factory.getbasetemp() / "changed.toml"
    path.write_bytes(bytes(data))
    try:
        read_rig(path)
    except DescriptionError as error:
        assert str(path) in str(error)  # noqa: PT017  both outcomes are lawful


def test_every_axis_may_have_a_nominal_of_its_own(tmp_path: Path) -> None:
    """TP recommends a sharp x beside blunter y and z."""
    each = "nominal_sensitivity_v_per_g = { x = 2.5, y = 0.5, z = -0.5 }"
    rig = read_rig(changed(EXAMPLE_RIG, "nominal_sensitivity_v_per_g = 2.5", each, tmp_path / "rig.toml"))
    sensor = rig.sensors["SN1047"]
    assert [sensor.nominal_v_per_g(axis) for axis in "xyz"] == [2.5, 0.5, -0.5]
    entry = read_rig(EXAMPLE_RIG).sensors["SN1047"]
    assert [entry.nominal_v_per_g(axis) for axis in "xyz"] == [2.5, 2.5, 2.5]
    bare = rig.model_copy(update={"twin": None}).all_on_twins()
    assert bare.twin is not None
    assert [bare.twin.truth["SN1047"][axis].sensitivity_v_per_g for axis in ("x", "y", "z")] == [2.5, 0.5, -0.5]


def test_a_procedure_in_place_of_a_rig_is_told_as_that_and_not_key_by_key() -> None:
    with pytest.raises(DescriptionError, match=r"^\S+procedure.toml:1: procedure: this is a procedure file, and a rig"):
        read_rig(EXAMPLE_PROCEDURE)
    with pytest.raises(DescriptionError, match=r"^\S+rig.toml:\d+: rig: this is a rig file, and a procedure"):
        read_procedure(EXAMPLE_RIG)


def _with_level(folder: Path, taken: str) -> Path:
    level = f"[level]\nbefore = {{ about_pitch_arcsec = 0.4, about_roll_arcsec = 0.0, taken = {taken} }}\n\n"
    return changed(EXAMPLE_RIG, "[standards.table]", level + "[standards.table]", folder / "rig.toml")


@pytest.mark.parametrize(
    ("taken", "stands"),
    [
        ("2026-03-01", "2026-03-01"),
        ("2026-03-01T08:30:00Z", "2026-03-01T08:30:00+00:00"),
        ('"2026-03-01"', "2026-03-01"),
        ('"2026-03-01T08:30:00Z"', "2026-03-01T08:30:00Z"),
    ],
)
def test_the_day_of_a_level_reading_is_a_date_of_toml_or_its_text(tmp_path: Path, taken: str, stands: str) -> None:
    rig = read_rig(_with_level(tmp_path, taken))
    assert rig.level.before is not None
    assert rig.level.before.taken == stands
    assert rig_from_json(rig.model_dump_json()) == rig


@pytest.mark.parametrize("taken", ['"today"', '"24.11.2026"', "08:30:00", "20260301"])
def test_what_is_no_day_is_refused(tmp_path: Path, taken: str) -> None:
    path = _with_level(tmp_path, taken)
    with pytest.raises(DescriptionError, match=r"rig.toml:\d+: level.before.taken: got .*2026-03-01T08:30:00Z"):
        read_rig(path)


def test_readings_of_the_level_that_are_interchanged_are_refused(tmp_path: Path) -> None:
    level = "before = { about_pitch_arcsec = 0.4, about_roll_arcsec = 0.0, taken = 2026-03-02T08:00:00 }\n"
    level += 'after = { about_pitch_arcsec = 0.5, about_roll_arcsec = 0.0, taken = "20260301" }\n\n'
    path = changed(EXAMPLE_RIG, "[standards.table]", f"[level]\n{level}[standards.table]", tmp_path / "rig.toml")
    with pytest.raises(DescriptionError, match=r"toml:\d+: level: .*on 2026-03-01, earlier than before \(2026-03-02"):
        read_rig(path)
    path.write_text(path.read_text(encoding="utf-8").replace('"20260301"', '"2026-03-02"'), encoding="utf-8")
    stored = read_rig(path).model_dump_json()
    earlier = stored.replace("2026-03-02T08", "2026-03-03T08")
    assert rig_from_json(earlier).level.after is not None


def test_a_run_that_was_stored_with_any_words_for_that_day_is_still_read(tmp_path: Path) -> None:
    path = _with_level(tmp_path, "2026-03-01")
    stored = read_rig(path).model_dump_json().replace('"2026-03-01"', '"this morning"')
    before = rig_from_json(stored).level.before
    assert before is not None
    assert before.taken == "this morning"


def test_a_run_that_was_stored_with_a_coverage_factor_below_one_is_still_read(tmp_path: Path) -> None:
    now = 'kind = "expanded"\nk = 1.0\nuncertainty_arcsec = 1.0'
    path = changed(EXAMPLE_RIG, 'kind = "limit"\nuncertainty_arcsec = 1.0', now, tmp_path / "rig.toml")
    stored = read_rig(path).model_dump_json()
    assert '"k":1.0' in stored
    assert rig_from_json(stored.replace('"k":1.0', '"k":0.5')).standards["table"].k == 0.5


@pytest.mark.parametrize("name", ["", "   "])
def test_an_approval_needs_a_name(tmp_path: Path, name: str) -> None:
    """Such a rig passed for approved in check and at a run's begin, and its sets for engineering."""
    path = tmp_path / "rig.toml"
    path.write_text(f'approved_by = "{name}"\n' + EXAMPLE_RIG.read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"rig\.toml:1: approved_by: .*allowed is the name of whoever approved"):
        read_rig(path)
