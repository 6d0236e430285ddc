"""Indexing tables with a curvic coupling: they stop only at multiples of their increment, and are exact there."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from threading import Lock
from typing import ClassVar, Literal, Self

from pydantic import Field

from rig.abilities.abilities import AxisState, StopStep
from rig.abilities.rest import moves_between
from rig.abilities.starting import TAKEN_UP_S, see_taken_up, start_once
from rig.abilities.targets import Miswritten, check_target, require_home
from rig.description.device_settings import COMMANDED, AxisSettings
from rig.errors import DescriptionError, DeviceNonsense, DeviceRefused, NoStop, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from rig.wire.dialect_files import WRITTEN_OUT, dialect_file
from rig.wire.indexing_table import (
    Acknowledged,
    AskPosition,
    AskState,
    Command,
    Enable,
    Home,
    Identify,
    Identity,
    Move,
    Position,
    Prepare,
    Rate,
    Refused,
    Release,
    Reply,
    Speed,
    Stop,
    TableCodec,
    TableState,
)
from rig.wire.table_dialect import Dialect, NamedDialect, load_dialect

_SAME_ANGLE_DEG = 1e-4
"""Half the last digit of a read-back, rounded up: closer than this is the commanded tooth."""
_WRITTEN_DPS = 1e-9
_TIMES_REFUSED = 3
"""So often the machine may refuse a question before it is believed: the line may have damaged it on its way."""


class DialectSettings(AxisSettings):
    """Of a machine whose grammar is a dialect."""

    names_files: ClassVar[tuple[str, ...]] = (*AxisSettings.names_files, "dialect")
    dialect: NamedDialect | None = None
    """By default it follows from the increment."""
    homed_before: bool = False
    """The operator vouches for a home of a machine that does not tell of it."""

    def spoken(self) -> Dialect:
        """Return the dialect that this axis is spoken to in. Raises: DescriptionError."""
        return load_dialect(self.dialect, self.increment_deg)

    @property
    def moves_to_home(self) -> bool:
        return self.spoken().home is not None

    @property
    def baud_rate(self) -> int:
        return self.spoken().line.baud_rate

    @property
    def parity(self) -> str:
        return self.spoken().line.parity

    @property
    def data_bits(self) -> int:
        return self.spoken().line.data_bits

    @property
    def stop_bits(self) -> int:
        return self.spoken().line.stop_bits

    @property
    def rts_cts(self) -> bool:
        return self.spoken().line.rts_cts

    def file_complaints(self, folder: Path) -> Iterator[tuple[tuple[str, ...], str]]:
        if isinstance(self.dialect, Dialect):
            yield ("dialect",), WRITTEN_OUT
            return
        try:
            codec = TableCodec(self.with_files(folder).spoken())
        except DescriptionError as error:
            yield ("dialect" if self.dialect else "increment_deg",), str(error)
            return
        if why := miswritten_speed(codec, self):
            yield ("speed_dps",), f"got {self.speed_dps:g} °/s: {why}; nothing moved; give a speed that it can write"

    def with_files(self, folder: Path) -> Self:
        if not isinstance(self.dialect, str) or (file := dialect_file(self.dialect, folder)) is None:
            return self
        return self.model_copy(update={"dialect": load_dialect(str(file), self.increment_deg)})

    def miswritten(self) -> Miswritten:
        return miswritten_targets(TableCodec(self.spoken()), self)

    def remarks(self) -> tuple[str, ...]:
        dialect = self.spoken()
        lacks = [
            (dialect.position_is == "commanded", f"its position is {COMMANDED}"),
            (dialect.stop is None, "it cannot be stopped: a move that began ends at its target"),
            (dialect.identity is None, "it cannot be asked who it is"),
            (
                dialect.state is None,
                f"it does not tell whether it moves: two positions {dialect.still_s:g} s apart do",
            ),
        ]
        return tuple(f"dialect {dialect.name}: {sentence}" for is_lacking, sentence in lacks if is_lacking)


def miswritten_targets(codec: TableCodec, settings: DialectSettings) -> Miswritten:
    """Return what tells why an attitude would be written as another one, or as one that the machine does not take."""

    def why(attitude_deg: float) -> str:
        # Adding 0.0 turns −0.0 into 0.0, which the wire would show as -000.0000.
        wanted_deg = round(settings.table_deg(attitude_deg), 6) + 0.0
        taken_deg = codec.dialect.move.targets_deg
        if taken_deg is not None and not taken_deg[0] <= wanted_deg <= taken_deg[1]:
            line = codec.written(Move(settings.axis, wanted_deg)).line
            return (
                f"the dialect {codec.dialect.name} would write {line!r}, and its machine takes {taken_deg[0]:g} to"
                f" {taken_deg[1]:g}° (move: targets_deg)"
            )
        return _miswritten(codec, Move(settings.axis, wanted_deg), wanted_deg, _SAME_ANGLE_DEG, "°")

    return why


def miswritten_speed(codec: TableCodec, settings: DialectSettings) -> str:
    """Return why the speed to positions would be written as another one; empty where it is not, or not sent."""
    if not codec.knows(Speed):
        return ""
    command = Speed(settings.axis, settings.speed_dps)
    return _miswritten(codec, command, settings.speed_dps, _WRITTEN_DPS, " °/s")


def miswritten_rate(codec: TableCodec, settings: DialectSettings, rate_dps: float) -> str:
    """Return why a rate would be written as another one; empty where it is not."""
    return _miswritten(codec, Rate(settings.axis, rate_dps), rate_dps, _WRITTEN_DPS, " °/s")


def _miswritten(codec: TableCodec, command: Move | Speed | Rate, wanted: float, close: float, unit: str) -> str:
    """Return what the machine would read in place of what was asked; empty where it reads that."""
    written = codec.written(command)
    if abs(written.value - wanted) <= close:
        return ""
    read = "no number" if math.isnan(written.value) else f"{written.value:g}{unit}"
    return f"the dialect {codec.dialect.name} would write {written.line!r} by {written.template!r}, which is {read}"


class IndexingTableSettings(DialectSettings):
    """``driver = "indexing-table"``."""

    driver: Literal["indexing-table"]
    increment_deg: float = Field(gt=0.0)


class IndexingTableAxis:
    """One axis of the controller behind an exchange: a :class:`rig.abilities.abilities.Axis`.

    Axes of one controller share the exchange; ``turn`` lets one of them speak at a time.
    """

    def __init__(
        self,
        name: str,
        settings: DialectSettings,
        codec: TableCodec,
        exchange: Exchange,
        turn: AbstractContextManager[object],
        unwrap: Callable[[float], float] = float,
    ) -> None:
        """Make the axis; ``unwrap`` makes the angle that goes on beyond a turn of the one that is told."""
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = settings.arrival_tolerance_deg
        self._number = settings.axis
        self._settings = settings
        self._codec, self._exchange, self._turn = codec, exchange, turn
        self._unwrap = unwrap
        self._miswritten = miswritten_targets(codec, settings)
        self._home: Literal["none", "searching", "found"] = "found" if settings.homed_before else "none"
        """Where the machine does not tell."""
        self._is_enabled = False
        self._bound_for_deg: float | None = None
        """Table angle of a move that was not seen to end; NaN of a home or a rate (:mod:`rig.abilities.rest`)."""

    def identify(self) -> str:
        if not self._codec.knows(Identify):
            self._ask(AskPosition(self._number))
            return f"{self._codec.dialect.name}, axis {self._number}; it cannot be asked who it is"
        reply = self._ask(Identify())
        assert isinstance(reply, Identity)
        return f"{reply.text}, axis {self._number}"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, self._settings, target_deg, self._miswritten)

    def start_move(self, target_deg: float) -> None:
        self.check_target(target_deg)
        require_home(self.name, f"move to {target_deg:g}°", is_homed=self.state().is_homed)
        self.enable()
        if self._codec.knows(Prepare):
            self._ask(Prepare(self._number))
        # Adding 0.0 turns −0.0 into 0.0, which the wire would show as -000.0000.
        self._start(Move(self._number, round(self._settings.table_deg(target_deg), 6) + 0.0), target_deg)

    def home(self) -> None:
        """Start the search for the home and see it begin; without one positions are absolute, and nothing moves.

        It begins where the machine says that this very axis took it, moves, or tells of a home that was not there
        before: a search that was lost on the line is no home. Raises also: DeviceFault.
        """
        was_homed = self._ask_state().is_homed
        self._is_enabled = False  # a machine that lost power forgot its speed, too
        if not self._codec.knows(Home):
            return
        self._home = "none"
        self.enable()
        self._start(Home(self._number), None)
        if not self._codec.names_its_axis(Home):
            self._see_search(was_homed=was_homed)
        self._home = "searching"

    def enable(self) -> None:
        """Tell the machine, once, what it must know before it moves."""
        if self._is_enabled:
            return
        if self._codec.knows(Enable):
            self._ask(Enable(self._number))
        if self._codec.knows(Speed):
            if why := miswritten_speed(self._codec, self._settings):
                raise RequestRefused(
                    f"{self.name}: speed of {self.speed_dps:g} °/s: {why}; nothing moved; give a speed that it can"
                    f" write (axes.{self.name}: speed_dps)"
                )
            self._ask(Speed(self._number, self.speed_dps))
        self._is_enabled = True

    def _see_search(self, *, was_homed: bool | None) -> None:
        def is_begun() -> bool:
            answer = self._ask_state()
            return answer.is_moving or (was_homed is False and answer.is_homed is True)

        unseen = (
            f"{self.name}: home: it was sent, but the axis does not begin within {TAKEN_UP_S:g} s; there is no home;"
            " look at the line and the controller; where it stands at its home already and does not tell so,"
            f" move it away by hand, or vouch for it (axes.{self.name}: homed_before)"
        )
        see_taken_up(is_begun, self._exchange.stream.clock, unseen)

    def state(self) -> AxisState:
        answer = self._ask_state()
        if self._home == "searching" and answer.is_homed is None and not answer.is_moving:
            answer = self._ask_state()  # its word alone ends a search, and may be damaged on the line
        table_deg = self._table_deg()
        if self._home == "searching" and not answer.is_moving:
            self._home = "none" if answer.is_faulty else "found"
        is_homed = not self._codec.knows(Home) or self._home == "found" if answer.is_homed is None else answer.is_homed
        return AxisState(
            position_deg=self._settings.attitude_deg(table_deg),
            is_moving=answer.is_moving,
            is_homed=is_homed,
            is_seated=answer.is_seated,
            fault="the controller reports a fault" if answer.is_faulty else "",
        )

    def stop(self) -> None:
        if not self._codec.knows(Stop):
            raise NoStop(
                f"{self.name}: the dialect {self._codec.dialect.name} has no stop: a move that began ends at its"
                " target; nothing was sent; cut its power where it must not"
            )
        if self._home == "searching":
            self._home = "none"
        self._bound_for_deg = None
        self._exchange.write_in_doubt(self._codec.encode_command(Stop(self._number)))
        self._ask(Stop(self._number))
        if self._codec.is_bare(Stop):
            self._exchange.doubt()  # whatever is said to it must not be taken for the next answer

    def stop_steps(self) -> Sequence[StopStep]:
        """Return nothing where the dialect has no stop."""
        if not self._codec.knows(Stop):
            return ()
        return (StopStep(self._codec.encode_command(Stop(self._number))),)

    def _ask_state(self) -> TableState:
        """Return its state: by its own word, or by whether it is still where it was."""
        if self._codec.knows(AskState):
            answer = self._ask(AskState(self._number))
            assert isinstance(answer, TableState)
            return answer
        before_deg = self._table_deg()
        self._exchange.stream.clock.sleep(self._codec.dialect.still_s)
        is_moving = moves_between(before_deg, self._table_deg(), self._bound_for_deg, self.arrival_tolerance_deg)
        if not is_moving:
            self._bound_for_deg = None
        return TableState(is_moving=is_moving, is_seated=True, is_homed=None)

    def _is_at(self, target_deg: float, here_deg: float) -> bool:
        return abs(here_deg - target_deg) <= self.arrival_tolerance_deg

    def _table_deg(self) -> float:
        position = self._ask(AskPosition(self._number))
        assert isinstance(position, Position)
        return self._unwrap(position.position_deg)

    def position_deg(self) -> float:
        """Ask for the attitude angle alone."""
        return self._settings.attitude_deg(self._table_deg())

    def turn(self, rate_dps: float) -> None:
        """Turn on and on, by the table's own sense."""
        self.enable()
        self._start(Rate(self._number, rate_dps), None)
        if self._codec.knows(Release):
            self._ask(Release(self._number))
            self._exchange.doubt()  # it answers twice now: the line must fall quiet before the next question

    def _start(self, command: Move | Home | Rate, target_deg: float | None) -> None:
        self._bound_for_deg = command.target_deg if isinstance(command, Move) else math.nan
        start_once(lambda: self._ask(command), lambda: self._has_started(target_deg))

    def _has_started(self, target_deg: float | None) -> bool:
        state = self.state()
        is_there = target_deg is not None and self._is_at(target_deg, state.position_deg)
        return state.is_moving or is_there

    def _ask(self, command: Command) -> Reply:
        """Ask anew where the line damaged a question on its way and it was refused; a command is sent once."""
        is_question = isinstance(command, AskState | AskPosition | Identify)
        refusal = ""
        for _ in range(_TIMES_REFUSED if is_question else 1):
            reply = self._ask_once(command)
            if not isinstance(reply, Refused):
                return reply
            refusal = reply.text
        # A question says nothing of motion: the axis may be on its way.
        known = "it may answer another command" if is_question else "the command was not taken"
        raise DeviceRefused(
            f"{self.name}: the table refused {command}: {refusal!r}; {known};"
            " look at the table's display and its manual"
        )

    def _ask_once(self, command: Command) -> Reply:
        idempotent = not isinstance(command, Move | Home | Rate)
        with self._turn:
            if not self._codec.is_answered(type(command)):
                self._exchange.tell(self._codec.encode_command(command))
                return Acknowledged()
            return self._exchange.ask(
                self._codec.encode_command(command), lambda line: self._parse(line, command), idempotent=idempotent
            )

    def _parse(self, line: bytes, command: Command) -> Reply:
        reply = self._codec.decode_reply(line, command)
        if reply is None:
            raise DeviceNonsense(f"not a line of the dialect {self._codec.dialect.name} for this question")
        return reply


def exchange_of(codec: TableCodec, stream: ByteStream) -> Exchange:
    """Return questions and answers in a dialect."""
    patience = Patience(timeout_s=codec.dialect.reply_timeout_s)
    return Exchange(stream, terminator=codec.reply_terminator, patience=patience)


def connect(axes: Mapping[str, IndexingTableSettings], stream: ByteStream) -> dict[str, IndexingTableAxis]:
    """Return the axes of one controller, which share its line. Raises: DescriptionError (its dialect)."""
    finest = min(axes.values(), key=lambda settings: settings.increment_deg)
    codec = TableCodec(finest.spoken())
    exchange, turn = exchange_of(codec, stream), Lock()
    return {name: IndexingTableAxis(name, settings, codec, exchange, turn) for name, settings in axes.items()}
