"""The paper against outside readers: pikepdf for the structure, poppler for the text; the page itself is the oracle."""

import os
import re
import subprocess
import sys
from datetime import UTC, datetime
from html import escape
from io import BytesIO
from pathlib import Path

import pikepdf
import pytest
from programs import require_program

from procedures.pages import with_whole_options
from procedures.report.paper.page_tree import Element, page_tree_of
from procedures.report.paper.pdf import Attachment, Imprint, paper_of

PICTURE = "data:image/svg+xml,%3Csvg xmlns=%22http://www.w3.org/2000/svg%22 width=%2240%22 height=%2220%22/%3E"
PAGE = f"""<!doctype html><html lang="en"><head><title>gone</title><style>b {{}}</style></head>
<body class="simulated"><nav><a href="#x">only on screen</a></nav>
<header><div class="kind">Calibration report</div><h1>Balance &lt;#7&gt; "$x$" \\ *star* @ref</h1>
<div class="stamp">SIMULATED <span>no real sensor</span></div>
<section class="verdict reserved"><p>Sound but for one thing.</p><ul><li>a ground</li></ul></section>
<dl class="facts"><div><dt>Rig</dt><dd>table of 1″</dd></div></dl></header>
<h2 id="s">Sensor</h2><p>An <i>italic</i> and a <b>bold</b> word,
  broken    over lines; −0.5 °, 3 µV, F₀.₉₅, Ω, û.</p>
<table><thead><tr><th>Axis</th><th class="n">Value<br>of b</th><th>Remark</th></tr></thead>
<tbody><tr class="first"><td>x</td><td class="n">0.005<span class="g">123</span></td><td class="w">fits</td></tr>
<tr><td>y</td><td class="none" colspan="2">not determined</td></tr></tbody></table>
<figure id="f"><img src="{PICTURE}" alt="nothing"><figcaption><b>One.</b> Caption.</figcaption></figure>
<section class="sign"><div>By: A. Person<br>Date</div><div>Approved</div></section>
<footer class="small">Relates only to the items named.</footer></body></html>"""
IMPRINT = Imprint("A title", ("SIMULATED",), "Run 7", datetime(2026, 3, 1, 12, 30, tzinfo=UTC))
LEFT_TO_RIGHT = "\u200e"
"""Around code points, and seen by nobody."""
ATTACHED = Attachment("SN1.xml", "application/xml", "SN1: certificate", b"<dcc/>\n")


@pytest.fixture(scope="module")
def pdf() -> bytes:
    return paper_of(PAGE, IMPRINT, [ATTACHED])


def _words(pdf: bytes, tmp_path: Path) -> str:
    program = require_program("pdftotext")
    (tmp_path / "paper.pdf").write_bytes(pdf)
    text = subprocess.run([program, "-layout", tmp_path / "paper.pdf", "-"], capture_output=True, check=True).stdout
    return " ".join(text.decode("utf-8").replace(LEFT_TO_RIGHT, "").split())


def test_the_file_declares_itself_pdf_a_3b(pdf: bytes) -> None:
    with pikepdf.open(BytesIO(pdf)) as document, document.open_metadata() as metadata:
        assert metadata.pdfa_status == "3B"
        assert metadata["dc:title"] == "A title"
        assert not document.is_encrypted
        assert "/OutputIntents" in document.Root  # ISO 19005-3, 6.2.3: the colour space is said


def test_every_font_is_inside(pdf: bytes) -> None:
    with pikepdf.open(BytesIO(pdf)) as document:
        fonts = [item for item in document.objects if isinstance(item, pikepdf.Dictionary) and "/FontName" in item]
        assert fonts
        assert all(any(f"/FontFile{kind}" in font for kind in ("", "2", "3")) for font in fonts)


def test_attachments_come_back_byte_for_byte_and_are_associated_with_the_document(pdf: bytes) -> None:
    with pikepdf.open(BytesIO(pdf)) as document:
        (name,) = document.attachments
        assert name.endswith("SN1.xml")
        assert document.attachments[name].get_file().read_bytes() == ATTACHED.content
        (associated,) = document.Root.AF  # ISO 19005-3, 6.8
        assert associated.AFRelationship == "/Data"


def test_the_paper_says_what_the_page_says(pdf: bytes, tmp_path: Path) -> None:
    words = _words(pdf, tmp_path)
    for text in (
        'Balance <#7> "$x$" \\ *star* @ref', "SIMULATED no real sensor", "Sound but for one thing.", "a ground",
        "table of 1″", "An italic and a bold word, broken over lines; −0.5 °, 3 µV, F₀.₉₅, Ω, û.", "fits",
        "not determined", "One. Caption.", "By: A. Person", "Relates only to the items named.", "page 1 of 1", "Run 7",
    ):  # fmt: skip
        assert text in words, text
    assert re.search(r"0\.005 ?123", words)
    assert "only on screen" not in words
    assert "gone" not in words


def test_a_reprint_is_the_same_file(pdf: bytes) -> None:
    assert paper_of(PAGE, IMPRINT, [ATTACHED]) == pdf


@pytest.mark.skipif(sys.platform != "linux", reason="the memory of a process is read from /proc")
def test_the_papers_of_many_packages_take_the_memory_of_one() -> None:
    """Two hundred rows each, none like another; a document takes 20 MB while it is set."""

    def set_paper(number: int) -> float:
        rows = "".join(f"<tr><td>{number}</td><td>{row * number}</td><td>word {row}</td></tr>" for row in range(200))
        head = "<thead><tr><th>a</th><th>b</th><th>c</th></tr></thead>"
        paper_of(f"<html><body><h1>P</h1><table>{head}<tbody>{rows}</tbody></table></body></html>", IMPRINT)
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

    after_mb = [set_paper(number) for number in range(8)]
    assert after_mb[-1] - after_mb[1] < 30.0


def test_an_element_without_a_form_on_paper_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="no form of <video>"):
        page_tree_of("<body><video></video></body>")


def test_a_picture_from_elsewhere_is_refused() -> None:
    with pytest.raises(ValueError, match=re.escape("https://elsewhere/x.svg")):
        page_tree_of('<body><img src="https://elsewhere/x.svg" alt=""></body>')


def test_white_space_collapses_as_in_a_browser() -> None:
    (body,) = (child for child in page_tree_of("<body><p>  a\n b <b> c</b> <br> d </p></body>").body.children)
    assert isinstance(body, Element)
    (paragraph,) = body.children
    assert isinstance(paragraph, Element)
    assert paragraph.children[0] == "a b "
    assert paragraph.children[-1] == "d"


def test_fault_78_every_letter_of_every_script_is_printed_or_named(tmp_path: Path) -> None:
    """Detected: which letters the fonts inside the distribution have.
    Response: every other one is printed as its code point; the page on the screen shows it as it is.
    """
    letters = [chr(code) for code in (*range(0x20, 0x3000, 16), *range(0x3000, 0x110000, 256))]
    rows = "".join(f"<p>{escape(letter)} {letter.encode('utf-8', 'replace').hex()}</p>" for letter in letters)
    made = paper_of(f"<html><body><h1>Zoë 🙂 李雷 👍</h1>{rows}</body></html>", IMPRINT)
    found = _words(made, tmp_path)
    assert "Zoë <U+1F642> <U+674E><U+96F7> <U+1F44D>" in found
    assert "<U+2030>" not in found


def _but_bold(text: str) -> str:
    return re.sub("&lt;(/?b)&gt;", r"<\1>", escape(text))


FORMS = ["{0} 李雷 {0}", "{0}李{0}", "李{0}雷", "({0}) <U+202E>{0}<U+202C>", "<b>{0}</b>李雷, 7"]
RIGHT_TO_LEFT = {"Hebrew": "שלום", "Arabic": "مرحبا", "Arabic digits": "١٢٣", "Hebrew and digits": "חדר 12"}


@pytest.mark.parametrize("beside", RIGHT_TO_LEFT.values(), ids=RIGHT_TO_LEFT)
@pytest.mark.parametrize(
    "form", ["{0} 李雷 {0}", "{0}李{0}", "李{0}雷", "({0}) <U+202E>{0}<U+202C>", "<b>{0}</b>李雷, 7"]
)
def test_a_code_point_beside_letters_from_right_to_left_is_whole(form: str, beside: str, tmp_path: Path) -> None:
    """Its angle brackets have no direction of their own: they were turned and put at the ends of the words beside."""
    text = form.format(beside)
    named = re.findall(r"<U\+[0-9A-F]+>", re.sub("[李雷]", lambda found: f"<U+{ord(found[0]):04X}>", text))
    words = _words(paper_of(f"<html><body><p>{_but_bold(text)}</p></body></html>", IMPRINT), tmp_path)
    assert re.findall(r"<U\+[0-9A-F]+>", words) == named
    assert all(word in words for word in beside.split())


def test_no_line_breaks_inside_an_option_of_a_printed_command(tmp_path: Path) -> None:
    """A command is pasted from the paper: what stands before it is of every length, so that every place is tried."""
    sentences = "".join(
        f"<p>{'m' * length} calrig redo --replication 1 --operator NAME --reason TEXT</p>" for length in range(40, 100)
    )
    page = PAGE.replace('<h2 id="s">', f'{sentences}<h2 id="s">')
    for name, text in (("as-it-was", page), ("whole", with_whole_options(page))):
        (tmp_path / f"{name}.pdf").write_bytes(paper_of(text, IMPRINT, []))
    ends = {
        name: [line for line in _lines(tmp_path / f"{name}.pdf") if line.rstrip().endswith("-")]
        for name in ("as-it-was", "whole")
    }
    assert ends["as-it-was"], "the scene tries the places where a line would break"
    assert ends["whole"] == []


def test_only_text_is_marked_and_the_rest_of_a_page_stays_as_it_is() -> None:
    page = '<head><style>a { color: var(--ink) } b { --x: 1 }</style></head><p title="a --b c">--x-y (--z) a--b −1</p>'
    whole = with_whole_options(page.replace("<p", "<p>calrig --reason TEXT</p><p"))
    assert whole.count('<span class="option">') == 2
    assert 'calrig <span class="option">--reason</span> TEXT' in whole
    assert re.sub(r'<span class="option">(.*?)</span>', r"\1", whole) == page.replace(
        "<p", "<p>calrig --reason TEXT</p><p"
    )


def _lines(path: Path) -> list[str]:
    program = require_program("pdftotext")
    text = subprocess.run([program, "-layout", path, "-"], capture_output=True, check=True).stdout.decode("utf-8")
    return text.replace(LEFT_TO_RIGHT, "").splitlines()
