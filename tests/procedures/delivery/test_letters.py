"""Laws of every script through every product: what somebody is called or has noted is there, and does nothing else.

The readers are others': Chromium opens the page, poppler the paper, gcc the headers, csv the tables, lxml the
certificate's XML.
"""

import csv
import json
import subprocess
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import pytest
from chromium import chromium
from command import call
from finished_job import FinishedJob
from job_files import job
from journals import note_of_an_older_version
from letters import acts, all_letters, of_every_block, that_act
from lxml import etree
from programs import require_program
from reports_left_out import reports_left_out

from procedures.cli.main import run_command
from procedures.errors import RequestError
from procedures.journal.requests.corrections import Authorisation
from procedures.journal.requests.spool import ask
from procedures.report.figures import Figures
from rig import plain_text

LONGEST_TITLE = 200
FORMATS = '["csv", "mat", "json", "c", "c-fixed", "epics", "dcc", "hdf5", "parquet"]'
OLD_NOTE = "an old note: \x1b]0;owned\x07\x1b[2J \u202egnol\u202c \x00 \u2028 <script>alert(1)</script> &amp; */ %s"
"""As a journal of before holds it: a terminal's orders, a direction, a null, and what other languages heed."""


@dataclass(frozen=True)
class Lettered:
    """A finished job whose texts hold every script."""

    run: Path
    text: str
    title: str

    @property
    def exports(self) -> Path:
        return self.run / "exports"


@contextmanager
def nothing_delivered() -> Iterator[None]:
    """Sets and archive alone: what is read here is made by the last command."""
    with reports_left_out(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("procedures.delivery.deliver._exported", lambda *_: ())
        yield


@pytest.fixture(scope="module")
def lettered(tmp_path_factory: pytest.TempPathFactory) -> Lettered:
    """Every free text of rig, procedure and command; reported once, when the notes are there."""
    folder, text = tmp_path_factory.mktemp("letters"), of_every_block()
    title = text[: LONGEST_TITLE - 1]
    quoted = json.dumps(text, ensure_ascii=False)
    declared = "".join(f"{key} = {quoted}\n" for key in ("number", "customer", "item", "remarks"))
    laboratory = f'[laboratory]\nname = {quoted}\naddress = {quoted}\ncountry_code = "DE"\n'
    procedure, rig = job(
        folder,
        {'"small"': json.dumps(title, ensure_ascii=False), '["csv", "mat"]': FORMATS},
        {'serial = "AA-2216"': f"serial = {quoted}", "[twin]\nseed": f"[job]\n{declared}{laboratory}[twin]\nseed"},
    )
    name = text[-plain_text.LONGEST_NAME :]
    words = ["run", procedure, "--rig", rig, "--out", str(folder / "runs"), "--operator", name]
    with nothing_delivered():
        assert run_command(words) == 0
    (journal,) = (folder / "runs").glob("*/journal.sqlite")
    run = journal.parent
    assert run_command(["note", str(run), text, "--operator", name]) == 0
    note_of_an_older_version(run, OLD_NOTE, OLD_NOTE)
    assert run_command(["void", str(run), "--from", "25", "--reason", text, "--operator", name]) == 0
    with nothing_delivered():
        assert run_command(["resume", str(run), "--operator", name, "--reason", text]) == 0
    with pytest.MonkeyPatch.context() as patch:  # no text that somebody wrote stands in a figure
        patch.setattr(
            "procedures.report.write.draw_figures",
            lambda view, _tell: Figures((), {sensor.name: () for sensor in view.sensors}),
        )
        assert run_command(["solve", str(run)]) == 0
    return Lettered(run, text, title)


def _opened(page_file: Path) -> Iterator[str]:
    with chromium() as browser:
        page, complaints = browser.new_page(), []
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("dialog", lambda dialog: complaints.append(dialog.message))
        page.goto(page_file.as_uri())
        yield str(page.evaluate("document.body.textContent"))
        assert complaints == []


def _missing(text: str, shown: str) -> list[str]:
    """Letters of a text that are not shown, as they are or as something that means the same."""
    found = set(shown)
    return [
        f"U+{ord(letter):04X}"
        for letter in dict.fromkeys(text)
        if letter not in found
        and unicodedata.category(letter) != "Cf"  # joins and parts others, and is not seen itself
        and f"<U+{ord(letter):04X}>" not in shown
        and not all(part in found for part in unicodedata.normalize("NFKC", letter))
    ]


def test_the_page_in_a_browser_shows_every_script_and_does_nothing(lettered: Lettered) -> None:
    for shown in _opened(lettered.run / "report.html"):
        assert _missing(lettered.text, shown) == []
        assert lettered.title in shown
        assert "<U+001B>]0;owned<U+0007>" in shown
        assert "<U+202E>gnol<U+202C>" in shown
        assert "<script>alert(1)</script> &amp;" in shown


def _words_of_paper(paper: Path) -> str:
    done = subprocess.run([require_program("pdftotext"), paper, "-"], capture_output=True, check=True).stdout
    return "".join(done.decode("utf-8").replace("\u200b", "").replace("\u200e", "").split())


def test_the_paper_prints_every_script_or_its_code_points(lettered: Lettered) -> None:
    shown = _words_of_paper(lettered.run / "report.pdf")
    assert _missing(lettered.text, shown) == []
    assert "<U+001B>]0;owned<U+0007>" in shown


@pytest.mark.parametrize("name", ["SN1047.h", "SN1047.fixed.h"])
def test_the_headers_compile_without_a_warning(lettered: Lettered, name: str, tmp_path: Path) -> None:
    (tmp_path / "main.c").write_text(f'#include "{lettered.exports / name}"\nint main(void) {{ return 0; }}\n')
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wtrigraphs", "-Wcomment", "-Wno-unused-function"]
    strict += ["-Wno-unused-const-variable", "-Wbidi-chars=any,ucn"]
    command = [require_program("gcc"), *strict, "main.c", "-lm", "-o", "main"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_table_and_the_certificate_read_back(lettered: Lettered) -> None:
    with (lettered.exports / "SN1047.csv").open(encoding="utf-8", newline="") as file:
        values = [row[2].removeprefix("'") for row in csv.reader(file)]
    assert lettered.text in values
    xml = etree.parse(lettered.exports / "SN1047.xml", etree.XMLParser(resolve_entities=False))
    assert lettered.text in set(xml.xpath("//text()"))


def test_every_export_is_verified_and_holds_the_texts(lettered: Lettered, capsys: pytest.CaptureFixture[str]) -> None:
    files = sorted(lettered.exports.iterdir())
    assert len(files) == len(json.loads(FORMATS))
    for file in files:
        assert call(capsys, "verify", file).status == 0, file


@pytest.mark.parametrize("command", ["status", "handover"])
def test_a_terminal_gets_every_script_and_no_orders(
    lettered: Lettered, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    outcome = call(capsys, command, lettered.run)
    assert outcome.status == 0
    assert [hex(ord(letter)) for letter in outcome.out + outcome.err if acts(letter) and letter != "\n"] == []
    if command == "handover":
        assert _missing(lettered.text, outcome.out) == []
        assert "<U+001B>]0;owned<U+0007>" in outcome.out


def test_a_letter_that_acts_is_refused_wherever_a_text_comes_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Controls, line breaks, marks of direction, what nobody sees, by option and by file; nothing is opened."""
    procedure, rig = job(tmp_path, {'"small"': '"small@"'})
    text = Path(procedure).read_text(encoding="utf-8")
    line = 1 + text[: text.index("@")].count("\n")
    for letter in that_act():
        said = f"<U+{ord(letter):04X}>"
        if letter != "\0" and unicodedata.category(letter) != "Cs":
            refused = call(capsys, "note", tmp_path, "words", "--operator", f"a{letter}b")
            assert (refused.status, said in refused.err, letter in refused.err[:-1]) == (2, True, False), said
        if unicodedata.category(letter) != "Cs":
            escaped = text.replace("@", f"\\U{ord(letter):08X}")
            Path(procedure).write_text(escaped, encoding="utf-8")
            refused = call(capsys, "check", procedure, "--rig", rig)
            assert (refused.status, letter in refused.err[:-1]) == (2, False), said
            assert refused.err.startswith(f"calrig: {procedure}:{line}: procedure.title: holds {said}, "), refused.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("note", ".", "x" * 100_000), "has 100000 letters, allowed are 2000; shorten it"),
        (("note", ".", "door", "--operator", "Anna" * 100), "has 400 letters, allowed are 200; shorten it"),
        (("void", ".", "3", "--reason", "x" * 2001), "has 2001 letters, allowed are 2000; shorten it"),
        (("void", ".", "3", f"--reason=a{chr(0x301) * 1500}"), "has 1500 marks on one letter, allowed are 30; leave"),
        (("note", ".", "a\ufffeb"), "holds <U+FFFE>, which nobody sees"),
    ],
)
def test_words_that_nobody_can_read_are_refused_before_anything_is_done(
    words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    refused = call(capsys, *words)
    assert (refused.status, said in refused.err) == (2, True), refused.err
    assert len(refused.err) < 300
    assert refused.err.endswith("; nothing was done\n")


def test_a_note_and_an_address_may_have_several_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "no run is there" in call(capsys, "note", tmp_path, "one\nand two").err
    lines = '[laboratory]\nname = "lab"\naddress = """1 Tunnel Road\nHampton"""\n'
    procedure, rig = job(tmp_path, {}, {"[twin]\nseed": f"{lines}[twin]\nseed"})
    assert call(capsys, "check", procedure, "--rig", rig).status == 0


def test_whoever_asks_in_another_way_than_the_command_is_refused_alike(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="operator: holds <U\\+000A>, a line break or a tab; write it in one line"):
        Authorisation("anna\nberta", "a bump")
    with pytest.raises(RequestError, match="reason: has 100000 letters, allowed are 2000; shorten it; nothing was"):
        Authorisation("anna", "a" * 100_000)
    with pytest.raises(RequestError, match="text: has 1500 marks on one letter, allowed are 30"):
        ask(tmp_path, "note", "anna", datetime(2026, 1, 1, tzinfo=UTC), "a" + "\u0489" * 1500)
    with pytest.raises(RequestError, match="by: holds <U\\+200B>, which nobody sees"):
        ask(tmp_path, "stop", "an\u200bna", datetime(2026, 1, 1, tzinfo=UTC))


def test_what_is_written_with_joiners_and_signs_is_no_hidden_letter() -> None:
    """Persian, a family of emoji, a heart in colour, an Arabic year."""
    for text in ("نمی\u200cخواهم", "👩\u200d👩\u200d👧", "❤\ufe0f", "\u0601١٩٩٩"):
        assert (plain_text.hidden_in(text), plain_text.shown(text)) == ((), text)


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_every_letter_that_there_is_comes_through_every_product(finished_job: FinishedJob, tmp_path: Path) -> None:
    """All of them as notes of a finished run: page, paper, handover."""
    run, letters, share = finished_job.copied_to(tmp_path), all_letters(), 4000
    for start in range(0, len(letters), share):
        note_of_an_older_version(run, " ".join(letters[start : start + share]))  # alone: none is drawn into another
    assert run_command(["solve", str(run)]) == 0
    for shown in _opened(run / "report.html"):
        assert _missing(letters, shown) == []
    # Poppler drops lone marks.
    alone = "".join(letter for letter in letters if unicodedata.category(letter) not in ("Mn", "Me"))
    assert _missing(alone, _words_of_paper(run / "report.pdf")) == []
