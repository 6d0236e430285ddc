"""Records as the bytes that are stored and hashed: the text of a row is the very text its SHA-256 was taken of.

A dwell is one line of JSON (everything but the samples, fields and mappings in their own order) and one blob (the
samples of every channel, float64, little-endian, in the order of the readings). An event's hash covers the hash of the
event before it, the first one the header's.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from datetime import datetime
from typing import Any

import numpy as np

from procedures.errors import JournalError
from procedures.records.dwells import (
    ANGLE,
    LOOKED,
    TAKEN,
    ChannelReading,
    DwellRecord,
    Event,
    MotionRecord,
    StreamTiming,
)

FLOAT = np.dtype("<f8")
VOLTS = "v"
_COMPACT = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":"))
_UNITS_OF_COLUMNS = {ANGLE: "deg", LOOKED: "s", TAKEN: "s"}
"""Of what a run records beside the channels of the rig."""
_OF_THE_PLAN = "attitude_uncertainty_deg"
"""Dwells of before 2026-12 repeat the uncertainty of the reference of attitude, which the plan states."""


def compact_json(value: object) -> str:
    """Return a value as one line of JSON. Raises: ValueError for a number that is not finite."""
    return _COMPACT.encode(value)


def encode_dwell(record: DwellRecord) -> tuple[str, bytes]:
    """Return (text, samples) of a record; its ``sha256`` is not part of either."""
    document: dict[str, Any] = {
        "step": record.step,
        "purpose": record.purpose,
        "replication": record.replication,
        "point": record.point,
        "attempt": record.attempt,
        "epoch": record.epoch,
        "accepted": record.accepted,
        "reasons": list(record.reasons),
        "targets_deg": dict(record.targets_deg),
        "measured_deg": dict(record.measured_deg),
        "temperature_degc": dict(record.temperature_degc),
        "readings": [
            [channel, int(reading.samples.size), reading.started_s, reading.interval_s]
            for channel, reading in record.readings.items()
        ],
        "started_utc": record.started_utc.isoformat(),
        "ended_utc": record.ended_utc.isoformat(),
        "started_s": record.started_s,
        "ended_s": record.ended_s,
        "settle_s": record.settle_s,
        "mounting": record.mounting,
    }
    if units := {name: reading.unit for name, reading in record.readings.items() if reading.unit != VOLTS}:
        document["units"] = units
    if record.motion is not None:
        document["motion"] = asdict(record.motion)
    samples = b"".join(reading.samples.astype(FLOAT).tobytes() for reading in record.readings.values())
    return compact_json(document), samples


def hash_dwell(text: str | bytes, samples: bytes) -> str:
    """Return SHA-256 of a stored dwell; a text that was damaged is given as its bytes."""
    digest = hashlib.sha256(text if isinstance(text, bytes) else text.encode("utf-8"))
    digest.update(b"\0")
    digest.update(samples)
    return digest.hexdigest()


def decode_dwell(
    text: str | bytes, samples: bytes | None, sha256: str, units: Callable[[], Mapping[str, str]] = dict
) -> DwellRecord:
    """Return a stored dwell as a record; without ``samples`` its readings are empty.

    ``units``: of the channels of the rig, asked for where the dwell states none itself, as in journals of version 0.1.

    Raises: JournalError.
    """
    try:
        document: dict[str, Any] = json.loads(text)
        if not isinstance(document, dict):
            raise ValueError("it is no object")
        stated = document.pop("units", None)
        readings = _readings(document.pop("readings"), samples, units() if stated is None else stated)
        for key in ("started_utc", "ended_utc"):
            document[key] = datetime.fromisoformat(document[key])
        document["reasons"] = tuple(document["reasons"])
        if "motion" in document:
            document["motion"] = _motion(document["motion"])
        return DwellRecord(**document, readings=readings, sha256=sha256)
    except (ValueError, TypeError, KeyError) as error:
        raise JournalError(f"a dwell of the journal cannot be read: {error}") from None


def channels_of(text: str | bytes) -> list[tuple[str, int]]:
    """Return every channel of a stored dwell with the number of its samples, in the order in which they lie."""
    return [(channel, count) for channel, count, _, _ in json.loads(text)["readings"]]


def _motion(document: dict[str, Any]) -> MotionRecord:
    document.pop(_OF_THE_PLAN, None)
    return MotionRecord(**{**document, "streams": tuple(StreamTiming(**stream) for stream in document["streams"])})


def _readings(layout: list[list[Any]], samples: bytes | None, units: Mapping[str, str]) -> dict[str, ChannelReading]:
    if samples is None:
        return {}
    values = np.frombuffer(samples, dtype=FLOAT)
    announced = sum(count for _, count, _, _ in layout)
    if announced != values.size:
        raise ValueError(f"{values.size} samples, but {announced} are announced")
    found, first = {}, 0
    for channel, count, started_s, interval_s in layout:
        unit = units.get(channel) or _UNITS_OF_COLUMNS.get(channel.rpartition(".")[2], VOLTS)
        found[channel] = ChannelReading(channel, values[first : first + count], started_s, interval_s, unit)
        first += count
    return found


def with_sha256(record: DwellRecord, sha256: str) -> DwellRecord:
    return replace(record, sha256=sha256)


def hash_event(previous: str, sequence: int, utc: str, monotonic_s: float, kind: str, detail: str) -> str:
    """Return SHA-256 of an event in its chain."""
    line = compact_json([previous, sequence, utc, monotonic_s, kind, detail])
    return hashlib.sha256(line.encode("utf-8")).hexdigest()


def is_event_whole(
    previous: str, sequence: int, utc: str, monotonic_s: float, kind: str, detail: str, sha256: str
) -> bool:
    """Return whether a stored event is as it was written, behind one of which ``previous`` is stored."""
    try:
        return hash_event(previous, sequence, utc, monotonic_s, kind, detail) == sha256
    except (TypeError, ValueError):  # a column of it is no text and no number any more
        return False


def decode_event(sequence: int, utc: str, monotonic_s: float, kind: str, detail: str, sha256: str) -> Event:
    content: Mapping[str, object] = json.loads(detail)
    return Event(sequence, datetime.fromisoformat(utc), monotonic_s, kind, content, sha256)
