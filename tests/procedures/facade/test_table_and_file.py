"""A table that pandas read and the file that it read are one: the same document, or the same refusal."""

from collections.abc import Callable
from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from cr_outputs import (
    TABLE_3_MODEL,
    TABLE_3_STING,
    write_gyros,
    write_package,
    write_rows,
)

from ams.errors import ObservationsError
from ams.models.registry import names_by_option

ROOT = Path(__file__).parents[3]
SPREAD_DEG = [(p, y, r) for p in (-40.0, 5.0, 30.0) for y in (-20.0, 0.0, 25.0) for r in (-60.0, 0.0, 45.0)]
FILE = Path("table")
LEVELS_UT = (-60.0, -30.0, 0.0, 30.0, 60.0)


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def attitudes(file: Path) -> Path:
    file.write_bytes((ROOT / "examples" / "observations.csv").read_bytes())
    return file


def tilt(file: Path) -> Path:
    pitch_deg = [float(pitch) for pitch in range(-60, 61, 20)]
    rows = [
        [
            replication,
            point,
            pitch,
            0.005 + 2.5 * np.sin(np.radians(pitch + 0.2)) + 1e-6 * ((5 * replication + point) % 7),
        ]
        for replication in (1, 2, 3)
        for point, pitch in enumerate(pitch_deg, 1)
    ]
    return write_rows(file, ["pitch_deg", "sx_v"], rows)


def rail(file: Path) -> Path:
    """Known levels of each axis in turn: the cells of the two others are empty in every row."""
    lines = ["replication,point,time_s,reference_x_ut,mx_counts,reference_y_ut,my_counts,reference_z_ut,mz_counts"]
    for replication in (1, 2, 3):
        for index in range(3 * len(LEVELS_UT)):
            axis, level = divmod(index, len(LEVELS_UT))
            cells = ["", "4.25", "", "10.05", "", "-7.5"]
            scatter = ((7 * (index + replication)) % 11 - 5) / 50.0
            cells[2 * axis : 2 * axis + 2] = [repr(LEVELS_UT[level]), repr(29.86 * LEVELS_UT[level] + scatter)]
            lines.append(",".join([str(replication), str(index + 1), str(30 * len(lines)), *cells]))
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def gyros(file: Path) -> Path:
    return write_gyros(file, np.array(SPREAD_DEG), np.random.default_rng(1).uniform(-60.0, 60.0, (len(SPREAD_DEG), 3)))


FILES: dict[tuple[str, str], tuple[Callable[[Path], Path], str]] = {
    ("pitch-roll", ""): (attitudes, "s{}_v"),
    ("pitch-only", ""): (tilt, "s{}_v"),
    ("pitch-yaw-roll", "sting"): (lambda file: write_package(file, "sting", TABLE_3_STING, SPREAD_DEG), "{}_v"),
    ("pitch-yaw-roll", "model"): (lambda file: write_package(file, "model", TABLE_3_MODEL, SPREAD_DEG), "{}_v"),
    ("gyro", ""): (gyros, "{}_v"),
    ("linear", ""): (rail, "m{}_counts"),
}
"""Model and package to what writes its file, and to the names of its columns."""


def answer(observations: Path | pd.DataFrame, case: tuple[str, str]) -> str:
    """Return the document, or what it is refused for; the file is called as a table is, so that sentences agree."""
    axes = {axis: FILES[case][1].format(axis) for axis in ("x" if case[0] == "pitch-only" else "xyz")}
    try:
        return repr(calrig.fit(observations, axes, model=case[0], package=case[1] or None).document)  # type: ignore[arg-type]
    except ObservationsError as error:
        return str(error)


def read(file: Path) -> pd.DataFrame:
    return pd.read_csv(file)


def test_every_model_that_is_offered_is_asked_here() -> None:
    assert {model for model, _ in FILES} == set(names_by_option())


@pytest.mark.parametrize("case", list(FILES), ids=" ".join)
def test_a_table_gives_the_document_of_its_file(case: tuple[str, str]) -> None:
    file = FILES[case][0](FILE)
    assert answer(file, case).startswith("{")
    assert answer(read(file), case) == answer(file, case)


@pytest.mark.parametrize("case", list(FILES), ids=" ".join)
def test_an_empty_cell_of_any_column_is_taken_or_refused_as_in_the_file(case: tuple[str, str]) -> None:
    lines = FILES[case][0](FILE).read_text(encoding="utf-8").splitlines()
    refused = 0
    for column in range(len(lines[0].split(","))):
        cells = lines[2].split(",")
        cells[column] = ""
        FILE.write_text("\n".join([*lines[:2], ",".join(cells), *lines[3:]]) + "\n", encoding="utf-8")
        expected = answer(FILE, case)
        refused += "the cell is empty" in expected
        assert answer(read(FILE), case) == expected
    assert refused >= 3


def test_a_line_of_commas_alone_is_no_row() -> None:
    lines = attitudes(FILE).read_text(encoding="utf-8").splitlines()
    FILE.write_text("\n".join([*lines, "," * lines[0].count(",")]) + "\n", encoding="utf-8")
    assert answer(read(FILE), ("pitch-roll", "")) == answer(FILE, ("pitch-roll", ""))


@pytest.mark.parametrize("nothing", [None, np.nan, pd.NA, pd.NaT])
def test_every_kind_of_nothing_is_an_empty_cell(nothing: object) -> None:
    table = read(rail(FILE))
    changed = table.astype(object).where(table.notna(), nothing)
    assert answer(changed, ("linear", "")) == answer(table, ("linear", ""))
