"""The page of the study of silent scenes, made of the lines of its cells."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from physics_scenes import SCENES
from silent_best import best_power
from silent_cells import Line, shares_of, verdict
from silent_declared import JOINT, KEYS, in_words, keys_of, plan_in_words
from silent_scenes import BY_ITSELF, CAMPAIGNS, FURTHER, REQUIRED, TABLES, Cell, cells

HEAD = """# What the intervals hold, and what is silent

Made by `PYTHONPATH=tests/support python docs/studies/silent.py run RESULTS.jsonl` and `… page RESULTS.jsonl
docs/studies/silent.md`: {cells} of the {every} cells that the script has, {campaigns} campaigns each; {fresh}
of those outside are counted over 4 000 fresh seeds instead. Scenes from physics
(`tests/support/physics_scenes`), unless said 13 × 12 points to ±90°, six replications, 1.65″ a dwell, three axes.

*After*: what calrig does by default: terms of second and third order in estimate and covariance, index errors of
unknown shape, what the recorded temperature did, every test of the findings. *Before*: a linear sensor, on a table of
independent teeth, no temperature, no findings, no flags. In scenes of the table its indices are declared within ±1″
for both axes (with a zero at index 0 where the scene is zeroed); in all others the table is exact. Nothing else is
declared, but in rows that say what: there the laboratory has declared that limit as well, by the keys listed below.
Rows called *alone* have one package and no reference visit, the others of a change in mid-run three on one fixture.

*b*, *k*, *prediction*, *angle*: shares of 95 % intervals that hold the offset and the sensitivities of the best linear
sensor over the design, the output at attitudes all over the range, the inferred angles of rows that nothing flags.
*Named*: share of the campaigns in which a significant finding of some axis names the cause or says the same of the
same data; of the table only a finding that names the table counts; in use, campaigns in which a row in twenty or more
is flagged. *Rings*: anything significant on any axis; where nothing is wrong in 0.05 of the campaigns, whether they
have three axes or nine, and in 0.02 under a table's certificate.

*Held*: every share from 0.93 to 0.97. *Wide*: none below, some above. *Told*: below, and the cause named in 95 %.
**Outside**: below, and not told. Of {cells} cells {held} are held, {wide} wide, {told} told and **{outside} outside**.
Lag and curvature of temperature are also in [findings](findings.md), gyros in [gyros](gyros.md). Not here: two
faults at once. Rows called *joint fit* solve package and table together; *before*, as linear sensors with ±1.96 u. Rows
with three of six check dwells lost the link inside of the first check set, and visit nothing until the last.
"""
TWINS = """
## What has to be declared

Near its threshold a fault hurts before a test at 5 % over all tests of a run can see it, and some faults are in no
residual at all. The data cannot show them, so a limit is asked for. Every row is a scene of which nothing was declared
and which is **outside**, with what a limit of one to two times its size makes of it (a step K₀′ departs by half of
its size, either way). *Least*: the least of the shares
that hold. *Half-width*: of a prediction, or of an inferred angle in use, over that of the row without a limit. *Best
test*: how often a test at 5 % of one degree of freedom would see it that knows its form, its moment and its size in
every axis, beside free offsets and sensitivities; no test of real readings knows as much. What it sees of a layered
chamber has the form of the sensor's own second order, and calrig tells it as that where no thermometer parts them.

| scene | size | nothing declared: least | named | best test | declared | least | named | half-width | verdict |
|---|---|---|---|---|---|---|---|---|---|
{rows}
What declares it: {keys}.
"""
LEFT = """
## What falls outside

{outside_lines}"""
CURRENT = """
§ {current} cells, computed with the tests up to decision 66; those of decision 72 are looked for in its two scenes, and
clean campaigns ring as often with them (0.050 of 4 000); decision 74 names more of `after-pitch-moves`, `k0-asymmetry`,
`k3`, `temperature-curvature` and `meter-gain` near their thresholds than stands here; with decision 84 `k0-asymmetry`
over ±30° of 5 µg is named in 0.9995 of 4 000, so that of the cells below 66 are outside. The others have the tests of
earlier versions: nothing of the estimates has changed since, so their intervals are as they would be now, but *named*
and *rings* lack what is newer (decisions 48 to 66, as far as each is about the scene).{again}{tried}
With the tests up to decision 134, 39 cells drawn at random among the least size that is told and the largest that is
not, of every scene and design, were computed again over 160 campaigns: 37 have the verdict that stands here, the two
others lie at a limit (`use-all-high` of 0.005 %, `table-harmonics` of 3 arcsec over ±60°).
"""
TRIED = """ With the tests up to decision 75 {count} of the cells that were outside were computed once more: {told} of
them are told now; of the others *named* is what it was to within {most:.3f}, but for {but}."""
AGAIN = """ Of {both} cells both are known: {changed} has another verdict, and *named* differs by {most:.3f}
at most, in `{scene}` of {size:g} {unit}."""
WHY: Mapping[str, str] = {
    "table-": "one and a half times the declared limit: curves within the limit and noise come close to it",
    "table-wrong-zero": "no curve: held where it is declared; left out, set and certificate carry `level-undeclared`",
    "table-orthogonality": "near level it looks like K_po, which is told instead",
    "table-base-tilt": "no curve: held where it is declared; left out, set and certificate carry `level-undeclared`",
    "table-harmonics": "each of eight waves is well within the limit at twice the limit of all together",
    "k0-asymmetry": "a step at no acceleration is no term of a set: held where a nonlinearity is declared",
    "k1-asymmetry": "a kink at no acceleration is no term of a set: held where a nonlinearity is declared",
    "temperature-in-step": "its slopes are known from what the attitudes leave of it, a share of what it did",
    "temperature-curvature": "named from twice that size on; a term for it would widen a clean offset 1.7 times",
    "temperature-gradient": "of the form of K₂ and K_ip: it is taken for the sensor's own, and told as that once seen",
    "temperature-room": "a constant difference is in no residual: held where the range of use is declared",
    "temperature-stratified": "nobody recorded it: along x a sensitivity, and terms that ring as the sensor's own",
    "use-": "a loss of p of the signal moves |f|² by 2pf², the angle by pf: rows near level are not flagged",
    "use-site-gravity": "two parts in a hundred thousand of |f| are within what a reading of 1.65″ allows",
    "two-packages": "the y axis of the sting package is a yaw, of which the model package tells nothing",
    "drift-settling": "the same in every replication it is in the estimate, and below its threshold in no finding",
    "carry-over": "below its threshold it passes for a sensitivity, and no residual shows it",
    "after-pitch-moves": "below its threshold it passes for offset and sensitivities, and no residual shows it",
    "after-effect": "below its threshold it passes for sensitivities, and no residual shows it",
    "fixture-": "one sensor that turns in its fixture, below the threshold of the search between all dwells",
    "slip-": "below the threshold of the search between all dwells and of two attitudes visited",
    "meter-": "below the threshold of the search between all dwells and of two attitudes visited",
    "sensor-": "below the threshold of the search between all dwells and of two attitudes visited",
    "field-": "below the threshold of the test of all axes together: each bends to the field that it is told of",
    "drift-in-pitch-order": "time and pitch are the same: the plan is told, not the data",
}
SCENE = """
## {name}

{physics}

| size, {unit} | pitch, ±° | {shares} | before: {shares} | named | rings | verdict |
|---|---|{rules}|---|---|---|
"""
_FAR = 0.1
NAMES = {"offset": "b", "k": "k", "prediction": "prediction", "angle": "angle", "flagged": "rows flagged"}


def page(lines: Mapping[str, Line]) -> Iterator[str]:
    """Yield the page, piece by piece."""
    verdicts = {key: verdict(line) for key, line in lines.items()}
    count = {
        word: sum(verdict == word for verdict in verdicts.values()) for word in ("held", "wide", "told", "outside")
    }
    fresh = sum(line["count"] > CAMPAIGNS for line in lines.values())
    yield HEAD.format(
        every=sum(1 for _ in cells()), cells=len(lines), campaigns=CAMPAIGNS, fresh=fresh or "none", **count
    )
    outside = {key: lines[key] for key, word in verdicts.items() if word == "outside"}
    twins = {key: (outside[left], lines[key]) for key in lines if (left := _without(lines[key])) in outside}
    if twins:
        yield TWINS.format(
            rows="".join(map(_side_by_side, sorted(twins.values(), key=_in_order))),
            keys="; ".join(dict.fromkeys(keys_of(line["design"]) for _, line in twins.values())),
        )
    declared = {_without(line) for _, line in twins.values()}
    alone = [line for key, line in outside.items() if key not in declared]
    if alone:
        by_scene = dict.fromkeys(line["scene"] for line in alone)
        lists = (_outside(scene, [line for line in alone if line["scene"] == scene]) for scene in by_scene)
        yield LEFT.format(outside_lines="".join(lists))
    current = [line for line in lines.values() if line.get("current")]
    if len(current) < len(lines):
        yield CURRENT.format(current=len(current), again=_again(current), tried=_tried(lines.values()))
    for scene in dict.fromkeys((*REQUIRED, *TABLES, *FURTHER, *BY_ITSELF)):
        rows = [lines[cell.key] for cell in cells() if cell.scene == scene and cell.key in lines]
        if rows:
            yield from _of_scene(scene, rows)


def _tried(lines: Iterable[Line]) -> str:
    """Return what the newest tests make of cells that were outside; ``tried`` is what they name of it, and named."""
    tried = [line for line in lines if "tried" in line]
    if not tried:
        return ""
    left = [line for line in tried if verdict(line) == "outside" and line["named"] is not None]
    moved = {id(line): line["tried"]["now"] - line["tried"]["before"] for line in left}
    far = sorted((line for line in left if abs(moved[id(line)]) > _FAR), key=lambda line: -moved[id(line)])
    most = max((abs(by) for by in moved.values() if abs(by) <= _FAR), default=0.0)
    but = ", ".join(
        f"`{line['scene']}`{', alone' if 'sensors' in line['design'] else ''} of {line['size']:g} "
        f"{SCENES[line['scene']].unit} ({line['tried']['before']:.2f} to {line['tried']['now']:.2f})"
        for line in far
    )
    count = sum(verdict(line) == "told" for line in tried)
    return TRIED.format(count=len(tried), told=count, most=most, but=but or "none")


def _again(current: Sequence[Line]) -> str:
    """Return how far cells are from what tests of earlier versions said of them; ``earlier`` is their line of then."""
    both = [line for line in current if line.get("earlier") and line["named"] is not None]
    if not both:
        return ""
    most = max(both, key=_moved)
    changed = sum(verdict(line) != verdict(line["earlier"]) for line in both)
    scene, size = most["scene"], most["size"]
    words = "none" if changed == 0 else str(changed)
    unit = SCENES[scene].unit
    return AGAIN.format(both=len(both), changed=words, most=_moved(most), scene=scene, size=size, unit=unit)


def _moved(line: Line) -> float:
    return float(abs(line["named"] - line["earlier"]["named"]))


def _without(line: Line) -> str | None:
    """Return the cell of the same scene and design in which nothing is declared; None for such a cell itself."""
    left = {name: value for name, value in line["design"].items() if name not in KEYS}
    return None if len(left) == len(line["design"]) else Cell(line["scene"], line["size"], left).key


def _in_order(twin: tuple[Line, Line]) -> tuple[Any, ...]:
    scene, design = twin[0]["scene"], twin[0]["design"]
    return scene, design.get("pitch_limit_deg", 90.0), "sensors" in design, twin[0]["size"]


def _side_by_side(twin: tuple[Line, Line]) -> str:
    left, declared = twin
    before, after = (line.get("half") for line in twin)
    wider = f"× {after / before:.2g}" if before and after else "—"
    scene, design = left["scene"], left["design"]
    where = f", ±{design['pitch_limit_deg']:g}°" if "pitch_limit_deg" in design else ""
    where += ", alone" if "sensors" in design else ""
    where += f", {words}" if (words := plan_in_words(design)) else ""
    size = f"{left['size']:g} {SCENES[scene].unit}"
    best = _figure(best_power(scene, left["size"], design))
    figures = [_figure(min(shares_of(left))), _figure(left["named"]), best, in_words(declared["design"])]
    figures += [_figure(min(shares_of(declared))), _figure(declared["named"]), wider, verdict(declared)]
    return f"| {scene}{where} | {size} | {' | '.join(figures)} |\n"


def _outside(scene: str, rows: Sequence[Line]) -> str:
    sizes = ", ".join(f"{size:g}" for size in sorted({row["size"] for row in rows}))
    why = next((WHY[start] for start in sorted(WHY, key=len, reverse=True) if scene.startswith(start)), "")
    best = {row["size"]: best_power(scene, row["size"], row["design"]) for row in rows}
    could = ", ".join(_figure(share) for _, share in sorted(best.items()) if share is not None)
    words = (f": {why}" if why else "") + (f" (best test: {could})" if could else "")
    return f"- **{scene}** at {sizes} {SCENES[scene].unit}{words}.\n"


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
    for row in sorted(rows, key=_by_design):
        shares = [row["after"].get(name) for name in names] + [row["before"].get(name) for name in earlier]
        figures = [*shares, row["named"], row["rings"]]
        word = verdict(row)
        text = (f"**{word}**" if word == "outside" else word) + (" §" if row.get("current") else "")
        fresh = ", 4 000 fresh" if row["count"] > CAMPAIGNS else ""
        limit = row["design"].get("pitch_limit_deg", _limit_of(scene))
        declared = ", alone" if "sensors" in row["design"] else ""
        declared += f", {words}" if (words := plan_in_words(row["design"])) else ""
        declared += f", {words}" if (words := in_words(row["design"])) else ""
        yield f"| {row['size']:g}{declared} | {limit:g} | {' | '.join(map(_figure, figures))} | {text}{fresh} |\n"


def _by_design(row: Line) -> tuple[Any, ...]:
    design = row["design"]
    plan = JOINT in design, "check_before_count" in design
    return *plan, design.get("pitch_limit_deg", 90.0), "sensors" in design, row["size"], in_words(design)


def _limit_of(scene: str) -> float:
    return 60.0 if scene.startswith("use-") else 30.0 if scene.startswith("two-packages") else 90.0


def _figure(share: float | None) -> str:
    return "—" if share is None else f"{share:.3f}"
