"""``calrig archive`` and ``calrig resolve`` as a user calls them, rightly and wrongly."""

import json
import re
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import pytest
from command import Outcome, call
from reports_left_out import reports_left_out
from signers import with_accounts
from small_run import PROCEDURE, RIG
from stored_runs import DATA, StoredCase

from procedures.cli.main import run_command

ACCEPTANCE = "\n[acceptance]\npitch_limit_deg = 0.02\n"


@dataclass(frozen=True)
class Laboratory:
    """Two runs of one sensor, the second after a remount, in one archive."""

    folder: Path
    url: str
    runs: tuple[Path, ...]


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory: pytest.TempPathFactory) -> Laboratory:
    folder = tmp_path_factory.mktemp("laboratory")
    url = f"sqlite:///{folder / 'archive.sqlite'}"
    wider = PROCEDURE.replace("from = -180.0, to = 90.0, step = 90.0", "from = -180.0, to = 120.0, step = 60.0")
    wider = wider.replace("from = -30.0, to = 30.0", "from = -60.0, to = 60.0")
    # The second reads longer: in virtual time it must end after the first, however soon after it it began.
    for mounting in (1, 2):
        (folder / "procedure.toml").write_text(wider.replace("samples = 5", f"samples = {5 * mounting}"))
        rig = RIG.replace("seed = 7", f"seed = 7{mounting}\nmounting = {mounting}")
        (folder / "rig.toml").write_text(rig + "[twin.base]\nremount_arcsec = 20.0\n" + ACCEPTANCE)
        run = ["run", str(folder / "procedure.toml"), "--rig", str(folder / "rig.toml"), "--out", str(folder / "runs")]
        with reports_left_out():
            assert run_command([*run, "--archive", url, "--json"]) == 0
    return Laboratory(folder, url, tuple(sorted(path for path in (folder / "runs").iterdir() if path.is_dir())))


@pytest.fixture
def archive(laboratory: Laboratory, capsys: pytest.CaptureFixture[str]):  # type: ignore[no-untyped-def]
    """``archive("list", …)`` on the laboratory's archive."""

    def called(*arguments: object) -> Outcome:
        return call(capsys, "archive", *arguments, "--archive", laboratory.url)

    return called


def checksums(archive) -> list[str]:  # type: ignore[no-untyped-def]
    return [row["sha256"] for row in archive("list", "--json").document["sets"]]


def test_a_run_ends_up_in_the_archive_found_and_left(archive, laboratory: Laboratory) -> None:  # type: ignore[no-untyped-def]
    rows = sorted(archive("list", "--json").document["sets"], key=lambda row: row["run_id"])  # twins have no true ages
    assert [(row["sensor"], row["run_id"], row["rig"]) for row in rows] == [
        ("SN1", run.name, "bench of twins") for run in laboratory.runs
    ]
    assert rows[0]["as_found"] is None
    assert rows[1]["as_found"] in ("pass", "conditional", "fail")
    assert archive("list", "--sensor", "SN2").out.startswith("0 sets")
    shown, lines = archive("show", rows[0]["sha256"]).out, archive("list").out.splitlines()
    without = ", without the level of the base"
    assert without in shown
    for row in rows:
        (line,) = (line for line in lines if line.startswith(row["sha256"][:12]))
        assert row["verdict_conditions"].startswith(without)
        assert f"verdict {row['verdict']}{row['verdict_conditions']}" in line
    assert archive("list", "--since", "2999-01-01", "--json").document["sets"] == []


def test_show_tells_coefficients_what_was_found_and_who_signed(archive) -> None:  # type: ignore[no-untyped-def]
    text = archive("show", "SN1").out
    assert "as found: " in text
    assert "decision rule: pass where |error| + U is inside the limit" in text
    assert ": unsigned" in text
    assert "  remark: " in text, "what is no reservation is not called a warning"
    warned = {line.strip() for line in text.splitlines() if "warning: " in line}
    assert all(line.startswith("warning: 2 replications only") for line in warned), warned
    assert re.search(r"lack of fit (not )?significant \(T \S+, p \S+\)", text)
    assert archive("show", "SN1", "--json").document["sensor"]["name"] == "SN1"


def test_compare_takes_the_remount_out(archive) -> None:  # type: ignore[no-untyped-def]
    old, new = checksums(archive)
    document = archive("compare", old[:12], new[:12], "--json").document
    assert set(document["rotation_deg"]) == {"x", "y", "z"}
    assert 0.001 < max(abs(entry["value"]) for entry in document["rotation_deg"].values()) < 0.05
    assert abs(document["axes"]["x"]["sensitivity_relative"]["value"]) < 1e-4
    assert "common rotation of the package (remount): x " in archive("compare", old[:12], new[:12]).out


def test_runs_are_found_by_any_words_and_what_is_due_is_told(archive, laboratory: Laboratory) -> None:  # type: ignore[no-untyped-def]
    assert archive("search").out.startswith("2 runs")
    found = archive("search", "sn1", laboratory.runs[1].name, "--json").document["runs"]
    assert [entry["run"]["run_id"] for entry in found] == [laboratory.runs[1].name]
    assert archive("search", "nobody-wrote-this").out.startswith("0 runs")
    assert archive("due").out.startswith("the archive knows no standard and no measured sensor"), "twins are left out"
    assert archive("due", "--within-days", "30", "--json").document["due"] == []


def test_history_is_told_and_drawn(archive, laboratory: Laboratory) -> None:  # type: ignore[no-untyped-def]
    plot = laboratory.folder / "history.svg"
    text = archive("history", "SN1", "--plot", plot)
    assert text.status == 0
    assert "cannot judge yet (2 of 5 calibrations): the scatter" in text.out
    assert "nothing was found" not in text.out
    assert "next calibration, as advice" not in text.out  # two runs of one hour say nothing of an interval
    assert plot.read_bytes().startswith(b"<?xml")
    charts = archive("history", "SN1", "--json").document["history"]["charts"]
    assert [chart["name"] for chart in charts][:2] == ["offset_v.x", "offset_v.y"]


def test_publishing_a_run_again_says_that_it_was_there(archive, laboratory: Laboratory) -> None:  # type: ignore[no-untyped-def]
    text = archive("publish", laboratory.runs[0])
    assert (text.status, "was there already" in text.out) == (0, True)
    assert archive("publish", laboratory.runs[0], "--json").document["sets"][0]["is_new"] is False


@pytest.mark.parametrize(("run", "sentence"), [("static", "was measured at rest, which determines no coefficients")])
def test_a_run_without_a_set_says_of_every_sensor_why(
    archive,
    tmp_path: Path,
    run: str,
    sentence: str,  # type: ignore[no-untyped-def]
) -> None:
    text = archive("publish", StoredCase(DATA / "runs_0_1_0" / run).copy("finished", tmp_path / "run"))
    assert text.status == 2
    assert sentence in text.err
    assert ": ;" not in text.err


def test_a_run_of_straight_lines_is_published_with_its_units(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    own = "--archive", f"sqlite:///{tmp_path / 'lines.sqlite'}"
    run = StoredCase(DATA / "runs_0_1_0" / "two_level").copy("finished", tmp_path / "run")
    outcome = call(capsys, "archive", "publish", run, *own)
    assert outcome.status == 0
    assert "µT with U" in outcome.out
    (listed,) = call(capsys, "archive", "list", "--json", *own).document["sets"]
    assert listed["model"] == "linear"
    charts = call(capsys, "archive", "history", listed["sensor"], "--json", *own).document["history"]["charts"]
    assert charts[0]["name"].startswith("offset_ut.")


def test_signing_needs_the_secret_of_that_very_person(
    archive, laboratory: Laboratory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:  # type: ignore[no-untyped-def]
    first = checksums(archive)[0][:12]
    unknown = archive("sign", first, "prepared", "--operator", "A. Ray")
    assert (unknown.status, "A. Ray: nobody of that name has an account" in unknown.err) == (2, True)
    secret = with_accounts(tmp_path, monkeypatch, "A. Ray", "B. Sun")
    silent = archive("sign", first, "prepared", "--operator", "A. Ray")
    assert (silent.status, "needs the secret of its person" in silent.err) == (2, True)
    (tmp_path / "guess").write_text("aaaa-aaaa-aaaa-aaab")
    wrong = archive("sign", first, "prepared", "--operator", "A. Ray", "--secret-file", tmp_path / "guess")
    assert (wrong.status, "that is not the secret" in wrong.err) == (2, True)
    monkeypatch.setattr("sys.stdin", StringIO("aaaa-aaaa-aaaa-aaab\n"))
    from_input = archive("sign", first, "prepared", "--operator", "A. Ray", "--secret-file", "-")
    assert (from_input.status, "that is not the secret" in from_input.err) == (2, True)
    refused = archive("sign", first, "approved", "--operator", "A. Ray", *secret)
    assert (refused.status, "is not its turn" in refused.err) == (2, True)
    signed = archive("sign", first, "prepared", "--operator", "a. ray", *secret, "--json").document
    assert (signed["state"], signed["signatures"][0]["name"]) == ("prepared", "A. Ray")
    report = archive("verify", "--json").document
    assert (report["verified"], report["faults"]) == (True, [])
    assert "intact" in archive("verify").out
    with closing(sqlite3.connect(laboratory.folder / "archive.sqlite")) as records:
        (text,) = records.execute("SELECT detail FROM records WHERE kind = 'signature'").fetchone()
    assert json.loads(text)["identified_by"] == "the secret of that name"


def test_resolve_finds_the_same_numbers_and_writes_nothing(
    laboratory: Laboratory, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (laboratory.folder / "archive.sqlite").read_bytes()
    outcome = call(capsys, "resolve", "--archive", laboratory.url, "--workers", 1, "--json")
    assert outcome.status == 0
    assert {name: outcome.document[name] for name in ("runs", "same", "published")} == {
        "runs": 2, "same": 2, "published": 0
    }  # fmt: skip
    otherwise = call(capsys, "resolve", "--archive", laboratory.url, "--workers", 1, "--extended", "no")
    assert "0 same, 2 changed" in otherwise.out
    assert "q_xx_v_per_g2 is gone" in otherwise.out
    assert (laboratory.folder / "archive.sqlite").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["list", "--since", "yesterday"], 2, "--since: got 'yesterday', needed is a day such as 2026-03-01"),
        (["show", "SN9"], 2, "no single set for 'SN9': found nothing"),
        (["history", "SN9"], 2, "sensor 'SN9': has no set here"),
        (["compare", "SN1", "ffffff"], 2, "no single set for 'ffffff'"),
        (["sign", "SN1", "blessed", "--operator", "N. N."], 2, "nobody of that name has an account"),
        (["publish", "nowhere"], 2, "nowhere: no run is there"),
        (["demo", "--sensors", 3], 2, "a demonstration needs at least 8 sensors and 4 years: got 3 and 8"),
    ],
)
def test_what_is_asked_wrongly_is_a_sentence(
    arguments: list[object], status: int, sentence: str, laboratory: Laboratory, capsys: pytest.CaptureFixture[str]
) -> None:
    where = [] if arguments[0] == "demo" else ["--archive", laboratory.url]
    outcome = call(capsys, "archive", *arguments, *where)
    assert (outcome.status, outcome.out) == (status, "")
    assert sentence in outcome.err


def test_an_override_needs_its_name(laboratory: Laboratory, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(
        capsys, "archive", "publish", laboratory.runs[0], "--override", "why not", "--archive", laboratory.url
    )
    assert (outcome.status, "--override REASON and --operator NAME together" in outcome.err) == (2, True)


@pytest.mark.parametrize("command", ["list", "verify", "migrate"])
def test_an_archive_that_is_not_there_is_a_wrong_request_and_is_not_made(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = call(capsys, "archive", command, "--archive", f"sqlite:///{tmp_path / 'none.sqlite'}")
    assert (outcome.status, "there is no archive: no such file" in outcome.err) == (2, True)
    assert not (tmp_path / "none.sqlite").exists()


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["--workers", 0], 2, "--workers: got 0, allowed are 1 and more"),
        (["--workers", 2, "--dask", "tls://h:1"], 2, "give --workers or --dask, not both"),
        (["--dask", "tcp://198.51.100.7:8786"], 2, "allowed are tls://HOST:PORT and, on this machine,"),
    ],
)
def test_resolve_asked_wrongly_is_a_sentence(
    arguments: list[object], status: int, sentence: str, laboratory: Laboratory, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = call(capsys, "resolve", *arguments, "--archive", laboratory.url)
    assert (outcome.status, outcome.out) == (status, "")
    assert sentence in outcome.err


@pytest.mark.thorough
def test_a_synthetic_archive_is_made_once_and_tells_who_did_what(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "demo.sqlite"
    made = call(capsys, "archive", "demo", "--out", path, "--sensors", 8, "--years", 4, "--json").document
    assert made["sets"] == 9 * 8
    (dropped,) = made["dropped"]
    outcome = call(capsys, "archive", "history", dropped, "--archive", made["archive"], "--json").document
    assert "step" in {finding["kind"] for finding in outcome["history"]["findings"]}
    again = call(capsys, "archive", "demo", "--out", path)
    assert (again.status, "is there already" in again.err) == (2, True)
