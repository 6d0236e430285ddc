"""``docs/messages.md`` and the code say the same: no message without its cause, no kind of finding without its row."""

import re
from pathlib import Path

from raised_messages import messages_in, texts_in

from ams.finding_kinds import KINDS, UNUSABLE_AXIS
from procedures.journal.status.stop_advice import ADVICE, IN_GENERAL, advice
from procedures.records.states import State

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "messages.md").read_text(encoding="utf-8")
PARTS = ("procedures/run", "procedures/journal", "procedures/records", "procedures/alerts", "rig/guard")
COMMANDS = (
    "archive_url.py",
    "attend.py",
    "choose_run.py",
    "detach.py",
    "follow.py",
    "people.py",
    "locations.py",
    "run.py",
    "steer.py",
)
"""Of ``procedures/cli``: the commands around a run. The others refuse their own arguments by name and say what they
take."""


def _first_clause(message: str) -> str:
    """What it says before what happened and what to do; the name in front is left out."""
    clauses = [clause for clause in message.split("; ") if clause.strip("…: ")]
    return clauses[0].removeprefix("…: ").removeprefix("…: ").strip()


def _fixed_words(message: str) -> str:
    """The longest stretch of it without a value."""
    return max(message.split("…"), key=len).strip(":; ")


def _messages() -> list[tuple[str, str]]:
    of_commands = [(file, text) for file, text in messages_in(ROOT / "procedures/cli") if file in COMMANDS]
    return [message for part in PARTS for message in messages_in(ROOT / part)] + of_commands


def _documented() -> list[str]:
    return re.findall(r"^\| `([^`]+)` \|", PAGE, flags=re.MULTILINE)


def test_every_message_of_a_run_is_on_the_page() -> None:
    documented = _documented()
    missing = [
        f"{file}: {message}"
        for file, message in _messages()
        if not any(_first_clause(row) == _first_clause(message) for row in documented)
    ]
    assert not missing, "\n".join(missing)


def test_every_message_on_the_page_can_still_be_met() -> None:
    """What a part of the rig says, or a way of an alert, is passed on, and stands in no error of its own."""
    raised = {_first_clause(message) for _, message in _messages()}
    texts = [
        text
        for part in ("rig", "procedures/run", "procedures/jog_screen", "procedures/alerts", "procedures/journal")
        for text in texts_in(ROOT / part)
    ]
    rest = [row for row in _documented() if _first_clause(row) not in raised]
    assert not [row for row in rest if not any(_fixed_words(row) in text for text in texts)]


def test_every_advice_is_on_the_page() -> None:
    said = {cause: advice(cause, State.HELD, IN_GENERAL) for cause in ADVICE}
    assert not [cause for cause, found in said.items() if f"| {cause} | {found} |" not in PAGE]


def test_every_kind_of_finding_is_on_the_page_as_the_table_of_kinds_says_it() -> None:
    _, _, section = PAGE.partition("## Every kind of finding\n")
    said, _, rows = section.partition("| kind | whose | what it means | what to do |\n|---|---|---|---|\n")
    wanted = [f"| {kind} | {row.whose} | {row.meaning} | {row.what_to_do} |" for kind, row in KINDS.items()]
    assert rows.partition("\n\n")[0].splitlines() == wanted
    assert [kind for kind in UNUSABLE_AXIS if f"`{kind}`" not in said] == []
