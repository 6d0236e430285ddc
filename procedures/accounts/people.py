"""People of this machine: names, roles, and of each secret a hash that is slow to guess (scrypt, RFC 7914).

A secret is made here and told once, so nobody has one that is used elsewhere or can be guessed; who loses it is given
another. The file belongs to the account of the system that runs calrig: whoever may write to it may add people.
"""

import hashlib
import json
import os
import secrets
from base64 import b32encode
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Literal, get_args

from ams.whole_file import FolderNotSynced, replace_file
from procedures.errors import RequestError, StorageFailed
from rig.plain_text import hidden_in

Role = Literal["watch", "operate", "move"]
ROLES: tuple[Role, ...] = get_args(Role)
"""Each may what those before it may: look; steer runs and the queue; begin motion."""
FORMAT = "calrig people 1"
LONGEST_NAME = 64
COST = 2**15
"""Of scrypt: with blocks of 8 that is 32 MB and a tenth of a second for each guess."""
_BLOCKS = 8
_SECRET_BYTES = 10


@dataclass(frozen=True, slots=True)
class Person:
    """One account."""

    name: str
    role: Role
    salt: str
    hashed: str
    cost: int
    added_utc: str


@dataclass
class People:
    """The file of accounts; it is read again where it has changed."""

    path: Path
    new_secret: Callable[[], bytes] = lambda: secrets.token_bytes(_SECRET_BYTES)
    cost: int = COST
    _seen: tuple[int, int, int] | None = None
    _known: Mapping[str, Person] = field(default_factory=dict)

    def read(self) -> Mapping[str, Person]:
        """Return the people by :func:`same_name` of each. Raises: RequestError for a file that is none."""
        try:
            with self.path.open("rb") as file:
                found = os.fstat(file.fileno())
                mark = (found.st_ino, found.st_mtime_ns, found.st_size)
                if mark != self._seen:
                    self._known, self._seen = _people(file.read()), mark
        except FileNotFoundError:
            self._known, self._seen = {}, None
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise RequestError(f"{self.path}: is no file of people: {error}; nobody was let in; mend it") from error
        return self._known

    def find(self, name: str) -> Person | None:
        """Return who has the name, whatever its case and spaces. Raises: RequestError."""
        return self.read().get(same_name(name))

    def add(self, name: str, role: str, now: datetime, *, renews: bool = False) -> str:
        """Add a person, or renew one's secret and role; returns the secret, which is kept nowhere.

        Raises: RequestError, StorageFailed.
        """
        plain = " ".join(name.split())
        if not plain or len(plain) > LONGEST_NAME or hidden_in(plain):
            raise RequestError(
                f"people: got the name {name!r}, needed is one of 1 to {LONGEST_NAME} characters that can be seen; "
                "nobody was added"
            )
        wanted = next((known for known in ROLES if known == role), None)
        if wanted is None:
            raise RequestError(f"people: got the role {role!r}, allowed are {', '.join(ROLES)}; nobody was added")
        known = dict(self.read())
        if (same_name(plain) in known) != renews:
            complaint = (
                "there is nobody of that name" if renews else "has an account already; --renew gives a new secret"
            )
            raise RequestError(f"people: {plain}: {complaint}; nothing was changed")
        secret = _as_words(self.new_secret())
        salt = secrets.token_hex(16)
        person = Person(plain, wanted, salt, _hashed(secret, salt, self.cost), self.cost, now.isoformat())
        self._write({**known, same_name(plain): person})
        return secret

    def remove(self, name: str) -> None:
        """Take an account away; its sessions end with it. Raises: RequestError, StorageFailed."""
        known = dict(self.read())
        if known.pop(same_name(name), None) is None:
            raise RequestError(f"people: {name}: there is nobody of that name; nothing was changed")
        self._write(known)

    def identify(self, name: str, secret: str) -> Person | None:
        """Return the person whose secret it is; None for anybody else. A name that is not there takes as long.

        Raises: RequestError.
        """
        found = self.find(name)
        against = found or Person("", "watch", "00" * 16, "", self.cost, "")
        is_right = secrets.compare_digest(_hashed(secret, against.salt, against.cost), against.hashed)
        return found if is_right else None

    def _write(self, people: Mapping[str, Person]) -> None:
        document = {"format": FORMAT, "people": [asdict(person) for person in people.values()]}
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            replace_file(self.path, json.dumps(document, ensure_ascii=False, indent=1).encode())
            self.path.chmod(0o600)
        except FolderNotSynced:
            pass  # it is there; only a power cut could take it back
        except OSError as error:
            raise StorageFailed(f"{self.path}: cannot be written: {error.strerror}; nobody was changed") from error
        self._seen = None


def same_name(name: str) -> str:
    """Return what two ways of writing one name have in common, as the archive compares names."""
    return " ".join(name.casefold().split())


def _people(content: bytes) -> dict[str, Person]:
    document = json.loads(content)
    if document["format"] != FORMAT:
        raise ValueError(f"format {document['format']!r}, known is {FORMAT!r}")
    found = [Person(**entry) for entry in document["people"]]
    if unknown := [person.role for person in found if person.role not in ROLES]:
        raise ValueError(f"role {unknown[0]!r}, allowed are {', '.join(ROLES)}")
    return {same_name(person.name): person for person in found}


def _as_words(content: bytes) -> str:
    """``abcd-efgh-ijkl-mnop``: what can be read out and typed on a phone."""
    letters = b32encode(content).decode().rstrip("=").lower()
    return "-".join(letters[start : start + 4] for start in range(0, len(letters), 4))


def _hashed(secret: str, salt: str, cost: int) -> str:
    typed = "".join(secret.lower().split()).replace("-", "").encode("utf-8", errors="surrogateescape")
    return hashlib.scrypt(
        typed, salt=bytes.fromhex(salt), n=cost, r=_BLOCKS, p=1, maxmem=256 * cost * _BLOCKS + 2**20, dklen=32
    ).hex()
