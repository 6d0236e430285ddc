"""The tables of a run as one xarray dataset: what was read over (dwell, channel), and over (dwell, channel, sample)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray

from procedures.data.columns import DATA_VERSION, MOMENT, TABLES


def to_dataset(run: str, tables: Mapping[str, pd.DataFrame]) -> xarray.Dataset:
    """Return dwells and readings, and samples where they are among the tables; the audit trail has no such shape.

    A channel that several packages share stands once for each.
    """
    dwells, readings = tables["dwells"], tables["readings"]
    names = _channel_names(readings)
    channels = list(dict.fromkeys(names))
    first = readings.assign(name=names).drop_duplicates("name").set_index("name").reindex(channels)
    rows, columns = _positions(dwells, readings, names, channels)
    data: dict[str, Any] = {}
    for figure in ("mean", "sd", "n"):
        grid = np.full((len(dwells), len(channels)), np.nan)
        grid[rows, columns] = readings[figure]
        data[figure] = (("dwell", "channel"), grid)
    if "samples" in tables:
        data["value"] = (("dwell", "channel", "sample"), _samples(dwells, tables["samples"], channels))
    coordinates = {
        column.name: ("dwell", _plain(dwells[column.name], column.kind))
        for column in TABLES["dwells"]
        if column.name != "run"
    }
    of_channels = {name: ("channel", first[name].to_numpy(dtype=str)) for name in ("sensor", "axis", "unit")}
    return xarray.Dataset(
        data,
        {"dwell": dwells.index.to_numpy(), "channel": np.array(channels, dtype=str), **coordinates, **of_channels},
        {"run": run, "calrig_data_version": DATA_VERSION},
    )


def _channel_names(table: pd.DataFrame) -> list[str]:
    """Return the channel of every row; behind the sensor where the channel is that of several."""
    owners = table.groupby("channel")["sensor"].nunique()
    shared = set(owners[owners > 1].index)
    return [
        f"{sensor}:{channel}" if channel in shared else channel
        for sensor, channel in zip(table["sensor"], table["channel"], strict=True)
    ]


def _positions(dwells: pd.DataFrame, table: pd.DataFrame, names: list[str], channels: list[str]) -> tuple[Any, Any]:
    return dwells.index.get_indexer(table.index), pd.Index(channels).get_indexer(pd.Index(names))


def _samples(dwells: pd.DataFrame, samples: pd.DataFrame, channels: list[str]) -> Any:
    rows, columns = _positions(dwells, samples, _channel_names(samples), channels)
    grid = np.full((len(dwells), len(channels), int(samples["sample"].max()) + 1), np.nan)
    grid[rows, columns, samples["sample"]] = samples["value"]
    return grid


def _plain(values: pd.Series, kind: str) -> Any:
    if kind == MOMENT:
        return np.array([moment.isoformat(timespec="microseconds") for moment in values], dtype=str)
    return values.to_numpy(dtype=str if kind == "str" else None)
