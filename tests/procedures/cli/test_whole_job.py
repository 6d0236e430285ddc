"""Laws of the whole job as a user calls it: what it leaves, what it says, the status it ends with."""

import html
import shutil
import socket
import sqlite3
import subprocess
import sys
from copy import deepcopy
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from command import Outcome, call
from finished_job import FinishedJob
from job_files import job, simulated

from procedures.delivery.deliver import solve_run
from rig.lines.lock import acquire

METER = "prologix+socket://127.0.0.1:7#22"
AIR_APART = {'driver = "watlow-f4"\nport = "twin"': 'driver = "watlow-f4"\nport = "socket://127.0.0.1:3"'}
"""The chamber is not on the line of the axes."""
AIR_ON_ITS_TWIN = {'driver = "watlow-f4"\nport = "twin"': 'driver = "watlow-f4"\nport  = "twin"'}
"""Not changed with the port of the axes."""


def run(capsys: pytest.CaptureFixture[str], folder: Path, *options: object, **changes: dict[str, str]) -> Outcome:
    procedure, rig = job(folder, **changes)
    return call(capsys, "run", procedure, "--rig", rig, "--out", folder / "runs", "--json", *options)


@pytest.fixture(scope="module")
def finished(finished_job: FinishedJob) -> tuple[Path, dict]:
    return finished_job.folder, finished_job.summary


def test_a_run_says_and_leaves_what_others_rely_on(finished: tuple[Path, dict]) -> None:
    folder, document = finished
    assert set(document) == {"run", "state", "dwells_done", "dwells_planned", "sensors", "report", "sets", "delivery"}
    assert document["delivery"] == dict.fromkeys(("set", "archive", "lessons", "exports", "html", "pdf"), "done")
    assert (document["state"], document["dwells_done"], document["dwells_planned"]) == ("finished", 24, 24)
    assert set(document["sensors"]["SN1047"]["axes"]) == {"x", "y", "z"}
    left = {str(path.relative_to(document["run"])) for path in Path(document["run"]).rglob("*") if path.is_file()}
    assert left >= {
        "journal.sqlite",
        "plan.json",
        "report.html",
        "coefficients/SN1047.json",
        "exports/SN1047.csv",
        "exports/SN1047.mat",
    }
    assert document["sets"] == [str(Path(document["run"]) / "coefficients" / "SN1047.json")]
    assert (folder / "runs" / "archive.sqlite").exists()


def test_the_truth_lies_within_six_standard_uncertainties(finished: tuple[Path, dict]) -> None:
    x = finished[1]["sensors"]["SN1047"]["axes"]["x"]["parameters"]
    for name, truth in {"offset_v": 0.005, "sensitivity_v_per_g": 2.5, "coning_deg": 0.5, "azimuth_deg": 35.0}.items():
        estimate = x[name]  # two replications: the reported form rests on one degree of freedom, the pooled one on many
        u = max(estimate["standard_uncertainty"], estimate["tp_standard_uncertainty"])
        assert abs(estimate["value"] - truth) < 5.0 * u


def test_solving_again_changes_no_byte(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_folder = finished_job.copied_to(tmp_path)
    names = ("report.html", "coefficients/SN1047.json", "exports/SN1047.csv", "exports/SN1047.mat")
    before = {name: (run_folder / name).read_bytes() for name in names}
    outcome = call(capsys, "solve", run_folder, "--json")
    assert outcome.status == 0
    assert outcome.document == {"sensors": finished_job.summary["sensors"]}
    assert {name: (run_folder / name).read_bytes() for name in names} == before
    listed = call(capsys, "archive", "list", "--archive", f"sqlite:///{tmp_path / 'runs' / 'archive.sqlite'}", "--json")
    assert [entry["sensor"] for entry in listed.document["sets"]] == ["SN1047"]


@pytest.mark.usefixtures("no_report")
def test_an_archive_that_does_not_answer_costs_no_result(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_folder = finished_job.copied_to(tmp_path)
    outcome = call(capsys, "solve", run_folder, "--archive", "postgresql+psycopg://u:secret@127.0.0.1:1/x")
    assert outcome.status == 1
    assert "sensitivity" in outcome.out
    assert str(run_folder / "report.html") in outcome.out
    assert "archive      " not in outcome.out
    assert f"calrig archive publish {run_folder} does it later" in outcome.err
    assert "does not answer" in outcome.err
    assert "secret" not in outcome.err


@pytest.mark.parametrize(
    ("option", "value", "sentence"),
    [("--archive", "bogus://x", "no archive can have this URL"), ("--alerts", "nowhere.toml", "no such file")],
)
def test_what_the_end_of_a_run_needs_is_looked_at_before_its_beginning(
    option: str, value: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = run(capsys, tmp_path, option, value)
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err
    assert not (tmp_path / "runs").exists()


def test_a_demonstration_in_a_file_is_a_wrong_request(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    outcome = call(capsys, "demo", "--out", tmp_path / "file")
    assert (outcome.status, "cannot be worked in: File exists; nothing was written" in outcome.err) == (2, True)


def test_a_note_written_later_does_not_make_the_run_longer(
    finished: tuple[Path, dict], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The twin's clock is in virtual time, a note in real time: the run would end before it began."""
    noted = tmp_path / "noted"
    shutil.copytree(finished[1]["run"], noted)
    before = ended(noted)
    assert call(capsys, "note", noted, "the customer has asked for a second look").status == 0
    assert ended(noted) == before


def ended(folder: Path) -> datetime:
    return solve_run(folder).record.ended_utc


def test_every_file_it_leaves_is_verified(finished: tuple[Path, dict], capsys: pytest.CaptureFixture[str]) -> None:
    run_folder = Path(finished[1]["run"])
    for name in ("coefficients/SN1047.json", "exports/SN1047.csv", "exports/SN1047.mat"):
        assert call(capsys, "verify", run_folder / name, "--json").status == 0


def test_a_damaged_set_is_a_sentence(
    finished: tuple[Path, dict], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = Path(finished[1]["sets"][0]).read_text()
    damaged = tmp_path / "SN1047.json"
    damaged.write_text(data.replace('"value"', '"valve"', 1))
    outcome = call(capsys, "verify", damaged)
    assert (outcome.status, outcome.out) == (2, "")
    assert str(damaged) in outcome.err


def test_status_of_a_finished_run(finished: tuple[Path, dict], capsys: pytest.CaptureFixture[str]) -> None:
    """With what it came to, in the words of its page; a run of which dwells were taken back is no longer that."""
    folder, document = finished
    page = html.unescape((Path(document["run"]) / "report.html").read_text(encoding="utf-8"))
    told = call(capsys, "status", folder / "runs", "--json").document
    verdict = told.pop("verdict")
    assert verdict in page
    assert verdict.split()[0] in ("Sound", "Usable", "There")
    assert f"verdict: {verdict}\n" in call(capsys, "status", folder / "runs").out
    assert told == {
        "run": document["run"],
        "state": "finished",
        "dwells_done": 24,
        "dwells_planned": 24,
        "eta_utc": None,
        "held_by": None,
    }


@pytest.mark.parametrize("command", ["pause", "continue", "stop", "abort"])
def test_a_finished_run_takes_no_request(
    finished: tuple[Path, dict], capsys: pytest.CaptureFixture[str], command: str
) -> None:
    outcome = call(capsys, command, finished[1]["run"])
    assert outcome.status == 2
    assert "it is finished" in outcome.err


@pytest.mark.usefixtures("no_report")
@pytest.mark.parametrize("options", [(), pytest.param(("--pty",), marks=pytest.mark.thorough)], ids=["tcp", "pty"])
def test_real_ports_give_the_same_numbers_as_memory(
    finished: tuple[Path, dict], tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...]
) -> None:
    procedure, rig = job(tmp_path)
    with simulated(rig, tmp_path / "ports.toml", "--time-factor", "100", *options) as addresses:
        assert set(addresses) == {"axes.pitch", "axes.roll", "readouts.dmm", "environment.air", "twin"}
        ports = tmp_path / "ports.toml"
        outcome = call(capsys, "run", procedure, "--rig", ports, "--out", tmp_path / "runs", "--json")
    assert outcome.status == 0, outcome.err
    assert _apart_from_times(outcome.document["sensors"]) == _apart_from_times(finished[1]["sensors"])


def _apart_from_times(sensors: dict) -> dict:
    """Return the sensors without the findings about time, which passes otherwise over ports."""
    kept = deepcopy(sensors)
    for sensor in kept.values():
        for axis in sensor["axes"].values():
            axis["findings"] = [entry for entry in axis["findings"] if "time" not in entry.get("test", "")]
    return kept


@pytest.mark.usefixtures("no_report")
def test_a_rehearsal_needs_no_port(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    procedure, rig = job(
        tmp_path, None, AIR_APART | {'port = "twin"': 'port = "socket://127.0.0.1:2"', '"twin"': f'"{METER}"'}
    )
    text = Path(rig).read_text(encoding="utf-8")
    Path(rig).write_text(text[: text.index("\n[twin]\n")], encoding="utf-8")
    outcome = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "runs", "--json", "--rehearse")
    assert outcome.status == 0, outcome.err
    assert outcome.document["state"] == "finished"


ANY_PITCH = {'"D1"': '"D"'}
PITCH, ROLL = "from = -60.0, to = 60.0, step = 60.0", "from = -180.0, to = 90.0, step = 90.0"
OVEN = "[environment]\nname = 'oven'\nplateaus_degc = [20.0]\n[export]"
TWO_POINTS = ANY_PITCH | {PITCH: "from = 0.0, to = 0.0, count = 1", ROLL: "from = -180.0, to = 0.0, step = 180.0"}
WRONG_PLANS = [
    ("limit exceeded", ANY_PITCH | {PITCH: "from = -60.0, to = 240.0, step = 150.0"}, {}, "limit"),
    ("off the increment", {"step = 60.0": "count = 8"}, {}, "multiple"),
    ("fewer points than parameters", TWO_POINTS, {}, "parameters"),
    ("roll at one value", {ROLL: "from = 0.0, to = 0.0, count = 1"}, {}, "roll"),
    ("no environment for plateaus", {"[export]": OVEN}, {}, "oven"),
    ("unknown key", {"samples = 5": "sampels = 5"}, {}, "did you mean samples?"),
    ("missing unit", {"pitch_deg": "pitch"}, {}, "the unit is missing"),
    ("rig: unknown key", {}, {"speed_dps": "speed_dsp"}, "did you mean speed_dps?"),
]


@pytest.mark.parametrize(
    ("changes", "rig_changes", "sentence"), [m[1:] for m in WRONG_PLANS], ids=[m[0] for m in WRONG_PLANS]
)
def test_a_wrong_file_is_refused_before_anything_is_written(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    changes: dict[str, str],
    rig_changes: dict[str, str],
    sentence: str,
) -> None:
    outcome = run(capsys, tmp_path, changes=changes, rig_changes=rig_changes)
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err
    assert ".toml:" in outcome.err
    assert not (tmp_path / "runs").exists()


def test_a_busy_rig_is_refused_and_names_its_owner(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, rig = job(tmp_path)
    with acquire([rig], "another run"):
        outcome = run(capsys, tmp_path)
    assert outcome.status == 1
    assert "in use by" in outcome.err
    assert "another run" in outcome.err
    assert not (tmp_path / "runs").exists()


def test_a_missing_port_is_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    closed = socket.socket()
    closed.bind(("127.0.0.1", 0))
    address = f"socket://127.0.0.1:{closed.getsockname()[1]}"
    outcome = run(
        capsys,
        tmp_path,
        rig_changes=AIR_ON_ITS_TWIN | {'port = "twin"': f'port = "{address}"', 'time = "virtual"': 'time = "real"'},
    )
    closed.close()
    assert outcome.status == 1
    assert address in outcome.err
    assert not (tmp_path / "runs").exists()


def test_a_silent_port_is_a_sentence_with_device_and_deadline(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"socket://127.0.0.1:{silent.getsockname()[1]}"
        changes = AIR_ON_ITS_TWIN | {'port = "twin"': f'port = "{address}"', 'time = "virtual"': 'time = "real"'}
        outcome = run(capsys, tmp_path, rig_changes=changes)
    assert outcome.status == 1
    assert f"axes.pitch at {address}: no complete reply" in outcome.err
    assert "within 2 s" in outcome.err
    assert not (tmp_path / "runs").exists()


def test_a_truncated_journal_is_a_sentence(
    finished: tuple[Path, dict], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = (Path(finished[1]["run"]) / "journal.sqlite").read_bytes()
    for command in ("solve", "status", "resume"):
        for size in (0, 10, 4096, len(whole) // 2):
            folder = tmp_path / f"{command}-{size}"
            folder.mkdir()
            (folder / "journal.sqlite").write_bytes(whole[:size])
            outcome = call(capsys, command, folder)
            assert outcome.status == 2, (command, size, outcome.err)
            assert outcome.out == ""
            assert "journal.sqlite" in outcome.err
            assert (folder / "journal.sqlite").read_bytes() == whole[:size]


@pytest.mark.usefixtures("no_report")
def test_noise_free_means_are_not_called_stuck(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = run(
        capsys,
        tmp_path,
        rig_changes={"noise_v = 0.00002": "noise_v = 0.0", "uncertainty_arcsec = 1.0": "uncertainty_arcsec = 0.0"},
    )
    assert outcome.status == 0, outcome.err
    value = outcome.document["sensors"]["SN1047"]["axes"]["x"]["parameters"]["azimuth_deg"]["value"]
    assert np.isclose(value, 35.0, atol=1e-3)


def test_a_copied_journal_with_one_changed_dwell_is_refused(
    finished: tuple[Path, dict], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Copied without the count beside it, one pitch moved by half a degree in SQL: no number may be drawn from it."""
    data = (Path(finished[1]["run"]) / "journal.sqlite").read_bytes()
    (tmp_path / "journal.sqlite").write_bytes(data)
    with sqlite3.connect(tmp_path / "journal.sqlite") as journal:
        journal.execute("UPDATE dwells SET record = replace(record, '60.0', '60.5') WHERE step = 12")
        assert journal.total_changes == 1
    journal.close()
    outcome = call(capsys, "solve", tmp_path, "--json")
    assert (outcome.status, outcome.out) == (2, "")
    assert "is not as it was written" in outcome.err


@pytest.mark.thorough
def test_a_reader_that_goes_away_stops_no_run(tmp_path: Path) -> None:
    procedure, rig = job(tmp_path)
    arguments = ["run", procedure, "--rig", rig, "--out", str(tmp_path / "runs")]
    with subprocess.Popen(
        [sys.executable, "-m", "procedures.cli.main", *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        assert process.stderr is not None
        run_folder = Path(process.stderr.readline().decode().strip())
        process.stderr.close()
        assert process.wait(60) == 0
    assert (run_folder / "report.html").exists()


def test_a_run_without_roll_is_solved_reported_and_exported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    procedure, rig = job(
        tmp_path,
        {'"D1"': '"D"', "roll_deg = { from = -180.0, to = 90.0, step = 90.0 }": "", "step = 60.0": "step = 20.0",
         "[export]": '[solve]\nmodel = "pitch-only"\n[export]'},
        {'"three-axis package"': '"single-axis package"', ', y = "dmm.y", z = "dmm.z" }': " }"},
    )  # fmt: skip
    text = Path(rig).read_text(encoding="utf-8")
    Path(rig).write_text(text[: text.index("[twin.truth.SN1047.y]")], encoding="utf-8")
    outcome = call(capsys, "run", procedure, "--rig", rig, "--out", tmp_path / "runs", "--json")
    assert outcome.status == 0, outcome.err
    parameters = outcome.document["sensors"]["SN1047"]["axes"]["x"]["parameters"]
    assert set(parameters) == {"offset_v", "sensitivity_v_per_g", "pitch_misalignment_deg"}
    assert Path(outcome.document["report"]).stat().st_size > 100_000


@pytest.mark.usefixtures("no_report")
def test_the_other_polarity_than_declared_stops_before_the_long_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = run(capsys, tmp_path, rig_changes={"sensitivity_v_per_g = 2.48": "sensitivity_v_per_g = -2.48"})
    assert (outcome.status, outcome.document["state"], outcome.document["dwells_done"]) == (3, "tripped", 0)
    assert "polarity reversed" in outcome.err
    again = call(capsys, "resume", tmp_path / "runs", "--reason", "it is so")
    assert again.status == 2
    assert "give --operator and --reason" in again.err


@pytest.mark.usefixtures("no_report")
def test_a_sensitivity_far_from_the_declared_one_stops_before_the_long_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    declared = {"nominal_sensitivity_v_per_g = 2.5": "nominal_sensitivity_v_per_g = 5.5"}
    outcome = run(capsys, tmp_path, rig_changes=declared)
    assert (outcome.status, outcome.document["state"]) == (3, "tripped")
    assert "declared 5.5 V/g" in outcome.err


def test_a_plateau_beyond_the_chambers_limits_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hot = {"[export]": "[environment]\nplateaus_degc = [200.0]\n[export]"}
    outcome = run(capsys, tmp_path, changes=hot)
    assert outcome.status == 2
    assert "environment.plateaus_degc: air: setpoint 200 °C, allowed -60 to 150 °C" in outcome.err
