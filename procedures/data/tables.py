"""From the records of a journal to pandas tables; every number is the journal's own, to the last bit."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from procedures.data.columns import DWELL, TABLES
from procedures.journal.encoding import compact_json
from procedures.records.dwells import ChannelReading, DwellRecord, Event
from procedures.solution.observations import attitude_deg
from rig.description.rig_file import Sensor

Numbered = tuple[int, DwellRecord]
Owner = tuple[str, str]
"""(sensor, axis) of a channel, both empty where it is no sensor's."""


def dwells_table(run_id: str, dwells: Iterable[Numbered]) -> pd.DataFrame:
    """Return a row for every judged dwell, rejected ones too, by its number in the journal."""
    return _table("dwells", [(number, _dwell_row(run_id, dwell)) for number, dwell in dwells])


def readings_table(dwells: Iterable[Numbered], sensors: Mapping[str, Sensor]) -> pd.DataFrame:
    """Return a row for every channel of every dwell, and for what an axis or a coil did where the plan moved it."""
    owners = _owners(sensors)
    return _table(
        "readings",
        [
            (number, [dwell.step, dwell.attempt, *row])
            for number, dwell in dwells
            for row in (*_channel_rows(dwell, owners), *_rig_rows(dwell))
        ],
    )


def events_table(events: Iterable[Event]) -> pd.DataFrame:
    """Return the audit trail, a row an event."""
    rows = [
        (
            index,
            [event.sequence, event.utc, event.monotonic_s, event.kind, compact_json(dict(event.detail)), event.sha256],
        )
        for index, event in enumerate(events)
    ]
    return _table("events", rows, index=None)


def samples_table(dwells: Iterable[Numbered], sensors: Mapping[str, Sensor]) -> pd.DataFrame:
    """Return every sample of every channel, a row each, in the order in which they were read."""
    owners = _owners(sensors)
    parts = [
        (number, dwell, owner, reading)
        for number, dwell in dwells
        for reading in dwell.readings.values()
        for owner in owners.get(reading.channel, [("", "")])
    ]
    counts = [reading.samples.size for *_, reading in parts]
    indices = np.concatenate([np.arange(count) for count in counts]) if parts else np.zeros(0, dtype=np.int64)
    started_s = np.repeat([reading.started_s for *_, reading in parts], counts)
    interval_s = np.repeat([reading.interval_s for *_, reading in parts], counts)
    columns = {
        "step": np.repeat([dwell.step for _, dwell, *_ in parts], counts),
        "attempt": np.repeat([dwell.attempt for _, dwell, *_ in parts], counts),
        "sensor": _repeated([owner[0] for *_, owner, _ in parts], counts),
        "axis": _repeated([owner[1] for *_, owner, _ in parts], counts),
        "channel": _repeated([reading.channel for *_, reading in parts], counts),
        "unit": _repeated([reading.unit for *_, reading in parts], counts),
        "sample": indices,
        "time_s": started_s + indices * interval_s,
        "value": np.concatenate([reading.samples for *_, reading in parts]) if parts else np.zeros(0),
    }
    numbers = np.repeat(np.array([number for number, *_ in parts], dtype=np.int64), counts)
    return _typed("samples", pd.DataFrame(columns, index=pd.Index(numbers, name=DWELL)))


def _dwell_row(run_id: str, dwell: DwellRecord) -> list[Any]:
    temperatures_degc = list(dwell.temperature_degc.values())
    return [
        run_id,
        dwell.step,
        dwell.attempt,
        dwell.epoch,
        dwell.replication,
        dwell.point,
        dwell.mounting,
        dwell.purpose,
        dwell.accepted,
        "; ".join(dwell.reasons),
        dwell.started_utc,
        *(attitude_deg(dwell, axis, absent=np.nan) for axis in ("pitch", "roll", "yaw")),
        temperatures_degc[0] if len(temperatures_degc) == 1 else np.nan,
    ]


def _channel_rows(dwell: DwellRecord, owners: Mapping[str, Sequence[Owner]]) -> Iterator[list[Any]]:
    for channel, reading in dwell.readings.items():
        figures = [reading.unit, _mean(reading), reading.standard_deviation, reading.samples.size]
        for sensor, axis in owners.get(channel, [("", "")]):
            yield [sensor, axis, channel, *figures]


def _rig_rows(dwell: DwellRecord) -> Iterator[list[Any]]:
    """Return what no column of the dwells holds: rates as measured, fields, where axes stood by their own
    read-back when a reference told the attitude, temperatures where there are several.
    """
    if len(dwell.temperature_degc) > 1:
        for name, degc in dwell.temperature_degc.items():
            yield ["", "", f"environment.{name}", "degc", degc, np.nan, 0]
    if dwell.motion is not None:
        for axis, rate_dps in dwell.motion.rates_dps.items():
            yield ["", axis, f"axes.{axis}", "dps", rate_dps, np.nan, 0]
        for axis, commanded_deg in dwell.motion.commanded_deg.items():
            yield ["", axis, f"commanded.{axis}", "deg", commanded_deg, np.nan, 0]
        for coil, field_ut in dwell.motion.field_ut.items():
            yield ["", "", f"field.{coil}", "ut", field_ut, np.nan, 0]


def _mean(reading: ChannelReading) -> float:
    return reading.mean if reading.samples.size else float("nan")


def _owners(sensors: Mapping[str, Sensor]) -> dict[str, list[Owner]]:
    """Return the sensors' axes by channel; one thermometer may be that of several packages."""
    found: dict[str, list[Owner]] = {}
    for name, sensor in sensors.items():
        for axis, channel in sensor.channels.items():
            found.setdefault(channel, []).append((name, axis))
        if sensor.temperature is not None:
            found.setdefault(sensor.temperature.channel, []).append((name, "temperature"))
    return found


def _table(name: str, rows: Sequence[tuple[int, list[Any]]], index: str | None = DWELL) -> pd.DataFrame:
    columns = [column.name for column in TABLES[name]]
    numbers = None if index is None else pd.Index([number for number, _ in rows], dtype="int64", name=index)
    return _typed(name, pd.DataFrame([row for _, row in rows], columns=columns, index=numbers))


def _typed(name: str, table: pd.DataFrame) -> pd.DataFrame:
    return table.astype({column.name: column.kind for column in TABLES[name]})


def _repeated(words: Sequence[str], counts: Sequence[int]) -> Any:
    """Return words as many times as each is counted; held once however long the table is."""
    return pd.Series(words, dtype="str").repeat(list(counts)).to_numpy()
