"""Every reader of bytes that come from outside, fed with what nobody would write: it answers or refuses with a sentence
of ours, in bounded time and memory. A finding names its seed."""

import json
import resource
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from device_sets import RIGS, device_set
from example_files import EXAMPLE_RIG
from job_files import SMALL
from journals import journal_with
from mutations import mutated
from solved_sets import tp_set

from ams.errors import AmsError
from ams.exports.formats import FORMATS, load_set
from ams.inputs.observations_csv import read_csv
from procedures.alerts.settings import read_alerts
from procedures.errors import ProcedureError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Spool
from procedures.journal.salvage import salvage
from procedures.journal.storage import JOURNAL_FILE, CommittedCount
from procedures.kinds.read import read_procedure
from rig.clock import SystemClock
from rig.description.fault_plan import read_faults
from rig.description.read import read_rig
from rig.errors import RigError
from rig.link.transcript import read_transcript
from rig.wire import esp301, hp3458a, hp3488a, maestro, manual, prologix, scpi, vn100, zaber
from rig.wire.csv_rows import RowShape, parse_rows
from rig.wire.indexing_table import AskPosition, AskState, Home, Identify, Move, TableCodec
from rig.wire.table_dialect import load_dialect

pytestmark = pytest.mark.timeout(600)
DEFAULT_ROUNDS, THOROUGH_ROUNDS = 80, 300
SOAK_S = 600.0
SLOWEST_S = 5.0
MOST_GROWTH_MB = 400.0
OURS = (AmsError, ProcedureError, RigError)
FAULTS = b"""
seed = 3
[fault.late]
line = "axes.pitch"
kind = "delay"
delay_s = 2.0
nth = [3, 70]
[fault.noise]
line = "*"
kind = "flip-bit"
probability = 0.01
"""
ALERTS = b"""
command = ["/bin/ring", "laboratory"]
urls = ["ntfy://ntfy.example/rig"]
every_h = 4.0
heartbeat = "https://hc.example/ping/x"
heartbeat_every_s = 60.0
"""
OBSERVATIONS = b"replication,point,pitch_deg,roll_deg,temperature_degc,sx_v\n" + b"".join(
    b"%d,%d,%d.0,%d.0,20.01,%0.6f\n" % (n, p, 10 * p, 30 * p, 0.1 * p) for n in (1, 2) for p in range(6)
)
TRANSCRIPT = (
    b'{"transcript": 1}\n{"at_s": 0.0, "operation": "write", "data": "1 POS?\\r\\n"}\n'
    b'{"at_s": 0.1, "operation": "read", "data": "1 POS +010.0000\\r\\n"}\n'
)
REQUEST = b'{"kind": "pause", "by": "bert", "at_utc": "2026-03-01T13:00:00+00:00", "text": ""}'
LINES = [
    b"1 POS +010.0000", b"1 STAT IDLE SEATED LOCKED HOMED", b"1 OK", b"1 ERR LIMIT", b"+1.234567890E+00", b"-9.9E+37",
    b"HEWLETT-PACKARD,34970A,0,13-2-2", b'-113,"Undefined header"', b"1.0E+00,101,2.0E+00,102", b"@01 0 OK IDLE -- 0",
    b"@01 0 OK BUSY WR 123456", b"0, 4711, NO ERROR DETECTED", b"ESP301 Version 3.0.1", b"Prologix GPIB-ETHERNET 01.06",
    b"$VNRRG,01,VN-100T-CR*0A", b"$VNIMU,+00.1,-00.2,+00.3,+00.01,-09.8,+00.0,+1.0,+2.0,-3.0,+20.1,+101.3*6B",
    b"17,0,1333,0,512", b"#210abcdefghij", b"(@101:103)", b"TYPE 44470", b"done", b"+10.5", b"", b"\0\1\2\3",
]  # fmt: skip


@dataclass(frozen=True)
class Reader:
    """What reads, and what it is first given whole. A parser of one line is given its bytes, any other a path."""

    corpus: list[bytes]
    read: Callable[[Path], object] | None = None
    parse: Callable[[bytes], object] | None = None
    name: str = "file"


def _wire(line: bytes) -> None:
    """Every parser of a reply: what it does not understand is None or DeviceNonsense."""
    codec = TableCodec(load_dialect(None, 1.0))
    for command in (AskPosition(1), AskState(1), Move(1, 10.0), Home(1), Identify()):
        codec.decode_reply(line, command)
    codec.decode_command(line)
    for decode in (esp301.decode_number, esp301.decode_flag, esp301.decode_error, esp301.decode_version):
        decode(line)
    esp301.decode_commands(line)
    zaber.decode_reply(line)
    zaber.decode_command(line)
    prologix.split_host_lines(line)
    maestro.decode_word((line + b"\0\0")[:2])
    text = line.decode("latin-1")
    manual.decode(text)
    manual.decode_angle(text)
    parse_rows(line, RowShape(5))
    for parse in PARSERS:
        try:
            parse(line)
        except RigError:
            continue


PARSERS: tuple[Callable[[bytes], object], ...] = (
    hp3458a.parse_number,
    hp3458a.parse_pair,
    hp3458a.parse_reading,
    hp3458a.parse_identity,
    hp3458a.parse_error,
    hp3488a.parse_identity,
    hp3488a.parse_view,
    hp3488a.parse_card_type,
    hp3488a.parse_errors,
    prologix.parse_number,
    prologix.parse_status_byte,
    prologix.parse_version,
    scpi.parse_block,
    scpi.parse_scan_list,
    scpi.parse_number,
    scpi.parse_whole,
    scpi.parse_readings,
    scpi.parse_named_readings,
    scpi.parse_error,
    scpi.parse_identity,
    vn100.parse_message,
)


def _read_journal(path: Path) -> None:
    try:
        with JournalReader.open(path) as reader:
            reader.verify()
            list(reader.dwells())
    finally:
        salvage(path, path.parent / "saved")


def _read_count(path: Path) -> None:
    CommittedCount(path.with_name(JOURNAL_FILE)).read()


def _take(path: Path) -> None:
    spool = Spool(path.parent)
    spool.folder.mkdir(exist_ok=True)
    path.rename(spool.folder / "1.json")
    for taken in spool.take():
        json.dumps(taken.detail())


@pytest.fixture(scope="module")
def readers(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Reader]:
    folder = tmp_path_factory.mktemp("corpus")
    rigs = [EXAMPLE_RIG.read_bytes()]
    for name in RIGS:
        device_set(name, folder)
        rigs.append((folder / "rig.toml").read_bytes())
    lines = {"axes.pitch": "indexing-table", "readouts.dmm": "hp3458a"}
    coefficients = tp_set()
    return {
        "wire": Reader(LINES, parse=_wire),
        "rig.toml": Reader(rigs, read_rig, name="rig.toml"),
        "procedure.toml": Reader([SMALL.encode()], read_procedure, name="procedure.toml"),
        "faults.toml": Reader([FAULTS], lambda path: read_faults(path, lines), name="faults.toml"),
        "alerts.toml": Reader([ALERTS], read_alerts, name="alerts.toml"),
        "transcript": Reader([TRANSCRIPT], read_transcript, name="axes.pitch.jsonl"),
        "observations.csv": Reader([OBSERVATIONS], lambda path: read_csv(path, {"x": "sx_v"}), name="obs.csv"),
        "journal": Reader([journal_with(folder / JOURNAL_FILE, 8).read_bytes()], _read_journal, name=JOURNAL_FILE),
        "count": Reader([b'{"run": "r", "events": 11, "dwells": 5}'.ljust(128)], _read_count, name="journal.count"),
        "request": Reader([REQUEST], _take, name="1.json"),
        **{
            f"set as {kind}": Reader([form.to_bytes(coefficients)], load_set, name=form.file_name("SN1"))
            for kind, form in FORMATS.items()
        },
    }


NAMES = (
    "wire", "rig.toml", "procedure.toml", "faults.toml", "alerts.toml", "transcript", "observations.csv", "journal",
    "count", "request", *(f"set as {kind}" for kind in FORMATS),
)  # fmt: skip


def _rounds(reader: Reader, seeds: Iterator[int], folder: Path) -> None:
    clock, before_mb = SystemClock(), _peak_mb()
    for seed in seeds:
        chance = np.random.default_rng(seed)
        data = mutated(reader.corpus[int(chance.integers(len(reader.corpus)))], chance, reader.corpus)
        began_s = clock.monotonic_s()
        try:
            _feed(reader, data, folder)
        except OURS:
            pass  # refused, with a sentence
        except Exception as error:
            error.add_note(f"seed {seed}: {data[:2000]!r}")
            raise
        assert clock.monotonic_s() - began_s < SLOWEST_S, f"seed {seed} takes too long"
    assert _peak_mb() - before_mb < MOST_GROWTH_MB


def _feed(reader: Reader, data: bytes, folder: Path) -> None:
    if reader.parse is not None:
        reader.parse(data)
        return
    assert reader.read is not None
    with TemporaryDirectory(dir=folder) as inner:
        path = Path(inner) / reader.name
        path.write_bytes(data)
        reader.read(path)


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


@pytest.mark.parametrize(
    "seeds",
    [
        range(DEFAULT_ROUNDS),
        pytest.param(range(DEFAULT_ROUNDS, THOROUGH_ROUNDS), marks=pytest.mark.thorough),
    ],
    ids=["first", "more"],
)
@pytest.mark.parametrize("name", NAMES)
def test_fault_58_69_what_nobody_would_write_is_refused_with_a_sentence(
    readers: Mapping[str, Reader], name: str, seeds: range, tmp_path: Path
) -> None:
    many = 4 if name == "wire" else 1
    _rounds(readers[name], iter(range(many * seeds.start, many * seeds.stop)), tmp_path)


@pytest.mark.soak
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", NAMES)
def test_fault_58_69_ten_minutes_of_what_nobody_would_write_are_refused(
    readers: Mapping[str, Reader], name: str, tmp_path: Path
) -> None:
    """Ten minutes over all readers."""
    clock = SystemClock()
    until_s = clock.monotonic_s() + SOAK_S / len(NAMES)

    def seeds() -> Iterator[int]:
        seed = 1_000_000
        while clock.monotonic_s() < until_s:
            yield (seed := seed + 1)

    _rounds(readers[name], seeds(), tmp_path)


def test_the_names_above_are_all_readers(readers: Mapping[str, Reader]) -> None:
    assert set(NAMES) == readers.keys()
