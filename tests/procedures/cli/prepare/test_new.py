"""Laws of ``calrig new``: what it writes passes ``check``, and the schemas beside it say what the files may hold."""

import json
import tomllib
from pathlib import Path

import pytest
from command import call
from jsonschema import Draft202012Validator

from procedures.check.new_files import PROCEDURE_SCHEMA, RIG_SCHEMA, schemas


@pytest.mark.parametrize(
    "options",
    [
        pytest.param((), marks=pytest.mark.thorough),
        ("--axes", "xz", "--sensor", "QA-7", "--increment-deg", "5", "--name", 'the "old" rig'),
    ],
)
def test_what_it_writes_passes_check(tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple) -> None:
    assert call(capsys, "new", tmp_path, *options).status == 0
    rig, procedure = tmp_path / "rig.toml", tmp_path / "procedure.toml"
    document = call(capsys, "check", procedure, "--rig", rig, "--json").document
    assert document["dwells_planned"] > 500
    assert document["expected_angle_half_width_deg"]
    assert not any(sign.isdigit() for sign in document["title"])
    assert procedure.read_text(encoding="utf-8").splitlines()[1].startswith("# Written by calrig new for ")
    for path, name in ((rig, RIG_SCHEMA), (procedure, PROCEDURE_SCHEMA)):
        text = path.read_text(encoding="utf-8")
        assert text.startswith(f"#:schema ./{name}\n")
        validator = Draft202012Validator(json.loads((tmp_path / name).read_text(encoding="utf-8")))
        assert list(validator.iter_errors(tomllib.loads(text))) == []


def test_the_schemas_refuse_an_unknown_key_and_know_every_driver() -> None:
    texts = schemas()
    assert all(f'"{driver}"' in texts[RIG_SCHEMA] for driver in ("indexing-table", "hp3458a", "zaber", "watlow-f4"))
    validator = Draft202012Validator(json.loads(texts[PROCEDURE_SCHEMA]))
    wrong = {"procedure": {"title": "t", "kind": "grid", "replicatons": 2}}
    assert [error.validator for error in validator.iter_errors(wrong)] == ["additionalProperties"]


def test_an_answer_that_cannot_be_is_told_by_its_option_and_not_by_a_file_that_nobody_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = call(capsys, "new", tmp_path, "--increment-deg", "0")
    assert outcome.status == 2
    assert "new: --increment-deg: got 0.0, allowed above 0; nothing was written" in outcome.err
    assert "rig.toml" not in outcome.err


def test_nothing_is_written_over_what_is_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "rig.toml").write_text("mine", encoding="utf-8")
    outcome = call(capsys, "new", tmp_path)
    assert (outcome.status, (tmp_path / "rig.toml").read_text(encoding="utf-8")) == (2, "mine")
    assert "there already; nothing was written" in outcome.err
    assert [path.name for path in tmp_path.iterdir()] == ["rig.toml"]


def test_a_folder_is_made_and_none_above_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "new", tmp_path / "above" / "lab")
    assert (outcome.status, list(tmp_path.iterdir())) == (2, [])
    assert "above: no folder is there; nothing was written" in outcome.err
    assert call(capsys, "new", tmp_path / "lab", "--axes", "x").status == 0
    assert (tmp_path / "lab" / "procedure.toml").is_file()
    assert "rig.toml: is a file" in call(capsys, "new", tmp_path / "lab" / "rig.toml").err


@pytest.mark.parametrize(
    ("option", "value", "sentence"),
    [
        ("--axes", "xx", "allowed are x, y, z"),
        ("--usage-deg", "120", "allowed above 0 to 90"),
        ("--sensor", "a b", "allowed are letters"),
        ("--speed-dps", "-1", "--speed-dps: got -1.0"),
    ],
)
def test_bad_answers_are_sentences(tmp_path: Path, capsys, option: str, value: str, sentence: str) -> None:
    outcome = call(capsys, "new", tmp_path, option, value)
    assert outcome.status == 2
    assert sentence in outcome.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_at_a_terminal_it_asks_what_no_option_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    requests: list[str] = []

    def answer(question: str) -> str:
        requests.append(question)
        return {"Name of the rig": "asked", "Speed of the table": "quick" if len(requests) < 8 else "7.0"}.get(
            question.split(",")[0].split(" [")[0], ""
        )

    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", answer)
    assert call(capsys, "new", tmp_path, "--sensor", "SN9").status == 0
    assert not any("Serial number" in question for question in requests)
    text = (tmp_path / "rig.toml").read_text(encoding="utf-8")
    assert 'name = "asked"' in text
    assert "speed_dps = 7.0" in text
    assert "[sensors.SN9]" in text
