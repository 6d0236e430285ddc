"""Runs of every kind that earlier versions stored are read, solved, resumed, verified and looked up, to their numbers.

``tests/data/make_stored_runs.py`` says how they were made. Nothing of them is ever written to: tests work on copies.
"""

import hashlib
import json
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields, replace
from pathlib import Path
from typing import Any

import pytest
from command import call
from small_run import Bench
from stored_runs import (
    BETWEEN_PROCESSORS,
    CASES,
    DATA,
    VERSIONS,
    StoredCase,
    hashes_of_data,
    header_of,
    is_of_uncertainty,
    moved,
    name_of,
)

from ams.solve import mixed_model
from procedures.delivery.deliver import SolvedRun, sensors_document, sets_of, solve_run
from procedures.journal.header import RunHeader
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.kinds.solve import solve_record
from procedures.plan.plan import Plan
from procedures.records.states import State
from procedures.run.resume import resume
from procedures.solution import lines
from rig.description.read import read_rig

EVERY = pytest.mark.parametrize("case", CASES, ids=name_of)
EVERY_VERSION = pytest.mark.parametrize("version", VERSIONS, ids=lambda version: version.name)
LINES = ("rates_linear", "tumble_up_down", "two_level")
"""Stored kinds that straight lines are drawn through, on a rig with a reference and a coil of stated uncertainty."""
GO_ON = tuple(f"runs_0_1_0-{kind}" for kind in ("grid", "rates_gyro", "rates_linear", "static", "tumble"))
"""Stored runs that go on in every change; CI has those of the others go on too."""
JOURNALS = sorted(DATA.rglob("journal.sqlite"))
EXPORTS = sorted(
    path
    for version in VERSIONS
    for folder in ("coefficients", "exports")
    for path in version.glob(f"*/finished/{folder}/*")
)


@pytest.fixture(scope="module", autouse=True)
def _nothing_stored_is_written_to() -> Iterator[None]:
    before = hashes_of_data()
    yield
    assert hashes_of_data() == before


def _solved(run: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(json.dumps(sensors_document(solve_run(run)), allow_nan=False))
    return document


def _solve_as_it_was(case: StoredCase, patch: pytest.MonkeyPatch) -> None:
    """Take the spread of two replications as it came out, and draw a magnetometer's lines along its nominal axes.

    So was done before the noise inside them was its least, and before all components of an axis were solved. What they
    are now is held against what was stored by ``test_what_noise_tells_of_two_replications_only_widens`` and
    ``test_a_stored_magnetometer_stays_what_it_was``.
    """
    patch.setattr(mixed_model, "no_less_than_noise", lambda spread, *_: spread)
    if case.folder.name == "two_level":
        patch.setattr(lines, "triad_of", lambda *_: {})


def _coefficients_moved(then: object, now: object) -> list[str]:
    return [found for found in moved(then, now, *BETWEEN_PROCESSORS) if not is_of_uncertainty(found.split(":")[0])]


def _uncertainties_moved(then: object, now: object) -> list[str]:
    """Return what moved; advice may be said in better words, the numbers that it is made from stand beside it."""
    text = [(entry.split(":")[0], entry) for entry in moved(then, now, *BETWEEN_PROCESSORS)]
    return [entry for path, entry in text if is_of_uncertainty(path) and "/advice/sentences/" not in path]


def test_every_kind_is_stored() -> None:
    kinds = {read_procedure(case.folder / "procedure.toml").procedure.kind for case in CASES}
    assert kinds == {"grid", "tumble", "rates", "profile", "two-level", "static"}


@EVERY
def test_a_stored_run_gives_its_coefficients(case: StoredCase, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = case.copy("finished", tmp_path / "run")
    journal = (run / "journal.sqlite").read_bytes()
    _solve_as_it_was(case, monkeypatch)
    now = _solved(run)
    assert _coefficients_moved(case.numbers, now) == []
    assert (run / "journal.sqlite").read_bytes() == journal


@EVERY
def test_a_stored_run_gives_its_uncertainties(
    case: StoredCase, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By itself, because a better budget may move an uncertainty and nothing may move a coefficient.

    Since straight lines take what their rig declares of attitudes and fields, those of ``LINES`` are what was stored
    where nothing is declared, and larger where it is.
    """
    run = case.copy("finished", tmp_path / "run")
    _solve_as_it_was(case, monkeypatch)
    now = _solved_with_nothing_declared(run) if case.folder.name in LINES else _solved(run)
    assert _uncertainties_moved(case.numbers, now) == []


@EVERY
def test_what_noise_tells_of_two_replications_only_widens(case: StoredCase, tmp_path: Path) -> None:
    now = _solved(case.copy("finished", tmp_path / "run"))
    stated = [] if case.folder.name == "two_level" else _standard_uncertainties(case.numbers)
    for path in stated:
        assert _at(now, path) >= _at(case.numbers, path) * (1.0 - 1e-9), path


@pytest.mark.parametrize("case", [case for case in CASES if case.folder.name == "two_level"], ids=name_of)
def test_a_stored_magnetometer_stays_what_it_was(case: StoredCase, tmp_path: Path) -> None:
    """With all components solved it moves by less than it was uncertain, and says how every axis lies."""
    now = _solved(case.copy("finished", tmp_path / "run"))
    assert list(_beyond_uncertainty(case.numbers, now)) == []
    for axis, section in now["MicroMag3"]["axes"].items():
        assert {f"towards_{other}_deg" for other in "xyz" if other != axis} <= section["parameters"].keys()


@pytest.mark.parametrize("case", [case for case in CASES if case.folder.name in LINES], ids=name_of)
def test_what_a_rig_declares_makes_a_line_less_certain(case: StoredCase, tmp_path: Path) -> None:
    run = case.copy("finished", tmp_path / "run")
    now, bare = _solved(run), _solved_with_nothing_declared(run)
    for path in _standard_uncertainties(bare):
        assert _at(now, path) >= _at(bare, path) * (1.0 - 1e-12), path


def _solved_with_nothing_declared(run: Path) -> dict[str, Any]:
    solved = solve_run(run)
    rig = solved.record.rig
    fields_of = {name: coil.model_copy(update={"uncertainty_ut": 0.0}) for name, coil in rig.field.items()}
    bare = rig.model_copy(update={"attitude_reference": None, "field": fields_of})
    again = replace(solved, sensors=solve_record(replace(solved.record, rig=bare)))
    document: dict[str, Any] = json.loads(json.dumps(sensors_document(again), allow_nan=False))
    return document


def _standard_uncertainties(document: dict[str, Any]) -> list[tuple[str, ...]]:
    return [
        (sensor, "axes", axis, "parameters", name, "standard_uncertainty")
        for sensor, solved in document.items()
        for axis, section in solved["axes"].items()
        for name, parameter in section["parameters"].items()
        if parameter["standard_uncertainty"] is not None
    ]


def _at(document: Any, path: tuple[str, ...]) -> float:
    for key in path:
        document = document[key]
    return float(document)


def _is_any_axis_undetermined(solved: SolvedRun, name: str) -> bool:
    """Return whether a sensitivity is not told from zero at 0.99: the level was 0.9 when a set was stored."""
    calibration = solved.sensors[name].calibration
    assert calibration is not None
    return any("is not told from zero" in why for why in calibration.unusable_axes.values())


@EVERY
def test_a_stored_set_is_the_one_that_its_run_gives(case: StoredCase, tmp_path: Path) -> None:
    solved = solve_run(case.copy("finished", tmp_path / "run"))
    sets = sets_of(solved)
    stored = {path.stem: path for path in (case.folder / "finished" / "coefficients").glob("*.json")}
    # Straight lines leave a set since version 4 of its form; what left one then leaves it now.
    no_set = {name for name in stored if _is_any_axis_undetermined(solved, name)}
    assert stored.keys() - no_set == {name for name, found in sets.items() if found.convention != "SR"}
    for name in stored.keys() - no_set:
        path = stored[name]
        then, now = json.loads(path.read_text(encoding="utf-8"))["axes"], sets[name].document["axes"]
        # The chance of a lack of fit counts what the table may do since then, which only makes it larger.
        paths = [(axis, "replication", "lack_of_fit", "p_value") for axis in then if then[axis]["replication"]]
        assert [path for path in paths if _at(now, path) < _at(then, path) * (1.0 - 1e-9)] == []
        chance = {"/" + "/".join(path) for path in paths}
        found = _coefficients_moved(then, now)
        assert [entry for entry in found if entry.split(":")[0] not in chance] == []


@EVERY
def test_every_reading_of_a_stored_run_is_in_the_unit_of_its_channel(case: StoredCase, tmp_path: Path) -> None:
    """Version 0.1 stored none: volts behind a meter, and on a stream what its table in ``rig.toml`` says."""
    rig = tomllib.loads((case.folder / "rig.toml").read_text(encoding="utf-8"))
    measured = {"acceleration": {"g", "mps2", "v", "counts"}, "rate": {"dps", "v", "counts"}, "field": {"ut", "v"}}
    with JournalReader.open(case.copy("finished", tmp_path / "run")) as reader:
        readings = next(reader.dwells(accepted_only=True)).readings
    for sensor in rig["sensors"].values():
        for channel in readings.keys() & sensor["channels"].values():
            is_metered = channel.partition(".")[0] in rig.get("readouts", {})
            allowed = {"v"} if is_metered else measured[sensor.get("measures", "acceleration")]
            assert readings[channel].unit in allowed, channel


@pytest.mark.parametrize(
    "case",
    [case if name_of(case) in GO_ON else pytest.param(case, marks=pytest.mark.thorough) for case in CASES],
    ids=name_of,
)
def test_a_stored_interrupted_run_goes_on_to_the_numbers_of_its_brother(
    case: StoredCase, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Resumed with a word for the changes: the version is another one by the time this is run."""
    run = case.copy("interrupted", tmp_path / "run")
    outcome = resume(run, "carla", "a stored run", accepts_changes=True)
    assert (outcome.state, outcome.exit_status) == (State.FINISHED, 0), outcome.reason
    assert list(_beyond_uncertainty(case.numbers, _solved(run))) == []
    if not case.began_elsewhere:
        _solve_as_it_was(case, monkeypatch)
        assert _coefficients_moved(case.numbers, _solved(run)) == []


def _beyond_uncertainty(then: dict[str, Any], now: dict[str, Any]) -> Iterator[str]:
    """Coefficients of two measurements of one sensor that differ by more than six standard uncertainties."""
    for sensor, document in then.items():
        for axis, section in document["axes"].items():
            for name, was in section["parameters"].items():
                found = now[sensor]["axes"][axis]["parameters"][name]
                if was["value"] is None or found["value"] is None:
                    continue  # not determined by so few replications
                if abs(found["value"] - was["value"]) > 6.0 * was["standard_uncertainty"]:
                    yield f"{sensor} {axis} {name}: was {was['value']}, is {found['value']}"


def test_an_interrupted_run_is_told_as_such_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for case in CASES:
        outcome = call(capsys, "status", case.copy("interrupted", tmp_path / name_of(case)), "--json").document
        assert outcome["state"] == "interrupted", case
        assert 0 < outcome["dwells_done"] < outcome["dwells_planned"], case


@EVERY_VERSION
@pytest.mark.thorough
def test_the_command_resumes_a_stored_run(version: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One kind through the whole of it, pages, sets and exports included."""
    case = StoredCase(version / "tumble")
    word = ("--operator", "carla", "--reason", "a stored run", "--accept-changes")
    resumed = call(capsys, "resume", case.copy("interrupted", tmp_path / "interrupted"), *word, "--json")
    assert (resumed.status, resumed.document["state"]) == (0, "finished"), resumed.err
    assert _coefficients_moved(case.numbers, resumed.document["sensors"]) == []


@EVERY_VERSION
def test_a_resumed_run_of_gyros_shows_its_restart_in_their_own_unit(
    version: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No sensitivity turns volts of a gyro into an angle against gravity."""
    run = StoredCase(version / "profile_harmonic").copy("interrupted", tmp_path / "interrupted")
    resumed = call(
        capsys, "resume", run, "--operator", "carla", "--reason", "a stored run", "--accept-changes", "--json"
    )
    assert (resumed.status, resumed.document["state"]) == (0, "finished"), resumed.err
    page = (run / "report.html").read_text(encoding="utf-8")
    table = page[page.index("Check set after restarts") :].partition("</table>")[0]
    rows = [row for row in table.split("<tr>") if "ENC03J" in row]
    assert len(rows) == 3
    assert all(row.count(" V</td>") == 3 and "″" not in row for row in rows), rows


@pytest.mark.parametrize("journal", JOURNALS, ids=lambda path: "-".join(path.parts[-4:-1]))
def test_a_plan_s_hash_is_that_of_its_stored_text(journal: Path, tmp_path: Path) -> None:
    """Of the text as it was stored: a plan that is read and written again may have fields that came later."""
    document = header_of(Path(shutil.copytree(journal.parent, tmp_path / "run")) / "journal.sqlite")
    header = RunHeader.from_json(json.dumps(document))
    for text, sha256 in (
        (header.plan_json, header.plan_sha256),
        (header.rig_text, header.rig_sha256),
        (header.procedure_text, header.procedure_sha256),
    ):
        assert hashlib.sha256(text.encode()).hexdigest() == sha256
    assert header.plan.title == header.title


@pytest.mark.parametrize("journal", JOURNALS, ids=lambda path: "-".join(path.parts[-4:-1]))
def test_what_header_and_plan_gained_since_has_a_default(journal: Path, tmp_path: Path) -> None:
    header = header_of(Path(shutil.copytree(journal.parent, tmp_path / "run")) / "journal.sqlite")
    assert [field.name for field in fields(RunHeader) if field.name not in header and not _has_default(field)] == []
    plan = json.loads(header["plan_json"])
    assert [field.name for field in fields(Plan) if field.name not in plan and not _has_default(field)] == []


@EVERY
def test_a_plan_is_read_without_the_fields_that_have_defaults(case: StoredCase, tmp_path: Path) -> None:
    """As it would have been stored by a version that did not know them yet."""
    text = header_of(case.copy("finished", tmp_path / "run") / "journal.sqlite")["plan_json"]
    plan, document = Plan.from_json(text), json.loads(text)
    for field in fields(Plan):
        if _has_default(field) and field.name != "version":
            without = {key: value for key, value in document.items() if key != field.name}
            read = Plan.from_json(json.dumps(without))
            assert read.steps == plan.steps, field.name


def _has_default(entry: "Field[Any]") -> bool:
    return entry.default is not MISSING or entry.default_factory is not MISSING


@EVERY
def test_stored_files_are_planned_as_they_were(case: StoredCase, tmp_path: Path) -> None:
    then = header_of(case.copy("finished", tmp_path / "run") / "journal.sqlite")
    assert then["rig_text"] == (case.folder / "rig.toml").read_text(encoding="utf-8")
    assert then["procedure_text"] == (case.folder / "procedure.toml").read_text(encoding="utf-8")
    rig, procedure = read_rig(case.folder / "rig.toml"), read_procedure(case.folder / "procedure.toml")
    now = json.loads(make_plan(rig, procedure).to_json())
    assert moved(json.loads(then["plan_json"])["steps"], now["steps"]) == []


@pytest.mark.parametrize("path", EXPORTS, ids=lambda path: "-".join((path.parts[-4], *path.parts[-2:])))
def test_stored_sets_and_exports_verify(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    verified = call(capsys, "verify", path, "--json")
    assert verified.status == 0, verified.err


@EVERY_VERSION
def test_a_stored_archive_lists_shows_and_compares(
    version: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = Path(shutil.copy(version / "archive.sqlite", tmp_path / "archive.sqlite"))
    archive = ("--archive", f"sqlite:///{copy}", "--json")
    migrated = call(capsys, "archive", "migrate", *archive[:2])
    assert migrated.status == 0, migrated.err
    then = json.loads((version / "archive.json").read_text(encoding="utf-8"))
    listed = call(capsys, "archive", "list", *archive).document["sets"]
    assert moved(then["list"], listed) == []
    for sha256, document in then["show"].items():
        assert moved(document, call(capsys, "archive", "show", sha256[:12], *archive).document) == []
    old, new = then["compared"]
    assert moved(then["compare"], call(capsys, "archive", "compare", old[:12], new[:12], *archive).document) == []
    assert call(capsys, "archive", "verify", *archive).status == 0


@EVERY_VERSION
def test_a_grid_that_is_measured_anew_gives_the_stored_coefficients(version: Path, tmp_path: Path) -> None:
    """Files, twins, devices, engine and solver, on the rig of ``calrig demo`` with fewer attitudes; a file without
    ``index_errors`` meant independent teeth when it was written."""
    grid = StoredCase(version / "grid")
    for name in ("rig.toml", "procedure.toml"):
        shutil.copy(grid.folder / name, tmp_path)
    rig = read_rig(tmp_path / "rig.toml")
    teeth = {name: axis.model_copy(update={"index_errors": "independent"}) for name, axis in rig.axes.items()}
    rig = rig.model_copy(update={"axes": teeth})
    anew = Bench(tmp_path, rig, make_plan(rig, read_procedure(tmp_path / "procedure.toml")))
    assert anew.run(tmp_path / "run").state is State.FINISHED
    assert _coefficients_moved(grid.numbers, _solved(tmp_path / "run")) == []


@pytest.mark.soak
@EVERY_VERSION
def test_the_demonstration_gives_the_stored_numbers(
    version: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All 247 attitudes; ``make test`` measures the same rig at fewer, above."""
    then = json.loads((version / "demo.json").read_text(encoding="utf-8"))
    outcome = call(capsys, "demo", "--out", tmp_path / "demo", "--json")
    assert outcome.status == 0, outcome.err
    assert _coefficients_moved(then["sensors"], outcome.document["sensors"]) == []
