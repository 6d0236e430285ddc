"""An archive of ten thousand sets: how long a list and a sensor's history take, as the functions and as commands.

The sets are one set's document under ten thousand checksums: listing and charting read rows, not documents. A history
is taken of an archive ten times as large too, whose sets but one have no document at all: it must not grow with it.
"""

import hashlib
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ams.archive.connection import writing
from ams.archive.histories import history
from ams.archive.sets import list_sets, publish
from ams.archive.synthetic import Story, synthetic_archive
from ams.exports.json_text import from_json
from ams.surveillance.characteristics import PackageNumbers
from ams.surveillance.history_points import pack
from ams.surveillance.series import PointLabel, Population
from bench.figure import Effort, Figure

SET_FILE = Path(__file__).parents[1] / "tests" / "data" / "coefficient_set_v1.json"
CALRIG = Path(sys.executable).with_name("calrig")
STORY, LARGE, TINY = Story(sensors=249, years=20), Story(sensors=2499, years=20), Story(sensors=8, years=4)


def figures(effort: Effort) -> Iterator[Figure]:
    """Seconds of list and history over 10 000 sets, and of a history over 100 000."""
    with TemporaryDirectory() as folder:
        url = f"sqlite:///{folder}/archive.sqlite"
        made = synthetic_archive(np.random.default_rng(1), effort.amount(STORY, TINY))
        population, sensor = made.population, made.sound[-1]
        fill(url, population, sensor)
        count = len(list_sets(url))
        assert count == len(population.labels)
        yield Figure(f"list of {count} sets", effort.best_s(lambda: list_sets(url)), "s", 0.2, at_most=True)
        seconds = effort.best_s(lambda: history(url, sensor))
        yield Figure(f"history of one sensor of {count} sets", seconds, "s", 0.05, at_most=True)
        for name, command in {
            "  calrig archive list --sensor": ["list", "--sensor", sensor],
            "  calrig archive history": ["history", sensor],
        }.items():
            whole = [str(CALRIG), "archive", *command, "--archive", url]
            yield Figure(name, _process_s(effort, whole), "s", 1.5, at_most=True, note="a whole process")
    with TemporaryDirectory() as folder:
        url = f"sqlite:///{folder}/archive.sqlite"
        made = synthetic_archive(np.random.default_rng(1), effort.amount(LARGE, TINY))
        fill(url, made.population, made.sound[-1], document="")
        seconds = effort.best_s(lambda: history(url, made.sound[-1]))
        yield Figure(f"history of one sensor of {len(made.population.labels)} sets", seconds, "s", 0.1, at_most=True)


def _process_s(effort: Effort, command: list[str]) -> float:
    return effort.best_s(lambda: subprocess.run(command, check=True, capture_output=True), least_total_s=0.0, repeats=3)


def fill(url: str, population: Population, sensor: str, document: str | None = None) -> None:
    """One row a calibration, as publishing would write them; the last one of ``sensor`` keeps the set's checksum.

    ``document``: of all the others, instead of the set's.
    """
    from sqlalchemy import insert, select

    from ams.archive.tables import COEFFICIENTS, POINTS, SETS, VERDICTS

    first = from_json(SET_FILE.read_bytes(), str(SET_FILE))
    publish(url, [first], first.created_utc)
    with writing(url, 10.0) as connection:
        row = dict(connection.execute(select(SETS)).mappings().one())
        point = dict(connection.execute(select(POINTS)).mappings().one())
        for table in (COEFFICIENTS, POINTS, VERDICTS, SETS):
            connection.execute(table.delete())
        kept = population.rows_of(sensor).stop - 1
        names = [hashlib.sha256(str(index).encode()).hexdigest() for index in range(len(population.labels))]
        names[kept] = first.sha256
        rows = list(zip(names, population.labels, strict=True))
        other = row if document is None else {**row, "document": document}
        sets = [_set_row(row if name == first.sha256 else other, name, label) for name, label in rows]
        connection.execute(insert(SETS), sets)
        connection.execute(insert(VERDICTS), [{"sha256": name, "verdict": "usable"} for name in names])
        connection.execute(
            insert(POINTS),
            [
                {
                    **point,
                    "sha256": name,
                    "check_sensor": label.is_check,
                    "numbers": pack(_numbers_of(population, index)),
                }
                for index, (name, label) in enumerate(rows)
            ],
        )


def _set_row(template: Mapping[str, Any], sha256: str, label: PointLabel) -> dict[str, Any]:
    when = {"created_utc": label.created_utc, "published_utc": label.created_utc + timedelta(hours=1)}
    return {**template, "sha256": sha256, "sensor": label.sensor, "run_id": label.run_id, **when}


def _numbers_of(population: Population, index: int) -> PackageNumbers:
    numbers, rows = population.numbers, slice(index, index + 1)
    columns = {name: getattr(numbers, name)[rows] for name in ("primary", "covariance", "scatter")}
    return replace(numbers, **columns)
