"""What the intervals hold where a belief about table, sensor, dwell or use is false, and whether a finding says so.

    PYTHONPATH=tests/support python docs/studies/silent.py run RESULTS.jsonl [SCENE …]
    PYTHONPATH=tests/support python docs/studies/silent.py page RESULTS.jsonl docs/studies/silent.md

Every cell is one line of JSON, written when it is done; what stands in the file already is not computed again, so that
a run that was broken off goes on where it stopped. A cell that is outside and told by nobody is computed once more from
4 000 fresh seeds, and that number counts. Scenes are those of ``tests/support/physics_scenes``.
"""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from physics_scenes import SCENES
from silent_judges import judge_of

CAMPAIGNS, SEED = 400, 1100
FRESH, FRESH_SEED, PART = 4000, 7_000_000, 400
LEAST, MOST, NAMED = 0.93, 0.97, 0.95
Line = dict[str, Any]


@dataclass(frozen=True)
class Cell:
    """One scene at one size in one design."""

    scene: str
    size: float
    design: Mapping[str, float] = field(default_factory=dict)

    @property
    def key(self) -> str:
        return json.dumps([self.scene, self.size, dict(self.design)])


TABLES = (
    "table-once", "table-twice", "table-harmonics", "table-teeth", "table-worm", "table-smooth-and-teeth",
    "table-once-zeroed", "table-harmonics-zeroed",
)  # fmt: skip
TABLE_SIZES, LIMITS_DEG = (0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0), (30.0, 60.0, 90.0)
REQUIRED = (
    "clean", "wrong-dwell", "outliers", "outlier-share", "soft-mount", "k2", "k3", "cross-coupling", "k0-asymmetry",
    "k1-asymmetry", "temperature-in-step", "table-wrong-zero", "table-base-tilt", "use-good", "use-dead-axis",
    "use-clipped-z", "use-all-high", "use-site-gravity", "field-coned", "temperature-lag", "temperature-curvature",
    "slip-roll", "slip-pitch", "meter-gain", "two-packages-good", "two-packages-dead-axis",
)  # fmt: skip
FURTHER = (
    "drift-linear", "drift-replications", "drift-sensitivity", "drift-correlated", "temperature-gradient",
    "cross-product", "hysteresis", "table-orthogonality", "wrong-tooth", "swapped-channel", "repeated-reading",
    "drift-step", "drift-warm-up", "drift-in-pitch-order", "field-cross", "field-undeclared", "field-coil-direction",
    "field-coil-current", "temperature-alternating", "temperature-room", "temperature-stratified", "quantisation",
    "temperature-self-heating", "use-shifted-offset", "use-stuck-axis", "use-reversed", "use-swapped",
    "slip-base-sideways", "sensor-offset", "fixture-play", "temperature-daily", "drift-walk", "drift-settling",
)  # fmt: skip
FEWER: Mapping[str, tuple[float, ...]] = {
    "slip-roll": (0.0, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "slip-pitch": (0.0, 2.0, 5.0, 72.0),
    "meter-gain": (2.0, 10.0, 20.0, 200.0),
    "slip-base-sideways": (2.0, 5.0, 72.0),
    "sensor-offset": (0.5, 2.0, 72.0),
    "fixture-play": (0.5, 2.0, 72.0),
}
"""Of the sizes of a scene, where a campaign of three sensors takes long."""
DECLARED: Mapping[str, tuple[float, ...]] = {"table-wrong-zero": (0.5, 1.0), "table-base-tilt": (0.5, 1.0)}
"""Sizes at which level and zero are declared with limits of ±1″ as well."""
USED: Mapping[str, tuple[float, ...]] = {"temperature-room": (0.1, 1.0)}
"""Sizes at which use within ±2 °C of the calibration is declared as well, with the sensor's largest coefficients."""
ALONE: Mapping[str, float] = {"sensors": 1, "reference_every": 0, "check_set": 0}
"""One package, and no reference visit: what its own dwells tell of a table that slips."""
BY_ITSELF: Mapping[str, tuple[float, ...]] = {
    "slip-roll": (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "slip-pitch": (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "slip-base": (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0),
    "meter-gain": (2.0, 10.0, 20.0, 200.0),
    "sensor-offset": (0.5, 1.0, 2.0, 5.0, 72.0),
}
AT_30 = ("soft-mount", "k2", "k3", "cross-coupling", "k0-asymmetry")


def cells() -> Iterator[Cell]:
    """Yield all cells: thinned out first, so that a part of them has every scene at its threshold."""
    thinned = [
        *_of_tables((1.0, 1.5)),
        *(Cell(scene, size, {"declared_arcsec": 1.0}) for scene, sizes in DECLARED.items() for size in sizes),
        *(Cell(scene, size, {"declared_degc": 2.0}) for scene, sizes in USED.items() for size in sizes),
        *(cell for scene in (*REQUIRED, *FURTHER) for cell in _thinned(_of_scene_alone(scene))),
        *(cell for scene in AT_30 for cell in _thinned(_at_30(scene))),
        *(Cell(scene, size, ALONE) for scene, sizes in BY_ITSELF.items() for size in sizes),
        *_of_tables((2.0, 0.5)),
    ]
    whole = [
        *(cell for scene in (*REQUIRED, *FURTHER) for cell in _of_scene_alone(scene)),
        *(cell for scene in AT_30 for cell in _at_30(scene)),
        *_of_tables(TABLE_SIZES),
    ]
    yield from {cell.key: cell for cell in (*thinned, *whole)}.values()


def _thinned(every: Sequence[Cell]) -> Sequence[Cell]:
    """Return the cells of nothing, of about the threshold and of the obvious."""
    return [every[index] for index in sorted({0, len(every) // 2 - 1, len(every) // 2, len(every) - 1}) if index >= 0]


def _of_scene_alone(scene: str) -> Sequence[Cell]:
    return [Cell(scene, size) for size in FEWER.get(scene, SCENES[scene].sizes)]


def _at_30(scene: str) -> Sequence[Cell]:
    return [Cell(scene, size, {"pitch_limit_deg": 30.0}) for size in SCENES[scene].sizes]


def _of_tables(sizes: Sequence[float]) -> Iterator[Cell]:
    for size in sizes:
        yield from (Cell(scene, size, {"pitch_limit_deg": limit}) for scene in TABLES for limit in LIMITS_DEG)


def computed(cell: Cell, count: int, seed: int) -> Line:
    """Return a cell over ``count`` campaigns, drawn in parts of 400 with a seed each."""
    judge = judge_of(cell.scene)
    parts = [
        judge(cell.scene, cell.size, min(PART, count), seed + part, cell.design) for part in range(-(-count // PART))
    ]
    return {
        **asdict(cell),
        "count": count,
        "after": _mean([part.after for part in parts]),
        "before": _mean([part.before for part in parts]),
        **_mean([{"named": part.named, "rings": part.rings, "half": part.half_width_arcsec} for part in parts]),
    }


def _mean(parts: Sequence[Mapping[str, float | None]]) -> dict[str, float | None]:
    known = {name: [part[name] for part in parts if part.get(name) is not None] for part in parts for name in part}
    return {name: sum(each) / len(each) if each else None for name, each in known.items()}  # type: ignore[arg-type]


def run(results: Path, scenes: Sequence[str]) -> None:
    """Compute what is not there yet: every cell over 400 campaigns, then those that are outside over 4 000."""
    chosen = [cell for cell in cells() if not scenes or cell.scene in scenes]
    there = read(results)
    for count, seed in ((CAMPAIGNS, SEED), (FRESH, FRESH_SEED)):
        for cell in chosen:
            is_due = count == CAMPAIGNS or verdict(there[cell.key]) == "outside"
            if (cell.key, count) in _done(there) or not is_due:
                continue
            line = computed(cell, count, seed)
            with results.open("a", encoding="utf-8") as file:
                file.write(json.dumps(line) + "\n")
            there = read(results)


def read(results: Path) -> dict[str, Line]:
    """Return the lines by cell; the one of the most campaigns counts."""
    found: dict[str, Line] = {}
    for text in results.read_text(encoding="utf-8").splitlines() if results.exists() else ():
        line = json.loads(text)
        key = Cell(line["scene"], line["size"], line["design"]).key
        if key not in found or line["count"] >= found[key]["count"]:
            found[key] = line
    return found


def _done(there: Mapping[str, Line]) -> set[tuple[str, int]]:
    return {(key, count) for key, line in there.items() for count in (CAMPAIGNS, FRESH) if line["count"] >= count}


def verdict(line: Line) -> str:
    """Return held, wide, told or outside."""
    shares = [line["after"][name] for name in ("offset", "k", "prediction", "angle") if name in line["after"]]
    if min(shares, default=0.0) >= LEAST:
        return "wide" if max(shares) > MOST else "held"
    return "told" if line["named"] is not None and line["named"] >= NAMED else "outside"


HEAD = """# What the intervals hold, and what is silent

Made by `PYTHONPATH=tests/support python docs/studies/silent.py run RESULTS.jsonl` and `… page RESULTS.jsonl
docs/studies/silent.md`: {cells} of the {every} cells that the script has, {campaigns} campaigns each; {fresh}
of those outside are counted over 4 000 fresh seeds instead. Scenes from physics
(`tests/support/physics_scenes`), unless said 13 × 12 points to ±90°, six replications, 1.65″ a dwell, three axes.

*After*: what calrig does by default: terms of second and third order in estimate and covariance, index errors of
unknown shape, what the recorded temperature did, every test of the findings. *Before*: a linear sensor, on a table of
independent teeth, no temperature, no findings, no flags. In scenes of the table ±1″ is declared for both axes (a zero
at index 0 where the scene is zeroed) and of its level nothing, but in rows called *declared*: there [level] and the
zeros are declared within ±1″; in scenes of temperature, use within ±2 °C of the calibration is declared, with the
sensor's largest coefficients. Rows called *alone* have one package and no reference visit, the others of a change in
mid-run three on one fixture. In all others the table is exact and nothing of it is declared. *b*, *k*, *prediction*,
*angle*: shares of 95 % intervals that hold the offset and the sensitivities of the best linear sensor over the design,
the output at attitudes all over the range, the inferred angles of rows that nothing flags. *Named*: share of the
campaigns in which a significant finding of some axis names the cause or says the same of the same data; of the table
only a finding that names the table counts; in use, campaigns in which a row in twenty or more is flagged. *Rings*:
anything significant on any axis; where nothing is wrong in 0.05 of the campaigns, whether they have three axes or nine,
and in 0.02 under a table's certificate.

*Held*: every share from 0.93 to 0.97. *Wide*: none below, some above. *Told*: below, and the cause named in 95 %.
**Outside**: below, and not told. Of {cells} cells {held} are held, {wide} wide, {told} told and **{outside} outside**.
Lag and curvature of temperature are also in [findings](findings.md). Not here: gyros, the joint fit, a partial check
set, and two faults at once.

## What falls outside

Near its threshold a fault hurts before a test at 5 % over all tests of a run can see it.

{outside_lines}"""
OLDER = """
† {older} cells, computed when every axis had the whole level by itself: their intervals are as they would be now, since
nothing of the estimate has changed for them, but *named* and *rings* are those of a test at three times the level.

‡ {searched} cells, computed since changes in mid-run and transients are looked for and the axes of a magnetometer are
held against each other; elsewhere *named* and *rings* lack that.
"""
WHY: Mapping[str, str] = {
    "table-": "one and a half times the declared limit: curves within the limit and noise come close to it",
    "table-wrong-zero": "no curve: held where it is declared; left out, set and certificate carry `level-undeclared`",
    "table-orthogonality": "near level it looks like K_po, which is told instead",
    "table-base-tilt": "no curve: held where it is declared; left out, set and certificate carry `level-undeclared`",
    "table-harmonics": "each of eight waves is well within the limit at twice the limit of all together",
    "k0-asymmetry": "a step at no acceleration is no term of a set: no covariance of its terms can hold it",
    "k1-asymmetry": "a kink at no acceleration is no term of a set: no covariance of its terms can hold it",
    "temperature-in-step": "its slopes are known from what the attitudes leave of it, a share of what it did",
    "temperature-curvature": "named from twice that size on; a term for it would widen a clean offset 1.7 times",
    "temperature-gradient": "it turns with the package and has another form than the terms of a set",
    "quantisation": "steps of 25 times the noise give every replication the same error",
    "temperature-room": "a constant difference is in no residual: held where the range of use is declared",
    "temperature-stratified": "nobody recorded it: along x a sensitivity, and terms that ring as the sensor's own",
    "use-": "a loss of p of the signal moves |f|² by 2pf², the angle by pf: rows near level are not flagged",
    "use-site-gravity": "two parts in a hundred thousand of |f| are within what a reading of 1.65″ allows",
    "two-packages": "the y axis of the sting package is a yaw, of which the model package tells nothing",
    "drift-settling": "below its threshold; it stays in the estimate",
    "slip-": "below the threshold of the search between all dwells (‡), or of two attitudes visited (without ‡)",
    "meter-": "below the threshold of the search between all dwells (‡), or of two attitudes visited (without ‡)",
    "sensor-": "below the threshold of the search between all dwells (‡), or of two attitudes visited (without ‡)",
    "field-": "below the threshold of the test of all axes together: each bends to the field that it is told of",
    "drift-in-pitch-order": "time and pitch are the same: the plan is told, not the data",
}
SCENE = """
## {name}

{physics}

| size, {unit} | pitch, ±° | {shares} | before: {shares} | named | rings | verdict |
|---|---|{rules}|---|---|---|
"""
NAMES = {"offset": "b", "k": "k", "prediction": "prediction", "angle": "angle", "flagged": "rows flagged"}


def page(lines: Mapping[str, Line]) -> Iterator[str]:
    """Yield the page, piece by piece."""
    verdicts = {key: verdict(line) for key, line in lines.items()}
    count = {
        word: sum(verdict == word for verdict in verdicts.values()) for word in ("held", "wide", "told", "outside")
    }
    fresh = sum(line["count"] > CAMPAIGNS for line in lines.values())
    outside = "".join(
        _outside(scene, [lines[key] for key in keys]) for scene, keys in _by_scene(verdicts, lines).items()
    )
    yield HEAD.format(
        every=sum(1 for _ in cells()),
        cells=len(lines),
        campaigns=CAMPAIGNS,
        fresh=fresh or "none",
        outside_lines=outside,
        **count,
    )
    older = sum(bool(line.get("older")) for line in lines.values())
    if older:
        yield OLDER.format(older=older, searched=sum(bool(line.get("searched")) for line in lines.values()))
    for scene in dict.fromkeys((*REQUIRED, *TABLES, *FURTHER, *BY_ITSELF)):
        rows = [lines[cell.key] for cell in cells() if cell.scene == scene and cell.key in lines]
        if rows:
            yield from _of_scene(scene, rows)


def _by_scene(verdicts: Mapping[str, str], lines: Mapping[str, Line]) -> Mapping[str, list[str]]:
    found: dict[str, list[str]] = {}
    for key, word in verdicts.items():
        if word == "outside":
            found.setdefault(lines[key]["scene"], []).append(key)
    return found


def _outside(scene: str, rows: Sequence[Line]) -> str:
    sizes = ", ".join(f"{size:g}" for size in sorted({row["size"] for row in rows}))
    why = next((WHY[start] for start in sorted(WHY, key=len, reverse=True) if scene.startswith(start)), "")
    return f"- **{scene}** at {sizes} {SCENES[scene].unit}{': ' + why if why else ''}.\n"


def _of_scene(scene: str, rows: Sequence[Line]) -> Iterator[str]:
    entry, names = SCENES[scene], [name for name in NAMES if any(name in row["after"] for row in rows)]
    earlier = [name for name in names if any(name in row["before"] for row in rows)]
    head = SCENE.replace("before: {shares}", "{before}")
    yield head.format(
        name=scene,
        physics=entry.physics.strip().split("\n")[0],
        unit=entry.unit,
        shares=" | ".join(NAMES[name] for name in names),
        before=" | ".join(f"before: {NAMES[name]}" for name in earlier),
        rules="|".join(["---"] * (len(names) + len(earlier))),
    )
    for row in sorted(rows, key=lambda row: (row["design"].get("pitch_limit_deg", 90.0), row["size"])):
        shares = [row["after"].get(name) for name in names] + [row["before"].get(name) for name in earlier]
        figures = [*shares, row["named"], row["rings"]]
        word = verdict(row)
        text = (f"**{word}**" if word == "outside" else word) + (" †" if row.get("older") else "")
        text += " ‡" if row.get("searched") else ""
        fresh = ", 4 000 fresh" if row["count"] > CAMPAIGNS else ""
        limit = row["design"].get("pitch_limit_deg", _limit_of(scene))
        declared = ", declared" if any(name.startswith("declared") for name in row["design"]) else ""
        declared += ", alone" if "sensors" in row["design"] else ""
        yield f"| {row['size']:g}{declared} | {limit:g} | {' | '.join(map(_figure, figures))} | {text}{fresh} |\n"


def _limit_of(scene: str) -> float:
    return 60.0 if scene.startswith("use-") else 30.0 if scene.startswith("two-packages") else 90.0


def _figure(share: float | None) -> str:
    return "—" if share is None else f"{share:.3f}"


if __name__ == "__main__":
    if sys.argv[1] == "run":
        run(Path(sys.argv[2]), sys.argv[3:])
    else:
        Path(sys.argv[3]).write_text("".join(page(read(Path(sys.argv[2])))), encoding="utf-8")
