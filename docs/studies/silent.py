"""What the intervals hold where a belief about table, sensor, dwell or use is false, and whether a finding says so.

    PYTHONPATH=tests/support python docs/studies/silent.py run RESULTS.jsonl [SCENE …]
    PYTHONPATH=tests/support python docs/studies/silent.py page RESULTS.jsonl docs/studies/silent.md

Every cell is one line of JSON, written when it is done; what stands in the file already is not computed again, so that
a run that was broken off goes on where it stopped. A cell that is outside and told by nobody is computed once more from
4 000 fresh seeds, and that number counts. Scenes are those of ``tests/support/physics_scenes``.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from silent_cells import Line, verdict
from silent_judges import judge_of
from silent_page import page
from silent_scenes import CAMPAIGNS, Cell, cells

SEED = 1100
FRESH, FRESH_SEED, PART = 4000, 7_000_000, 400


def computed(cell: Cell, count: int, seed: int) -> Line:
    """Return a cell over ``count`` campaigns, drawn in parts of 400 with a seed each."""
    judge = judge_of(cell.scene, cell.design)
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


if __name__ == "__main__":
    if sys.argv[1] == "run":
        run(Path(sys.argv[2]), sys.argv[3:])
    else:
        Path(sys.argv[3]).write_text("".join(page(read(Path(sys.argv[2])))), encoding="utf-8")
