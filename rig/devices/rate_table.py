"""Rate tables that speak lines: the grammar is a dialect, as of indexing tables, with a command that turns on and on.

No maker's manual of such a table could be used (docs/devices/rate-table.md), so nothing about the rate is believed: it
is measured from two looks at the angle, and a rate that the dialect cannot write is refused.
"""

from collections.abc import Mapping, Sequence
from threading import Lock
from typing import Literal

from rig.abilities import rates
from rig.abilities.abilities import AxisState, StopStep, TurnLook
from rig.abilities.targets import require_home
from rig.clock import Clock
from rig.devices.indexing_table import DialectSettings, IndexingTableAxis, exchange_of, miswritten_rate
from rig.errors import RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange
from rig.wire.indexing_table import Rate, TableCodec
from rig.wire.table_dialect import Dialect, NamedDialect, load_dialect


class RateTableSettings(DialectSettings, rates.RevolvingSettings):
    """``driver = "rate-table"``."""

    driver: Literal["rate-table"]
    dialect: NamedDialect = "generic-rate-table"

    def spoken(self) -> Dialect:
        return load_dialect(self.dialect, self.increment_deg)

    @property
    def position_wraps(self) -> bool:
        return self.spoken().position_wraps

    def refuse_rate(self, name: str, rate_dps: float) -> None:
        super().refuse_rate(name, rate_dps)
        _refuse_unwritten(name, TableCodec(self.spoken()), self, rate_dps)


def _refuse_unwritten(name: str, codec: TableCodec, settings: RateTableSettings, rate_dps: float) -> None:
    """Refuse a rate that the dialect has no command for, or would write as another. Raises: RequestRefused."""
    if not codec.knows(Rate):
        raise RequestRefused(
            f"{name}: turn at {rate_dps:g} °/s: the dialect {codec.dialect.name} has no command for a"
            " rate; nothing moved; give it one, or leave top_rate_dps out"
        )
    if why := miswritten_rate(codec, settings, rate_dps):
        raise RequestRefused(
            f"{name}: turn at {rate_dps:g} °/s: {why}; nothing moved; ask for a rate with fewer decimals"
        )


class Unwound:
    """The angle that goes on beyond a turn, of one that begins again at 360 degrees.

    Between two looks the table is believed to have gone on as between the two before, to half a turn, unless it stood.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._angle_deg = self._rate_dps = 0.0
        self._looked_s: float | None = None

    def __call__(self, reported_deg: float) -> float:
        now_s = self._clock.monotonic_s()
        since_s = 0.0 if self._looked_s is None else now_s - self._looked_s
        expected_deg = self._angle_deg + self._rate_dps * since_s
        angle_deg = reported_deg + 360.0 * round((expected_deg - reported_deg) / 360.0)
        if since_s > 0.0:
            self._rate_dps = (angle_deg - self._angle_deg) / since_s
        self._angle_deg, self._looked_s = angle_deg, now_s
        return angle_deg

    def stand(self) -> None:
        """Take note that it was seen at rest: it does not go on from there by itself."""
        self._rate_dps = 0.0


class RateTableAxis:
    """A :class:`rig.abilities.abilities.Axis` and a :class:`rig.abilities.abilities.RateAxis`."""

    def __init__(
        self, name: str, settings: RateTableSettings, codec: TableCodec, exchange: Exchange, turn: Lock
    ) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = settings.arrival_tolerance_deg
        self.top_rate_dps = settings.top_rate_dps or 0.0
        self._settings = settings
        self._codec = codec
        self._unwound = Unwound(exchange.stream.clock) if codec.dialect.position_wraps else None
        self._table = IndexingTableAxis(name, settings, codec, exchange, turn, self._unwound or float)

    def identify(self) -> str:
        return self._table.identify()

    def check_target(self, target_deg: float) -> None:
        self._table.check_target(target_deg)

    def check_rate(self, rate_dps: float) -> None:
        rates.check_rate(self.name, rate_dps, self.top_rate_dps)
        _refuse_unwritten(self.name, self._codec, self._settings, rate_dps)

    def start_move(self, target_deg: float) -> None:
        self._table.start_move(target_deg)

    def start_rate(self, rate_dps: float) -> None:
        self.check_rate(rate_dps)
        require_home(self.name, f"turn at {rate_dps:g} °/s", is_homed=self.state().is_homed)
        self._table.turn(self._settings.sign * rate_dps)

    def home(self) -> None:
        self._table.home()

    def turn_look(self, clock: Clock) -> TurnLook:
        return rates.look(self._table.position_deg, clock)

    def state(self) -> AxisState:
        state = self._table.state()
        if self._unwound is not None and not state.is_moving:
            self._unwound.stand()
        return state

    def stop(self) -> None:
        self._table.stop()

    def stop_steps(self) -> Sequence[StopStep]:
        return self._table.stop_steps()


def connect(axes: Mapping[str, RateTableSettings], stream: ByteStream) -> dict[str, RateTableAxis]:
    """Return the axes of one controller, which share its line. Raises: DescriptionError (its dialect)."""
    codec = TableCodec(next(iter(axes.values())).spoken())
    exchange, turn = exchange_of(codec, stream), Lock()
    return {name: RateTableAxis(name, settings, codec, exchange, turn) for name, settings in axes.items()}
