"""What the manuals of attitude references show, put to driver and twin: docs/devices/attitude-references.md."""

from collections.abc import Mapping
from pathlib import Path

import pytest
from instrument_rigs import angle_meter_rig_file
from table_bench import virtual_clock

from rig.assembly.open_rig import Rig, open_rig
from rig.description.read import read_rig
from rig.devices.angle_meter import AngleMeter, AngleMeterSettings
from rig.errors import DescriptionError, DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused
from rig.link.memory import MemoryStream
from rig.motion.move import home_and_arrive, move_and_arrive
from rig.testing import survive_damage
from rig.twins.angle_meter import AngleMeterTwin
from rig.wire.angle_dialect import angle_dialects, load_angle_dialect, to_deg
from rig.wire.angle_lines import AngleCodec

TUFF = b"$YXXDR,A,-00.920,D,N,A,-00.210,D,E,C,030.045,C,T-N1212*57\r\n"
"""B-06-1006, p. 15: first north (y), then east (x)."""


class Scripted:
    """A device that answers as a manual shows, and says nothing to the rest."""

    def __init__(self, answers: Mapping[bytes, bytes], unasked: bytes = b"") -> None:
        self.questions: list[bytes] = []
        self._answers, self._due = answers, unasked

    def receive(self, data: bytes, now_s: float) -> None:
        self.questions.append(data)
        self._due += self._answers.get(data, b"")

    def transmit(self, now_s: float) -> bytes:
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None


def meter(dialect: str, device: object, **settings: object) -> AngleMeter:
    clock = virtual_clock()
    channels = settings.pop("channels", {"x": {"about": "pitch"}})
    form = AngleMeterSettings.model_validate(
        {"driver": "angle-meter", "resource": "twin", "dialect": dialect, "channels": channels, **settings}
    )
    stream = MemoryStream(device, clock, "level")  # type: ignore[arg-type]
    return AngleMeter("level", form, load_angle_dialect(dialect), stream, clock)


def reads(level: AngleMeter, channel: str = "level.x", samples: int = 1) -> list[float]:
    burst = level.read(channel, samples, virtual_clock().sleep)
    assert burst.unit == "deg"
    values: list[float] = burst.samples.tolist()
    return values


BOTH = {"x": {"about": "pitch"}, "y": {"about": "roll", "value": "y"}}


def test_the_tuff_tilt_s_frame_is_read_and_its_unit_with_it() -> None:
    level = meter("jewell-tuff-tilt", Scripted({b"*9900XY\r\n": TUFF}), channels=BOTH)
    assert reads(level) == [-0.21]
    assert reads(level, "level.y") == [-0.92]
    assert level.identify().endswith("values in deg")


@pytest.mark.parametrize(
    "body", [b"000.034,D,N,A,-00.625,D,E,C,021.651,C,T-N0000*47", b"000.034,D,N,A,-00.624,D,E,C,021.686,C,T-N0000*4C"]
)
def test_the_tuff_tilt_s_sample_lines_carry_a_right_checksum(body: bytes) -> None:
    codec = AngleCodec(load_angle_dialect("jewell-tuff-tilt"))  # p. 12
    assert codec.parse_reading(b"$YXXDR,A," + body, 1).values["y"] == 0.034
    with pytest.raises(DeviceNonsense, match="its checksum is wrong"):
        codec.parse_reading(b"$YXXDR,A," + body.replace(b"034", b"035"), 1)


def test_microradians_are_told_by_the_letter_behind_the_number() -> None:
    """P. 15: "Units, M=microradians, D=degrees"; a factor of 57 296 otherwise."""
    codec = AngleCodec(load_angle_dialect("jewell-tuff-tilt"))
    level = meter("jewell-tuff-tilt", Scripted({b"*9900XY\r\n": codec.format_reading(100.0, 0.0, "urad", 1)}))
    assert reads(level) == pytest.approx([0.0057296], rel=1e-4)


def test_the_format_that_tells_no_unit_is_refused() -> None:
    """P. 15: SIM is the default and has none."""
    level = meter("jewell-tuff-tilt", Scripted({b"*9900XY\r\n": b"$-00.920,-00.210,030.045,N1212\r\n"}))
    with pytest.raises(DeviceNonsense, match="checksum"):
        level.prepare()


@pytest.mark.parametrize(("dialect", "letter"), [("meas-dpg", b"s"), ("bei-ags", b"f")])
def test_what_streams_from_power_on_is_told_to_stop_before_it_is_asked(dialect: str, letter: bytes) -> None:
    """DPG p. 10: "After startup the sensor transmits the angle values in degrees continuously"; AGS p. 10 the same."""
    answers = {letter: letter, b"R": b"X=+01.234\r\nY=-00.007\r\n", b"V": b"DPL2 V1.8.0\r\nSN:123456789\r\n"}
    device = Scripted(answers, unasked=b"X=+99.000\r\nY=+9")
    level = meter(dialect, device, channels=BOTH)
    level.prepare()
    assert reads(level, samples=3) == [1.234] * 3
    assert reads(level, "level.y") == [-0.007]
    assert device.questions[0] == letter
    assert device.questions.count(letter) == 1


def test_the_dpg_says_who_it_is() -> None:
    level = meter("meas-dpg", Scripted({b"s": b"s", b"V": b"DPL2 V1.8.0\r\nSN:123456789\r\n"}))
    assert level.identify() == "DPL2 V1.8.0 123456789, values in deg"


def test_one_that_goes_on_streaming_is_no_answer() -> None:
    codec = AngleCodec(load_angle_dialect("meas-dpg"))

    class Deaf(AngleMeterTwin):
        def receive(self, data: bytes, now_s: float) -> None:
            """It hears nothing."""

    level = meter("meas-dpg", Deaf(codec, "deg", lambda _axis, _value, _now: 1.0))
    with pytest.raises(DeviceNonsense, match="does not fall quiet"):
        level.prepare()


@pytest.mark.parametrize("dialect", ["meas-dpg", "bei-ags"])
@pytest.mark.parametrize("into_the_burst", [0, 3])
def test_one_that_loses_power_streams_again_and_is_told(dialect: str, into_the_burst: int) -> None:
    """DPG p. 11: `s` holds until power-on. As seen: 7.654° of the stream was read as an answer, without a word."""
    twin = AngleMeterTwin(AngleCodec(load_angle_dialect(dialect)), "deg", lambda _axis, _value, _now: 1.0)
    level = meter(dialect, twin)
    clock = level._clock
    level.prepare()
    assert reads(level, samples=3) == [1.0] * 3
    left = into_the_burst

    def wait(duration_s: float) -> None:
        nonlocal left
        clock.sleep(duration_s)
        if left == 0:
            twin.power_cycle(clock.monotonic_s())
            clock.sleep(0.5)
        left -= 1

    with pytest.raises(DeviceFault, match=r"level: it streams again, though it was told to be quiet.*it lost power"):
        level.read("level.x", 6, wait)
    assert level.read("level.x", 6, clock.sleep).samples.tolist() == [1.0] * 6  # whoever heard of it may go on


def test_the_lds1000_s_unit_is_asked_for() -> None:
    """EDH0170 p. 37: "1TP-1596.3"; p. 48: the unit is a setting, and TA tells it."""
    text = b"1TA,RT,04512,1,\xb5rad,00102,00241\r\n"
    level = meter("newport-lds1000", Scripted({b"1TP\r\n": b"1TP-1596.3\r\n", b"1TA\r\n": text}))
    assert reads(level) == pytest.approx([-0.0914613], abs=1e-7)


@pytest.mark.parametrize("word", [b"nm", b"mm", b"unit"])
def test_a_unit_that_is_no_angle_is_refused(word: bytes) -> None:
    answers = {b"1TP\r\n": b"1TP-1596.3\r\n", b"1TA\r\n": b"1TA,RT,04512,0,1," + word + b",00102,00241\r\n"}
    with pytest.raises(DeviceNonsense, match=f"its unit is '{word.decode()}', which is none of angles"):
        reads(meter("newport-lds1000", Scripted(answers)))


@pytest.mark.parametrize("reply", [b"4 001 12.3 4.5\r", b"2 103 12.3 4.5\r", b"4 003 12.3\r"])
def test_only_the_good_codes_of_an_elcomat_are_angles(reply: bytes) -> None:
    level = meter("elcomat", Scripted({b"a\r\n": reply}), values="arcsec")
    with pytest.raises(DeviceNonsense):
        reads(level)
    good = meter("elcomat", Scripted({b"a\r\n": b"4 003 36.0 4.5\r"}), values="arcsec")
    assert reads(good) == pytest.approx([0.01])


@pytest.mark.parametrize(
    ("unit", "value"),
    [
        ("deg", 1.0),
        ("arcmin", 60.0),
        ("arcsec", 3600.0),
        ("rad", 0.017453293),
        ("mrad", 17.453293),
        ("urad", 17453.293),
        ("mm_per_m", 17.455065),
    ],
)
def test_a_degree_in_every_unit(unit: str, value: float) -> None:
    """Millimetres a metre are a slope: tan 1° = 0.017455065."""
    assert to_deg(value, unit) == pytest.approx(1.0, rel=1e-7)  # type: ignore[arg-type]


def test_a_unit_other_than_the_file_s_is_refused_and_one_that_changes_too() -> None:
    codec = AngleCodec(load_angle_dialect("newport-lds1000"))
    twin = AngleMeterTwin(codec, "mrad", lambda _axis, _value, _now: 0.01)
    with pytest.raises(DeviceRefused, match=r"level: its unit is mrad, need arcsec \(readouts.level: values\)"):
        meter("newport-lds1000", twin, values="arcsec").prepare()
    level = meter("newport-lds1000", twin)

    def turned_by_hand(_duration_s: float) -> None:
        twin.unit = "urad"

    with pytest.raises(DeviceFault, match="its unit was mrad before the burst and is urad behind it"):
        level.read("level.x", 3, turned_by_hand)


def test_beyond_its_range_there_is_no_angle() -> None:
    answers = {b"s": b"s", b"R": b"X=+31.000\r\nY=-00.007\r\n"}
    channels = {"x": {"about": "pitch", "range_deg": 30.0, "sign": -1, "zero_deg": 1.0}}
    burst = meter("meas-dpg", Scripted(answers), channels=channels).read("level.x", 2, virtual_clock().sleep)
    assert burst.overload.all()
    level = meter("meas-dpg", Scripted({**answers, b"R": b"X=+21.000\r\nY=-00.007\r\n"}), channels=channels)
    assert reads(level) == [-20.0]


def test_silence_and_half_an_answer_are_no_angle() -> None:
    with pytest.raises(DeviceSilent):
        reads(meter("meas-dpg", Scripted({b"s": b"s", b"R": b"X=+01.234\r\nY=-0"})))
    with pytest.raises(DeviceSilent):
        reads(meter("bei-ags", Scripted({b"f": b"f"})))  # p. 10: "In case of errors no angle values will be provided"


@pytest.mark.parametrize("dialect", sorted(angle_dialects()))
def test_every_dialect_tells_the_attitude_of_the_twin_s_table(dialect: str, tmp_path: Path) -> None:
    channels = '{ pitch = { about = "pitch" } }' if dialect == "newport-lds1000" else None
    path = angle_meter_rig_file(tmp_path, dialect, 'values = "arcsec"' if dialect == "elcomat" else "")
    if channels:
        text = path.read_text().replace(', roll = { about = "roll", value = "y" } }', " }")
        path.write_text(text)
    with open_rig(read_rig(path)) as rig:
        _turn(rig, "pitch", 12.0)
        rig.readouts["level"].prepare()
        said = rig.readouts["level"].read("level.pitch", 20, rig.clock.sleep)
    assert said.samples.mean() == pytest.approx(12.0, abs=0.003)
    assert 0.0005 < said.samples.std() < 0.005


def _turn(rig: Rig, axis: str, target_deg: float) -> None:
    home_and_arrive(rig.axes[axis], rig.clock, rig.clock.sleep)
    move_and_arrive(rig.axes[axis], target_deg, rig.clock, rig.clock.sleep)


@pytest.mark.parametrize("dialect", ["meas-dpg", "jewell-tuff-tilt"])
def test_no_damage_to_its_line_makes_a_wrong_angle(dialect: str, tmp_path: Path) -> None:
    path = angle_meter_rig_file(tmp_path, dialect)
    survive_damage(path, "readouts.level", lambda rig: float(_one(rig)), 0.02)


def _one(rig: Rig) -> float:
    return float(rig.readouts["level"].read("level.pitch", 1, rig.clock.sleep).samples[0])


@pytest.mark.parametrize(
    ("dialect", "more", "sentence"),
    [
        ("elcomat", "", r"level.toml:\d+: readouts.level.values: a device of the dialect elcomat cannot be asked"),
        ("meas-dpg", 'values = "mrad"', r"readouts.level.values: got mrad, but the dialect meas-dpg has deg alone"),
        ("newport-lds1000", "", r"readouts.level.channels.roll.value: got y, the dialect newport-lds1000 reads x"),
        ("nowhere.toml", "", r"readouts.level.dialect: .*nowhere.toml"),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused(dialect: str, more: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        read_rig(angle_meter_rig_file(tmp_path, dialect, more))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('reply = "{x:g}{y:g}"', r"own.toml:\d+: reading: .* does not read back"),
        ('reply = "{x}"', "a number needs a format"),
        ('reply = "{x:g} {unit}"', r"\{unit\} in a reply and the table \[units\]"),
        ('reply = "nothing"', r"there is no \{x:...\} or \{y:...\}"),
        ('reply = "{target_deg:.3f}"', r"field \{target_deg\} has no meaning here"),
    ],
)
def test_a_dialect_that_cannot_be_read_back_is_refused(text: str, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(
        f'name = "own"\nterminator = "\\r"\nreply_terminator = "\\r"\nreading = {{ command = "A", {text} }}\n'
    )
    with pytest.raises(DescriptionError, match=sentence):
        load_angle_dialect(str(path))


def test_an_attitude_reference_must_tell_its_own_axis_in_degrees(tmp_path: Path) -> None:
    path = angle_meter_rig_file(tmp_path)
    for channel, sentence in (
        ("level.roll", "level.roll tells roll .its key about., not pitch"),
        ("dmm.x", r"no channel 'dmm.x' in degrees \(allowed: level.pitch, level.roll\)"),
    ):
        text = path.read_text()
        table = f'[attitude_reference]\nchannels = {{ pitch = "{channel}" }}\nuncertainty_deg = 0.001\n'
        other = tmp_path / "other.toml"
        other.write_text(text + table)
        with pytest.raises(DescriptionError, match=sentence):
            read_rig(other)
    (tmp_path / "sensor.toml").write_text(path.read_text().replace('x = "dmm.x"', 'x = "level.pitch"'))
    with pytest.raises(DescriptionError, match=r"no channel 'level\.pitch'"):
        read_rig(tmp_path / "sensor.toml")
    with pytest.raises(RequestRefused, match="none such"):
        meter("meas-dpg", Scripted({})).read("level.none such", 1, virtual_clock().sleep)
