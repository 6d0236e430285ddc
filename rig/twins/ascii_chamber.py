"""The twin of a chamber that speaks lines of text: Thermotron 8800 and 3800, Espec P-300 and SCP-220.

Source: docs/devices/ascii-chambers.md. Assumed: line ends of a Thermotron's replies, the form of its identity and unit,
that a refused write of an 8800 is answered by a number other than 0.
"""

from collections.abc import Callable
from typing import Protocol

LIMITS_DEGC = (-70.0, 180.0)
ZERO, BAD = b"0", b"1"


class Chamber(Protocol):
    """What the twin needs of the world."""

    def read_temperature_degc(self, environment: str, now_s: float) -> float: ...

    def setpoint_degc(self, environment: str) -> float: ...

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None: ...


class AsciiChamberTwin:
    """A :class:`rig.twins.twin.Twin`. ``mode`` is STANDBY, CONSTANT or RUN (a program)."""

    def __init__(
        self,
        environment: str,
        world: Chamber,
        *,
        model: str,
        is_fahrenheit: bool = False,
        channel: int = 1,
        address: int | None = None,
        reply_end: bytes = b"\r\n",
    ) -> None:
        self.mode = "STANDBY"
        self.alarms: tuple[int, ...] = ()
        """Codes of an Espec; of an 8800 the one sum of its bits."""
        self.stop_code = 5
        """Of an 8800 that stands."""
        self.is_fahrenheit = is_fahrenheit
        self._environment, self._world = environment, world
        self._is_espec = model.startswith("espec")
        self._answers_writes = model != "thermotron-3800"
        self._channel = b"%d" % channel
        self._address = None if address is None else b"%d," % address
        self._model = model
        self._reply_end = reply_end
        self._wanted_degc: float | None = None
        """Of a 3800: taken at the next start."""
        self._received = self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        end = b"\n" if self._is_espec else b"\r"
        *lines, self._received = (self._received + data).split(end)
        for line in lines:
            self._take(line.strip(b"\r\n"), now_s)

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def _take(self, line: bytes, now_s: float) -> None:
        if self._address is not None:
            if not line.startswith(self._address):
                return  # for somebody else on the line
            line = line.removeprefix(self._address)
        answer = self._espec(line, now_s) if self._is_espec else self._thermotron(line, now_s)
        if answer is not None:
            self._due += answer + self._reply_end

    def _espec(self, line: bytes, now_s: float) -> bytes:
        queries: dict[bytes, Callable[[], bytes]] = {
            b"TYPE?": lambda: b"T,T,%s,180.0" % (b"P300" if self._model == "espec-p300" else b"SCP-220"),
            b"ROM?": lambda: b"JASM1001",
            b"TEMP?": lambda: b",".join(
                self._shown(degc)
                for degc in (self._air_degc(now_s), self._setpoint_degc(), LIMITS_DEGC[1], LIMITS_DEGC[0])
            ),
            b"MODE?": lambda: self.mode.encode("ascii"),
            b"CONSTANT SET?,TEMP": lambda: self._shown(self._setpoint_degc()) + b",ON",
            b"ALARM?": lambda: b",".join(b"%d" % number for number in (len(self.alarms), *self.alarms)),
            b"MON?": lambda: b"%s,,%s,0" % (self._shown(self._air_degc(now_s)), self.mode.encode("ascii")),
        }
        if line in queries:
            return queries[line]()
        if line.startswith(b"TEMP, S"):
            return self._espec_setpoint(line, now_s)
        if line in (b"MODE,CONSTANT", b"MODE,STANDBY"):
            self.mode = line.partition(b",")[2].decode("ascii")
            return b"OK:" + (self._address or b"") + line
        return b"NA:CMD ERR"

    def _espec_setpoint(self, line: bytes, now_s: float) -> bytes:
        degc = self._understood(line.removeprefix(b"TEMP, S"))
        if degc is None:
            return b"NA:PARA ERR"
        if not LIMITS_DEGC[0] <= degc <= LIMITS_DEGC[1]:
            return b"NA:DATA OUT OF RANGE"
        self._world.hold(self._environment, degc, now_s)
        return b"OK:" + (self._address or b"") + line

    def _thermotron(self, line: bytes, now_s: float) -> bytes | None:
        if line == b"PVAR%s?" % self._channel:
            return self._shown(self._air_degc(now_s))
        if line == b"SETP%s?" % self._channel:
            return self._shown(self._setpoint_degc())
        if line == b"IDEN?":
            return b"8800" if self._answers_writes else b"3800"
        if not self._answers_writes and line == b"MODE?":
            return {"STANDBY": b"0", "CONSTANT": b"16", "RUN": b"1"}[self.mode]
        if self._answers_writes:
            known = {
                b"VRSN?": b"1.20",
                b"SCOD?": b"%d" % self.stop_code if self.mode == "STANDBY" else b"1",
                b"ALRM%s?" % self._channel: b"%d" % sum(self.alarms),
                b"CCHR%s?" % self._channel: b"F" if self.is_fahrenheit else b"C",
            }
            if line in known:
                return known[line]
        if line.endswith(b"?"):
            return None
        done = self._thermotron_write(line, now_s)
        return (ZERO if done else BAD) if self._answers_writes else None

    def _thermotron_write(self, line: bytes, now_s: float) -> bool:
        if line == b"RUNM":
            self.mode = "CONSTANT"
            if self._wanted_degc is not None:
                self._world.hold(self._environment, self._wanted_degc, now_s)
            return True
        if line == b"STOP":
            self.mode = "STANDBY"
            return True
        if not line.startswith(b"SETP%s," % self._channel):
            return False
        degc = self._understood(line.partition(b",")[2])
        if degc is None or not LIMITS_DEGC[0] <= degc <= LIMITS_DEGC[1]:
            return False
        if self._answers_writes:
            self._world.hold(self._environment, degc, now_s)
        else:
            self._wanted_degc = degc
        return True

    def _air_degc(self, now_s: float) -> float:
        return self._world.read_temperature_degc(self._environment, now_s)

    def _setpoint_degc(self) -> float:
        return self._world.setpoint_degc(self._environment)

    def _shown(self, degc: float) -> bytes:
        return b"%.1f" % (round(degc * 1.8 + 32.0 if self.is_fahrenheit else degc, 1) + 0.0)

    def _understood(self, text: bytes) -> float | None:
        try:
            value = float(text)
        except ValueError:
            return None
        return (value - 32.0) / 1.8 if self.is_fahrenheit else value
