"""The site is built without a warning, its reference is the code's, and its tutorials work as they are told."""

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from procedures.cli.main import run_command

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs"))
from reference_pages import pages  # noqa: E402

TUTORIALS = ROOT / "docs" / "tutorials"
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def test_the_reference_has_keys_of_drivers_and_kinds_and_every_command_with_its_options() -> None:
    made = pages()
    assert "| `axes.*:zaber.microstep_deg` |" in made["rig-keys.md"]
    assert "| `procedure.kind` | `grid`," in made["procedure-keys.md"]
    assert "### calrig run" in made["commands.md"]
    assert "--rehearse" in made["commands.md"]
    assert "#### calrig archive history" in made["commands.md"]


def blocks_of(page: str, language: str) -> list[str]:
    text = (TUTORIALS / page).read_text(encoding="utf-8")
    return [block for named, block in FENCED.findall(text) if named == language]


def steps_of(page: str) -> list[list[str]]:
    return [shlex.split(line)[1:] for block in blocks_of(page, "") for line in block.splitlines()]


def test_the_tutorial_from_volts_to_angles_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(ROOT / "examples", tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    for step in steps_of("from-volts-to-angles.md"):
        assert run_command(step) == 0, step
    assert len((tmp_path / "angles.csv").read_text("utf-8").splitlines()) == len(
        (tmp_path / "readings.csv").read_text("utf-8").splitlines()
    )
    (code,) = blocks_of("from-volts-to-angles.md", "python")
    exec(compile(code, "tutorial", "exec"), {})


@pytest.mark.thorough
def test_the_first_calibration_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    first, *steps = steps_of("first-calibration.md")
    assert run_command(first) == 0
    (changes,) = blocks_of("first-calibration.md", "toml")
    procedure = tmp_path / "procedure.toml"
    text = procedure.read_text("utf-8")
    heading = ""
    for line in filter(None, changes.splitlines()):
        if line.startswith("["):
            heading = re.escape(line)
            continue
        key = line.partition(" =")[0]
        text, count = re.subn(
            rf"^({heading}\n(?:[^\[].*\n|\n)*?){key} = .*$", rf"\g<1>{line}", text, flags=re.MULTILINE
        )
        assert count == 1, key
    assert tomllib.loads(text)["check"] == tomllib.loads(procedure.read_text("utf-8"))["check"]
    procedure.write_text(text, encoding="utf-8")
    for step in steps:
        assert run_command(step) == 0, step
    assert (tmp_path / "tables" / "dwells.csv").exists()
    (run,) = (tmp_path / "runs").glob("*/report.html")
    assert [path.stem for path in (run.parent / "coefficients").glob("*.json")] == ["SN1"]


@pytest.mark.thorough
@pytest.mark.timeout(600)
def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-q", "-W", "--keep-going", "-d", str(tmp_path / "d")]
    done = subprocess.run([*command, "docs", str(tmp_path / "site")], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "site" / "search.html").exists()
    assert list(dead_links(tmp_path / "site")) == []


class Links(HTMLParser):
    """Where the links of a page lead, and what on it can be led to."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.targets: list[str] = []
        self.loaded: list[str] = []
        self.anchors = {""}
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value or "")
            elif name in ("href", "src") and value is not None:
                self.targets.append(value)
                if tag != "a":
                    self.loaded.append(value)


def dead_links(site: Path) -> Iterator[str]:
    """Every link inside the site that leads nowhere: no such file, or no such place on its page."""
    pages = {page: Links(page) for page in site.rglob("*.html")}
    assert len(pages) > 50
    for page, links in pages.items():
        yield from (
            f"{page.name} loads {url}, which no offline copy has" for url in links.loaded if urlsplit(url).netloc
        )
        for target in links.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            there = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            there = there / "index.html" if there.is_dir() else there
            is_there = there.exists() and (there not in pages or unquote(parts.fragment) in pages[there].anchors)
            if not is_there:
                yield f"{page.relative_to(site)}: {target}"
