"""A number that a dialect would write as another one is refused before any byte of it is sent.

What is sent is parsed by the other side's reader, so a place that nobody asked for would show itself here.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from table_bench import example_rig, virtual_clock

from rig.description.read import read_rig
from rig.devices import indexing_table, rate_table
from rig.devices.indexing_table import DialectSettings, IndexingTableAxis, IndexingTableSettings
from rig.devices.rate_table import RateTableAxis, RateTableSettings
from rig.errors import DescriptionError, RequestRefused
from rig.link.memory import MemoryStream
from rig.twins.physics.world import World
from rig.twins.rate_table import RateTableTwin
from rig.wire.indexing_table import Move, TableCodec
from rig.wire.table_dialect import load_dialect, published_dialects, rate_dialects

IDEAL, YAESU, INFICON = "ideal-aerosmith-1270vs", "yaesu-gs-232", "inficon-srt-422"
RIG = """[rig]
name = "bench"
gravity_mps2 = 9.80665
[axes.yaw]
driver = "rate-table"
port = "socket://127.0.0.1:1"
dialect = "ideal-aerosmith-1270vs"
limits_deg = [-180.0, 180.0]
speed_dps = {speed}
top_rate_dps = 100.0
homed_before = true
[readouts.dmm]
driver = "scpi-meter"
model = "34401A"
resource = "socket://127.0.0.1:7"
channels = {{ x = {{ range_v = 10.0 }} }}
[sensors.S1]
model = "single-axis package"
channels = {{ x = "dmm.x" }}
nominal_sensitivity_v_per_g = 2.5
"""


@dataclass
class Overheard:
    """A machine in a dialect, and every command it was sent."""

    axis: IndexingTableAxis | RateTableAxis
    sent: list[bytes] = field(default_factory=list)


def _machine(dialect: str, increment_deg: float, speed_dps: float = 20.0) -> tuple[Overheard, TableCodec]:
    table: dict[str, object] = {"port": "twin", "limits_deg": (-180.0, 540.0), "increment_deg": increment_deg}
    table |= {"speed_dps": speed_dps, "dialect": dialect, "homed_before": True}
    settings: DialectSettings
    connect: Callable[..., dict[str, IndexingTableAxis] | dict[str, RateTableAxis]]
    if dialect in rate_dialects():
        settings, connect = RateTableSettings.model_validate(table | {"driver": "rate-table"}), rate_table.connect
    else:
        table |= {"driver": "indexing-table"}
        settings, connect = IndexingTableSettings.model_validate(table), indexing_table.connect
    codec = TableCodec(settings.spoken())
    twin = RateTableTwin(codec, {1: "pitch"}, World(example_rig().model_copy(update={"axes": {"pitch": settings}})))
    overheard = Overheard(connect({"pitch": settings}, MemoryStream(twin, virtual_clock(), dialect))["pitch"])
    receive = twin.receive
    twin.receive = lambda data, now_s: (overheard.sent.append(data), receive(data, now_s))[1]  # type: ignore[method-assign]
    return overheard, codec


@pytest.mark.parametrize(
    ("dialect", "increment_deg", "target_deg", "sentence"),
    [
        (IDEAL, 0.5, 12.5, r"would write 'MOV12' by 'MOV\{target_deg:.0f\}', which is 12°"),
        (YAESU, 1.0, -10.0, r"would write 'W-10 000', and its machine takes 0 to 450°"),  # section 6: range to 450°
        (YAESU, 1.0, 451.0, r"would write 'W451 000', and its machine takes 0 to 450°"),
        (INFICON, 0.18, -10.08, r"would write '\$H-56', and its machine takes 0 to 359.82°"),  # p. 56: 0 to 1999
        (INFICON, 0.18, 360.0, r"would write '\$H2000', and its machine takes 0 to 359.82°"),
        (INFICON, 1.0, 10.0, r"would write '\$H56' by '\$H\{target_counts:d\}', which is 10.08°"),
    ],
)
def test_a_target_that_cannot_be_written_is_refused_and_no_move_is_sent(
    dialect: str, increment_deg: float, target_deg: float, sentence: str
) -> None:
    machine, _ = _machine(dialect, increment_deg)
    for request in (machine.axis.check_target, machine.axis.start_move):
        with pytest.raises(RequestRefused, match=f"{sentence}.*nothing moved"):
            request(target_deg)
    assert not any(line.startswith((b"MOV", b"W", b"$H")) for line in machine.sent)


@pytest.mark.parametrize("dialect", [*published_dialects(), *rate_dialects()])
def test_every_target_that_is_not_refused_is_read_by_the_other_side_as_it_was_asked_for(dialect: str) -> None:
    coarse_deg = load_dialect(dialect, 1.0).increment_deg
    taken = 0
    for increment_deg in (coarse_deg, coarse_deg / 4.0):
        machine, codec = _machine(dialect, increment_deg)
        for part in range(-60, 181):
            target_deg = round(3.0 * part / increment_deg) * increment_deg
            try:
                machine.axis.check_target(target_deg)
            except RequestRefused:
                continue
            read = codec.decode_command(codec.encode_command(Move(1, target_deg)).removesuffix(codec.terminator))
            assert isinstance(read, Move)
            assert read.target_deg == pytest.approx(target_deg, abs=1e-4)
            taken += 1
    assert taken >= 120  # from 0 to 360°, every third degree


@pytest.mark.parametrize(("speed", "line", "value"), [("0.4", "VEL0", "0"), ("20.6", "VEL21", "21")])
def test_a_speed_that_would_be_rounded_is_refused_with_the_file_and_before_it_is_sent(
    tmp_path: Path, speed: str, line: str, value: str
) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(RIG.format(speed=speed), encoding="utf-8")
    sentence = rf"would write '{line}' by 'VEL\{{speed_dps:.0f\}}', which is {value} °/s"
    with pytest.raises(DescriptionError, match=rf"rig\.toml:9: axes\.yaw\.speed_dps: got {speed} °/s: .*{sentence}"):
        read_rig(path)
    machine, _ = _machine(IDEAL, 1.0, float(speed))
    with pytest.raises(RequestRefused, match=sentence):
        machine.axis.start_move(10.0)
    assert not any(data.startswith((b"VEL", b"MOV")) for data in machine.sent)
    path.write_text(RIG.format(speed="20.0"), encoding="utf-8")
    settings = read_rig(path).axes["yaw"]
    settings.refuse_rate("yaw", 12.0)
    with pytest.raises(RequestRefused, match="would write 'JOG12'"):
        settings.refuse_rate("yaw", 12.5)


def test_a_range_of_targets_the_wrong_way_round_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    shipped = Path(rate_table.__file__).parents[1] / "dialects" / "published" / "yaesu-gs-232.toml"
    path.write_text(shipped.read_text(encoding="utf-8").replace("[0.0, 450.0]", "[450.0, 0.0]"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"targets_deg must be \[low, high\] with low < high"):
        load_dialect(str(path), 1.0)
