"""Whose word a signature is: the name of an account, and the secret that only its person has."""

import sys
from getpass import getpass
from pathlib import Path

from procedures.cli.locations import people_of_here, person_named
from procedures.errors import RequestError

IDENTIFIED_BY_NAME = "the secret of that name"


def signer(operator: str | None, secret_file: Path | None) -> str:
    """Return the name of who signs, once the secret was told. Raises: RequestError; then nothing was signed."""
    people, name = people_of_here(), person_named(operator)
    person = people.find(name)
    if person is None:
        raise RequestError(
            f"{name}: nobody of that name has an account; nothing was signed; give --operator, or calrig console "
            f'people add "{name}"'
        )
    if people.identify(person.name, _secret_of(person.name, secret_file)) is None:
        raise RequestError(f"{person.name}: that is not the secret of this name; nothing was signed")
    return person.name


def _secret_of(name: str, secret_file: Path | None) -> str:
    if secret_file is not None:
        try:
            text = sys.stdin.readline() if str(secret_file) == "-" else secret_file.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise RequestError(f"--secret-file {secret_file}: cannot be read: {error}; nothing was signed") from error
        return text.partition("\n")[0]
    if not sys.stdin.isatty():
        raise RequestError(
            f"{name}: a signature needs the secret of its person; nothing was signed; sign at a terminal, or give "
            "--secret-file (- reads one line from standard input)"
        )
    return getpass(f"secret of {name}: ")
