"""Every decoder and encoder of ``rig.wire`` with a frame from outside: a manual, a capture, a rule worked by hand."""

import inspect
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import rig.wire
from rig.errors import DeviceNonsense
from rig.wire import (
    chamber_text,
    csv_rows,
    esp301,
    hp3458a,
    hp3488a,
    manual,
    oriental_az,
    pi_gcs,
    prologix,
    scpi,
    vn100,
    zaber,
)
from rig.wire import maestro as servo
from rig.wire.angle_dialect import load_angle_dialect
from rig.wire.angle_lines import AngleCodec, Question, Reading
from rig.wire.esp301 import ErrorRecord
from rig.wire.indexing_table import AskPosition, AskState, Identify, Identity, Move, Position, TableCodec, TableState
from rig.wire.maestro_reader import MaestroReader
from rig.wire.oriental_az import Operation
from rig.wire.table_dialect import load_dialect
from rig.wire.zaber import Command, Reply

NUMERALS = b" +-.0123456789Ee,"
"""Rubbish of these alone may make another number of a number: only terminators and lengths protect those."""
TEXT = bytes(range(32, 127))
"""Where an answer is free text, printable rubbish is text, too."""
ANY = bytes(range(256))
"""What a device is told: the twin obeys what is well-formed, and nothing in it tells rubbish."""
TABLE = TableCodec(load_dialect(None, 1.0))
YMR = (
    b"$VNYMR,+100.949,-007.330,+000.715,-00.0049,-00.2449,+00.5397,-01.258,-00.100,-09.701,"
    b"-00.000018,+00.001122,-00.000551*69\r\n"
)
YMR_VALUES = [100.949, -7.33, 0.715, -0.0049, -0.2449, 0.5397, -1.258, -0.1, -9.701, -0.000018, 0.001122, -0.000551]
CHAMBERS = "the chamber maker's public library, one decimal; docs/devices/ascii-chambers.md"
PI = "traffic of the maker's own client, C-863 manual MS249E; docs/devices/pi-gcs.md"
ANGLES = "Tuff Tilt B-06-1006 p. 15, DPG-Series July 2015 p. 11, EDH0170 p. 48; docs/devices/attitude-references.md"
TUFF_TILT, DPG, LDS = (
    AngleCodec(load_angle_dialect(name)) for name in ("jewell-tuff-tilt", "meas-dpg", "newport-lds1000")
)
TUFF_LINE = b"$YXXDR,A,-00.920,D,N,A,-00.210,D,E,C,030.045,C,T-N1212*57"
AZ = "00000000 00000002 00001388 000003E8 000003E8 000003E8 000003E8 00000001"


@dataclass(frozen=True)
class Decoded:
    """``frame`` is one whole answer as the decoder is given it."""

    name: str
    """``module.function``."""
    decode: Callable[[bytes], Any]
    frame: bytes
    value: Any
    source: str
    blind: bytes = b""
    """Bytes of which added rubbish may make another well-formed answer."""


@dataclass(frozen=True)
class Encoded:
    name: str
    made: bytes
    literal: bytes
    source: str


def _text(decode: Callable[[str], Any]) -> Callable[[bytes], Any]:
    return lambda line: decode(line.decode("latin-1"))


def _rows(line: bytes) -> list[list[float]] | None:
    rows = csv_rows.parse_rows(line, csv_rows.RowShape(2, prefix=b"$A,", checksum="xor")).values.tolist()
    return rows or None


def _streamed(line: bytes) -> list[list[float]] | None:
    return vn100.parse_rows(line, "YMR", vn100.row_pattern("YMR")).values.tolist() or None


def _az(data: bytes) -> Operation:
    registers = [int.from_bytes(data[index : index + 2], "big") for index in range(0, len(data) - 1, 2)]
    if len(data) != 32:
        raise DeviceNonsense("sixteen registers")
    return oriental_az.decode(registers)


def _only_error(line: bytes) -> str | None:
    return vn100.parse_error(vn100.parse_message(line))


def _chained(line: bytes) -> list[tuple[str, str]]:
    return list(scpi.split_message(line.decode("latin-1")))


def _with_checksum(decode: Callable[[bytes], Any]) -> Callable[[bytes], Any]:
    """As both sides ask for it by default."""
    return lambda line: found if (found := decode(line)) is not None and found.has_checksum else None


def _host(line: bytes) -> Any:
    lines, rest = prologix.split_host_lines(line)
    return None if rest or len(lines) != 1 else lines[0]


def _heard(packet: bytes) -> Any:
    heard = MaestroReader().take(packet)
    return heard[0] if len(heard) == 1 and isinstance(heard[0], servo.Request) else None


ESP = "ESP300 user's manual, TB and TE"
METER = "3458A user's guide"
SCANNER = "gpib-utils, src/hp3488.c"
DAQ = "34970A user's guide"
ZABER = "zaber-motion 10.2.0 on the wire"
VN = "VN-100 user manual UM001 and a line of a real unit"
MAESTRO = "Pololu Maestro user's guide, pages 52 to 58"
OPERATOR = "our own: a person reads it"
TABLES = "our own dialect of the twin's table"

DECODED = (
    Decoded("esp301.decode_number", esp301.decode_number, b"12.345", 12.345, "ESP300 manual, TP", NUMERALS),
    Decoded("esp301.decode_flag", esp301.decode_flag, b"1", True, "ESP300 manual, MD", b" "),
    Decoded("esp301.decode_error", esp301.decode_error, b"0, 451322, NO ERROR DETECTED",
            ErrorRecord(0, 451322, "NO ERROR DETECTED"), ESP, TEXT),
    Decoded("esp301.decode_version", esp301.decode_version, b"ESP300 Version 3.01", "ESP300 Version 3.01",
            "ESP300 manual, VE", TEXT),
    Decoded("esp301.decode_commands", esp301.decode_commands, b"1PA12.345",
            [esp301.Command("PA", 1, "12.345")], "ESP300 manual, PA", ANY),
    Decoded("hp3458a.parse_number", hp3458a.parse_number, b" 1.000000120E+00", 1.00000012, METER, NUMERALS),
    Decoded("hp3458a.parse_reading", hp3458a.parse_reading, b"-1.234567890E-03", (-1.23456789e-3, 16), METER,
            NUMERALS),
    Decoded("hp3458a.parse_pair", hp3458a.parse_pair, b"1,10", (1.0, 10.0), METER, NUMERALS),
    Decoded("hp3458a.parse_terminals", hp3458a.parse_terminals, b"2", "rear",
            source="Keithley 2002 user's manual, page H-21, TERM? for HP3458A compatibility: 1= Front; 2=Rear",
            blind=NUMERALS),
    Decoded("hp3458a.parse_operations", hp3458a.parse_operations, b"7,11", 7.0,
            f"{METER}, MATH; two numbers assumed", NUMERALS),
    Decoded("hp3458a.parse_identity", hp3458a.parse_identity, b"HP3458A", "HP3458A", METER),
    Decoded("hp3458a.parse_error", hp3458a.parse_error, b'102,"TRIGGER TOO FAST"', (102, "TRIGGER TOO FAST"), METER,
            b" 0123456789"),
    Decoded("hp3488a.parse_identity", hp3488a.parse_identity, b"HP3488A", "HP3488A", SCANNER),
    Decoded("hp3488a.parse_view", hp3488a.parse_view, b"OPEN   1", False, SCANNER, b" "),
    Decoded("hp3488a.parse_card_type", hp3488a.parse_card_type, b"RELAY MUX  44470", "44470", SCANNER, TEXT),
    Decoded("hp3488a.parse_errors", hp3488a.parse_errors, b"3", ("syntax", "execution"), SCANNER, b" +-0123456789"),
    Decoded("indexing_table.TableCodec.decode_reply", lambda line: TABLE.decode_reply(line, AskPosition(1)),
            b"1 POS +010.0000", Position(10.0), TABLES),
    Decoded("indexing_table.TableCodec.decode_reply", lambda line: TABLE.decode_reply(line, AskState(1)),
            b"1 STAT IDLE SEATED LOCKED HOMED", TableState(False, True, True), TABLES, b" "),
    Decoded("indexing_table.TableCodec.decode_command", TABLE.decode_command, b"1 MOVE +010.0000", Move(1, 10.0),
            TABLES, b"0123456789"),
    Decoded("maestro.decode_word", servo.decode_word, bytes.fromhex("70 17"), 6000, MAESTRO, ANY),
    Decoded("maestro.decode_aim", servo.decode_aim, bytes.fromhex("01 70 17 01 70 17 01"), (6000, 6000), MAESTRO, ANY),
    Decoded("maestro_reader.MaestroReader.take", _heard, bytes.fromhex("84 00 70 2E"), servo.set_target(0, 6000),
            MAESTRO, ANY),
    Decoded("manual.decode", _text(manual.decode), b"pitch: stop; leave the axis as it is", manual.LeaveIt("pitch"),
            OPERATOR, bytes(set(range(256)) - {10, 58})),
    Decoded("manual.decode_angle", _text(manual.decode_angle), b"-29.98", -29.98, OPERATOR, NUMERALS),
    Decoded("oriental_az.decode", _az, bytes.fromhex(AZ), Operation(oriental_az.INCREMENTAL, 5000, 1000, 1000, 1000),
            "HM-60262E, worked from the maker's sample"),
    Decoded("prologix.parse_number", prologix.parse_number, b"22", 22, "Prologix manual 6.107, addr", b"0123456789"),
    Decoded("prologix.parse_real_version", prologix.parse_real_version,
            b"AR488 GPIB controller, ver. 0.53.04, 13/04/2025", "AR488 GPIB controller, ver. 0.53.04, 13/04/2025",
            "AR488 manual 0.53.03, page 86", ANY),
    Decoded("prologix.parse_status_byte", prologix.parse_status_byte, b"144", 144, "Prologix manual, spoll",
            b"0123456789"),
    Decoded("prologix.parse_version", prologix.parse_version, b"Prologix GPIB-USB Controller version 6.107",
            "Prologix GPIB-USB Controller version 6.107", "Prologix manual, ver", TEXT),
    Decoded("prologix.split_host_lines", _host, bytes.fromhex("00 01 02 1B 0D 03 1B 0A 04 1B 1B 05 1B 2B 06 0A"),
            prologix.HostLine(False, bytes.fromhex("00 01 02 0D 03 0A 04 1B 05 2B 06")), "Prologix manual, page 7",
            ANY),
    Decoded(
        "angle_lines.AngleCodec.parse_reading",
        lambda line: TUFF_TILT.parse_reading(line, 1),
        TUFF_LINE,
        Reading({"x": -0.21, "y": -0.92}, "deg"),
        ANGLES,
    ),
    Decoded(
        "angle_lines.AngleCodec.parse_unit",
        lambda line: LDS.parse_unit(line, 1),
        b"1TA,RT,04512,1,\xb5rad,00102,00241",
        "urad",
        ANGLES,
        ANY,
    ),
    Decoded(
        "angle_lines.AngleCodec.parse_identity",
        DPG.parse_identity,
        b"DPL2 V1.8.0\r\nSN:123456789",
        "DPL2 V1.8.0 123456789",
        ANGLES,
        ANY,
    ),
    Decoded("chamber_text.parse_temperature", chamber_text.parse_temperature, b"25.3", 25.3, CHAMBERS, NUMERALS),
    Decoded("chamber_text.parse_text", chamber_text.parse_text, b"T,T,P300,180.0", "T,T,P300,180.0", CHAMBERS, TEXT),
    Decoded(
        "chamber_text.parse_stop_reason",
        chamber_text.parse_stop_reason,
        b"7",
        " (process alarm, SCOD 7)",
        CHAMBERS,
        ANY,
    ),
    Decoded("chamber_text.parse_is_fahrenheit", chamber_text.parse_is_fahrenheit, b"F", True, CHAMBERS, ANY),
    Decoded("pi_gcs.parse_value", lambda line: pi_gcs.parse_value(line, "1"), b"1=12.500000", "12.500000", PI, TEXT),
    Decoded("pi_gcs.parse_number", lambda line: pi_gcs.parse_number(line, "1"), b"1=12.500000", 12.5, PI,
            NUMERALS + b" "),
    Decoded("pi_gcs.parse_flag", lambda line: pi_gcs.parse_flag(line, "1"), b"1=1", True, PI, b" "),
    Decoded("pi_gcs.parse_unit", lambda line: pi_gcs.parse_unit(line, "1"), b"1 0x7000601=DEG", "DEG", PI, TEXT),
    Decoded("pi_gcs.parse_error", pi_gcs.parse_error, b"10", 10, PI, b"-0123456789"),
    Decoded("pi_gcs.parse_moving", pi_gcs.parse_moving, b"3", 3, PI, b"0123456789abcdefABCDEF"),
    Decoded("pi_gcs.parse_identity", pi_gcs.parse_identity,
            b"(c)2013 Physik Instrumente(PI) Karlsruhe, C-863.11,0115500620,1.2.1.0",
            "(c)2013 Physik Instrumente(PI) Karlsruhe, C-863.11,0115500620,1.2.1.0", PI, TEXT),
    Decoded("scpi.parse_number", scpi.parse_number, b"+2.61920000E+01", 26.192, DAQ, NUMERALS),
    Decoded("scpi.parse_whole", scpi.parse_whole, b"+20", 20, DAQ, b" +-0123456789"),
    Decoded("scpi.parse_readings", scpi.parse_readings, b"+2.61920000E+01,-1.00000000E+00", (26.192, -1.0), DAQ,
            NUMERALS),
    Decoded("scpi.parse_named_readings", scpi.parse_named_readings, b"+2.61920000E+01,101", ((26.192, 101),),
            "34970A/34972A command reference, FORM:READ:CHAN", NUMERALS),
    Decoded("scpi.parse_block", scpi.parse_block, b"#214(@101,102,103)", b"(@101,102,103)", DAQ),
    Decoded("scpi.parse_scan_list", scpi.parse_scan_list, b"#214(@101,102,103)", (101, 102, 103), DAQ),
    Decoded("scpi.parse_channel_list", _text(scpi.parse_channel_list), b"(@101:103)", (101, 102, 103), DAQ,
            b" \t\n\r\x0b\x0c\x1c\x1d\x1e\x1f\x85\xa0"),
    Decoded("scpi.parse_error", scpi.parse_error, b'+0,"No error"', (0, "No error"), DAQ, b" +-0123456789"),
    Decoded("scpi.parse_identity", scpi.parse_identity, b"HEWLETT-PACKARD,34970A,0,13-2-2",
            ("HEWLETT-PACKARD", "34970A", "0", "13-2-2"), DAQ, ANY),
    Decoded("scpi.split_message", _chained, b"CONF:VOLT:DC 10,(@101)", [("CONF:VOLT:DC", "10,(@101)")], DAQ,
            ANY),
    Decoded("vn100.parse_message", vn100.parse_message, b"$VNRRG,01,VN-100_v4*47", ["VNRRG", "01", "VN-100_v4"], VN),
    Decoded("vn100.parse_error", _only_error, b"$VNERR,03*72", "invalid checksum", VN),
    Decoded("vn100.parse_rows", _streamed, YMR, [YMR_VALUES], VN, b"\n"),
    Decoded("csv_rows.parse_rows", _rows, b"$A,1,2*42\r\n", [[1.0, 2.0]], "XOR of A,1,2 by hand", b"\n"),
    Decoded("zaber.decode_reply", _with_checksum(zaber.decode_reply), b"@01 0 00 OK IDLE -- 0:0D",
            Reply(1, 0, True, False, "--", "0", 0, True), "checksum by hand"),
    Decoded("zaber.decode_command", _with_checksum(zaber.decode_command), b"/1 0 00 get pos:2D",
            Command(1, 0, "get pos", 0), ZABER),
    Decoded("zaber.decode_integer", _text(zaber.decode_integer), b"-4267", -4267, ZABER, b"-0123456789"),
)  # fmt: skip

ENCODED = (
    Encoded("csv_rows.format_row", csv_rows.format_row([b"1", b"2"], csv_rows.RowShape(2, b",", b"$A,", "xor")),
            b"$A,1,2*42\r\n", "XOR of A,1,2 by hand"),
    Encoded("esp301.encode", esp301.encode(esp301.set_value("PA", 1, 12.345)), b"1PA12.345000\r", "ESP300 manual, PA"),
    Encoded("esp301.encode_error", esp301.encode_error(ErrorRecord(0, 451322, "NO ERROR DETECTED")),
            b"0, 451322, NO ERROR DETECTED\r\n", ESP),
    Encoded("esp301.encode_reply", esp301.encode_reply("12.345"), b"12.345\r\n", "ESP300 manual, TP"),
    Encoded("hp3458a.format_error", hp3458a.format_error(0), b'0,"NO ERROR"', METER),
    Encoded("hp3458a.format_setting", hp3458a.format_setting(0.1), b".1", "RANGE? of a real meter on 0.1 V"),
    Encoded("hp3458a.format_reading", hp3458a.format_reading(1.00000012), b" 1.000000120E+00\r\n", METER),
    Encoded("hp3488a.card_type", hp3488a.card_type(1), b"CTYPE 1", SCANNER),
    Encoded("hp3488a.close", hp3488a.close(101), b"CLOSE 101", SCANNER),
    Encoded("hp3488a.reset_card", hp3488a.reset_card(1), b"CRESET 1", SCANNER),
    Encoded("hp3488a.open_channel", hp3488a.open_channel(101), b"OPEN 101", SCANNER),
    Encoded("hp3488a.view", hp3488a.view(101), b"VIEW 101", SCANNER),
    Encoded("indexing_table.TableCodec.encode_command", TABLE.encode_command(Move(1, 10.0)), b"1 MOVE +010.0000\r\n",
            TABLES),
    Encoded("indexing_table.TableCodec.encode_reply", TABLE.encode_reply(Identity("SOME TABLE"), 1, Identify),
            b"ID SOME TABLE\r\n", TABLES),
    Encoded("maestro.MaestroCodec.encode", servo.MaestroCodec(12).encode(servo.set_target(0, 6000)),
            bytes.fromhex("AA 0C 04 00 70 2E"), MAESTRO),
    Encoded("maestro.MaestroCodec.encode", servo.MaestroCodec(None, True).encode(servo.set_target(0, 6000)),
            bytes.fromhex("84 00 70 2E 2B"), f"{MAESTRO}; CRC by its rule"),
    Encoded("maestro.encode_word", servo.encode_word(6000), bytes.fromhex("70 17"), MAESTRO),
    Encoded("manual.encode", manual.encode(manual.SetTo("pitch", 30.0)),
            b"pitch: set the axis to 30 deg, then press Enter (or type the angle it shows, or 'no')\n", OPERATOR),
    Encoded("prologix.address", prologix.address(22), b"++addr 22\n", "pyvisa-py 0.8.1 on the wire"),
    Encoded("prologix.message", prologix.message(bytes.fromhex("00 01 02 0D 03 0A 04 1B 05 2B 06")),
            bytes.fromhex("00 01 02 1B 0D 03 1B 0A 04 1B 1B 05 1B 2B 06 0A"), "Prologix manual, page 7"),
    Encoded("prologix.serial_poll", prologix.serial_poll(22), b"++spoll 22\n", "Prologix manual, spoll"),
    Encoded("prologix.setting", prologix.setting("read_tmo_ms", 3000), b"++read_tmo_ms 3000\n", "Prologix manual"),
    Encoded("prologix.setting_query", prologix.setting_query("auto"), b"++auto\n", "pymeasure on the wire"),
    Encoded("angle_lines.AngleCodec.ask", DPG.ask(Question("reading")), b"R", ANGLES),
    Encoded(
        "angle_lines.AngleCodec.format_reading", DPG.format_reading(1.234, -0.007, "deg", 1),
        b"X=+01.234\r\nY=-00.007\r\n", ANGLES,
    ),
    Encoded(
        "angle_lines.AngleCodec.format_unit", LDS.format_unit("urad", 1),
        b"1TA,RT,04512,1,\xb5rad,00102,00241\r\n", ANGLES,
    ),
    Encoded(
        "angle_lines.AngleCodec.format_identity", DPG.format_identity("DPL2 V1.8.0", "123456789"),
        b"DPL2 V1.8.0\r\nSN:123456789\r\n", ANGLES,
    ),
    Encoded("chamber_text.format_temperature", chamber_text.format_temperature(25.0), b"25.0", CHAMBERS),
    Encoded("pi_gcs.command", pi_gcs.command("MOV", "1", "12.5"), b"MOV 1 12.5\n", PI),
    Encoded("scpi.channel_list", scpi.channel_list([101, 102]), b"(@101,102)", DAQ),
    Encoded("scpi.format_block", scpi.format_block(b"(@)"), b"#13(@)", DAQ),
    Encoded("scpi.format_error", scpi.format_error(0, "No error"), b'+0,"No error"', DAQ),
    Encoded("scpi.format_reading", scpi.format_reading(26.192), b"+2.61920000E+01", DAQ),
    Encoded("vn100.message", vn100.message(b"VNASY,0"), b"$VNASY,0*4F\r\n", VN),
    Encoded("vn100.format_row", vn100.format_row("YMR", tuple(YMR_VALUES)), YMR, VN),
    Encoded("zaber.checksum", zaber.checksum(b"1 0 00 get pos"), b"2D", ZABER),
    Encoded("zaber.encode_command", zaber.encode_command(Command(1, 1, "move abs 5000", 1)),
            b"/1 1 01 move abs 5000:EB\n", ZABER),
    Encoded("zaber.encode_reply", zaber.encode_reply(Reply(1, 0, True, False, "--", "0", 0)),
            b"@01 0 00 OK IDLE -- 0:0D\r\n", "checksum by hand"),
)  # fmt: skip

_DECODERS = ("parse_", "decode", "split_", "take")
_NO_ANSWERS = {
    "stream_lines.parse_lines",  # the two that use it are here
    "stream_lines.split_whole_lines",
    "scpi.parse_block",  # here, and it returns bytes
}


def public_functions() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Of every codec, methods included: name and function."""
    for module in pkgutil.iter_modules(rig.wire.__path__):
        found = import_module(f"rig.wire.{module.name}")
        for owner, members in [("", vars(found)), *_classes(found)]:
            for name, function in members.items():
                if inspect.isfunction(function) and not name.startswith("_") and function.__module__ == found.__name__:
                    yield f"{module.name}.{owner}{name}", function


def decoders() -> set[str]:
    """Functions that make values of bytes."""
    return {name for name, _ in public_functions() if name.rpartition(".")[2].startswith(_DECODERS)} - _NO_ANSWERS


def encoders() -> set[str]:
    """Functions that make bytes."""
    made = {name for name, function in public_functions() if inspect.signature(function).return_annotation is bytes}
    return made - _NO_ANSWERS


def _classes(module: Any) -> list[tuple[str, dict[str, Any]]]:
    return [
        (f"{name}.", dict(vars(kind)))
        for name, kind in vars(module).items()
        if inspect.isclass(kind) and kind.__module__ == module.__name__
    ]
