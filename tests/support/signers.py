"""People who sign in tests: each with an account, and the file of the secret that they share there."""

from pathlib import Path

import pytest
from journals import START_UTC

from procedures.accounts.people import People

SECRET = bytes(10)


def with_accounts(folder: Path, patch: pytest.MonkeyPatch, *names: str) -> list[str]:
    """Give the names accounts; return the words that tell the secret."""
    people = People(folder / "people.json", new_secret=lambda: SECRET, cost=2)
    secrets = {people.add(name, "watch", START_UTC) for name in names}
    (folder / "secret").write_text("".join(secrets) + "\n")
    patch.setenv("CALRIG_PEOPLE", str(people.path))
    return ["--secret-file", str(folder / "secret")]
