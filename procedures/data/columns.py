"""What the tables of a run hold, column by column: a contract with a version, which docs/data.md tells a reader.

A column is never renamed, never changes its unit and never leaves; a new one stands behind the others and raises the
version.
"""

from collections.abc import Mapping
from dataclasses import dataclass

DATA_VERSION = 1
DWELL = "dwell"
"""Index of every table but the events: the number of the dwell in its journal, which no other dwell has."""

WHOLE, NUMBER, TEXT, TRUTH, MOMENT = "int64", "float64", "str", "bool", "datetime64[us, UTC]"


@dataclass(frozen=True)
class Column:
    """One column of one table."""

    name: str
    kind: str
    """As pandas calls it."""
    meaning: str


_KEY = (
    Column("step", WHOLE, "place in the plan, from 0"),
    Column("attempt", WHOLE, "judged attempt of the step, from 1"),
)
_CHANNEL = (
    Column("sensor", TEXT, "serial of the package; empty where the channel is no sensor's"),
    Column("axis", TEXT, "axis of the package or of the rig; `temperature` is the package's own thermometer"),
    Column("channel", TEXT, "full name, `readout.channel`"),
    Column("unit", TEXT, "of the number: `v`, `dps`, `ut`, `g`, `deg`, `degc`, `s` or `counts`"),
)

TABLES: Mapping[str, tuple[Column, ...]] = {
    "dwells": (
        Column("run", TEXT, "identity of the run"),
        *_KEY,
        Column("epoch", WHOLE, "from 1; each restart of the run opens a new one"),
        Column("replication", WHOLE, "from 1; 0 for the check set"),
        Column("point", WHOLE, "design point, from 1; 0 where it is none"),
        Column("mounting", WHOLE, "from 1; a package that was moved begins a new one"),
        Column("purpose", TEXT, "`design` enters the solution; `reference`, `check`"),
        Column("accepted", TRUTH, "false also where it was taken back later"),
        Column("reasons", TEXT, "why it was rejected, or what is remarkable; separated by `; `"),
        Column("started_utc", MOMENT, "when it began"),
        Column("pitch_deg", NUMBER, "as the solver takes it: read back; of an axis that turned, its start"),
        Column("roll_deg", NUMBER, "the same"),
        Column("yaw_deg", NUMBER, "the same"),
        Column(
            "temperature_degc",
            NUMBER,
            "of the rig's only environment: the mean of a dwell's two readings, or the one of them that no sensor "
            "stands; empty where there is none or several",
        ),
    ),
    "readings": (
        *_KEY,
        *_CHANNEL,
        Column("mean", NUMBER, "of the samples; empty where one is overloaded"),
        Column("sd", NUMBER, "standard deviation of one sample; empty where there are fewer than two"),
        Column("n", WHOLE, "samples; 0 where the number is no mean of samples"),
    ),
    "events": (
        Column("sequence", WHOLE, "place in the audit trail, from 1"),
        Column("utc", MOMENT, "when"),
        Column("monotonic_s", NUMBER, "by a clock that nobody sets, comparable within one process"),
        Column("kind", TEXT, "`state`, `intent`, `dwell`, `note`, `trip` …"),
        Column("detail", TEXT, "JSON, as it was hashed"),
        Column("sha256", TEXT, "of this event and the one before it"),
    ),
    "samples": (
        *_KEY,
        *_CHANNEL,
        Column("sample", WHOLE, "place among the samples of the dwell and channel, from 0"),
        Column("time_s", NUMBER, "when, in rig seconds, comparable within one epoch"),
        Column("value", NUMBER, "as it was read; empty where overloaded"),
    ),
}
"""Name to its columns, in their order."""
