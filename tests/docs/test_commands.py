"""What the pages tell a reader to type exists, and what the README tells a new user to try works as printed."""

import contextlib
import io
import re
import shlex
import shutil
from functools import cache
from itertools import takewhile
from pathlib import Path

import pytest

from procedures.cli.main import GROUPS, run_command

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [
    Path("README.md"),
    Path("CONTRIBUTING.md"),
    *sorted(entry.relative_to(ROOT) for entry in (ROOT / "docs").rglob("*.md")),
]
FENCED = re.compile(r"^```[a-z]*\n(.*?)^```", flags=re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`(calrig [^`\n]+)`")
NOT_TYPED = ("calrig coefficient set",)
"""The name of a format."""
NAMES = {name for commands in GROUPS.values() for name, _, _ in commands}


def _typed(page: Path) -> list[str]:
    text = (ROOT / page).read_text(encoding="utf-8")
    lines = [line.removeprefix("$ ") for block in FENCED.findall(text) for line in block.splitlines()]
    typed = [line for line in lines if line.startswith("calrig ")] + INLINE.findall(FENCED.sub("", text))
    return [entry for entry in typed if entry not in NOT_TYPED]


@cache
def _help(command: tuple[str, ...]) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as output:
        assert run_command([*command, "--help"]) == 0
    return output.getvalue()


def _command_of(words: list[str]) -> tuple[str, ...]:
    deepest = {"archive": 2, "queue": 2, "console": 3}.get(words[0], 1)
    return tuple(takewhile(str.isalpha, words[:deepest]))


def _unknown_in(typed: str) -> list[str]:
    words = typed.split("#")[0].split()[1:]
    options = {re.sub(r"[^a-z0-9-].*", "", word) for word in words if word.startswith("--")}
    if words[0] == "COMMAND" or words[0].startswith("--"):
        return sorted(options - {"--help", "--version", "--json", "--install-completion"})
    if words[0] not in NAMES:
        return words[:1]
    found = _help(_command_of(words))
    return [option for option in sorted(options) if f"{option} " not in found]


@pytest.mark.usefixtures("wide_terminal")
@pytest.mark.parametrize("page", PAGES, ids=str)
def test_every_command_on_a_page_exists_with_its_options(page: Path) -> None:
    assert {typed: unknown for typed in _typed(page) if (unknown := _unknown_in(typed))} == {}


def test_the_readme_leads_to_every_page() -> None:
    pages = [page.as_posix() for page in PAGES if page.parent.as_posix() in ("docs", "docs/studies")]
    assert [page for page in pages if f"]({page})" not in README] == []


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_no_link_leads_nowhere(page: Path) -> None:
    if page.name.endswith(".template.md"):
        return  # its links hold where the page that is made of it stands
    links = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", (ROOT / page).read_text(encoding="utf-8"))
    assert [link for link in links if "://" not in link and not (ROOT / page.parent / link).exists()] == []


def _to_try() -> list[str]:
    block = re.search(r"## Try it\n\n```\n(.*?)```", README, flags=re.DOTALL)
    assert block is not None
    return [line.split("#")[0].strip() for line in block[1].splitlines()]


def test_what_a_new_user_is_told_to_try_works_as_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The two whole jobs are left out: they take half a minute each, and tests/procedures/cli runs smaller ones."""
    activate, *commands = _to_try()
    assert activate == ". .venv/bin/activate"
    assert [line for line in commands if not line.startswith("calrig ")] == []
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    (tmp_path / "demo-out").mkdir()  # calrig demo stands above
    monkeypatch.chdir(tmp_path)
    for line in commands:
        words = shlex.split(line)[1:]
        if words[0] not in ("demo", "run"):
            assert run_command(words) == 0, line
    first = (tmp_path / "demo-out" / "angles.csv").read_text(encoding="utf-8").splitlines()[1]
    pitch_deg, pitch_sd_deg = (float(cell) for cell in first.split(",")[:2])
    assert abs(pitch_deg) < 5.0 * pitch_sd_deg < 0.002  # the first reading of the example is level
