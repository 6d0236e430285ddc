"""Who is in: by a link that works once or by name and secret, then a cookie for twelve hours.

Only hashes are kept, and only in memory. A session of a person ends with the account, with another role of it and with
another secret. Wrong tries cost time: a link's lock the way in for everybody, a secret's that name.
"""

import hashlib
import secrets
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from procedures.accounts.people import People, Person, Role, same_name
from procedures.errors import RequestError
from rig.clock import Clock

LIFE_S = 12 * 3600.0
MOST = 32
"""Sessions at once."""
OF_AN_ACCOUNT, BY_LINKS = 4, 12
"""Of these at once: a new session ends the oldest of its own account, or of those by links, and nobody else's. As many
as of one account are left to who enters by a link: accounts alone never take every place."""
ALL_TAKEN = (
    f"all {MOST - OF_AN_ACCOUNT} sessions that accounts may have at once are open, and none is yours; nobody was let "
    "in; somebody has to leave first; what stops at once is the button at the machine"
)
MOST_WRONG = 20
LOCKED_S = 60.0
"""After so many wrong keys nobody enters by a link for so long."""
MOST_WRONG_SECRETS = 5
LONGEST_LOCK_S = 3600.0
"""After so many wrong secrets a name is locked: for a minute, then for twice that with every further one."""
ACTS, ACTS_WITHIN_S = 30, 60.0
"""So many acts of one session in so long; what stops axes is not counted."""


@dataclass(frozen=True, slots=True)
class Visitor:
    """Who asks."""

    name: str
    role: Role
    token: str
    """Hashed: what the console knows the session by."""
    csrf: str
    """What every act of this session carries, and no page of another site knows."""
    account: Person | None
    """None where the visitor came by the link: whoever reads the terminal of the console."""
    until_s: float
    may_move: bool = False
    """Whether it told the code that stands at the rig: it may begin motion from elsewhere."""


@dataclass
class _Tries:
    """Wrong ones of one name."""

    wrong: int = 0
    locked_until_s: float = 0.0

    def is_locked(self, now_s: float) -> bool:
        return now_s < self.locked_until_s

    def fail(self, now_s: float, most: int) -> None:
        self.wrong += 1
        if self.wrong >= most:
            self.locked_until_s = now_s + min(LOCKED_S * 2.0 ** (self.wrong - most), LONGEST_LOCK_S)


@dataclass
class Sessions:
    """Of one console, in one thread."""

    clock: Clock
    people: People
    host_name: str = ""
    """Whom a link stands for: who started the console."""
    new_secret: Callable[[], str] = lambda: secrets.token_urlsafe(32)
    _key: str = ""
    _code: str = ""
    _visitors: dict[str, Visitor] = field(default_factory=dict)
    _links: _Tries = field(default_factory=_Tries)
    _codes: _Tries = field(default_factory=_Tries)
    _names: dict[str, _Tries] = field(default_factory=dict)
    _acts: dict[str, list[float]] = field(default_factory=dict)

    def new_key(self) -> str:
        """Return what the next browser enters with; the key before it is worth nothing any more."""
        key = self.new_secret()
        self._key = _hashed(key)
        return key

    def new_code(self) -> str:
        """Return what a browser of another machine tells before it may begin motion; the one before is void."""
        code = f"{int.from_bytes(hashlib.sha256(self.new_secret().encode()).digest()[:8]) % 10**8:08d}"
        self._code = _hashed(code)
        return f"{code[:4]} {code[4:]}"

    def is_link_locked(self) -> bool:
        """Return whether too many wrong keys were tried: then not even the right one is looked at."""
        return self._links.is_locked(self.clock.monotonic_s())

    def enter(self, key: str, before: str | None = None, *, counts: bool = True) -> str | None:
        """Return the token of a new session and forget the key; None where it is not the key.

        ``before``: a token that the browser has already; its session ends. ``counts``: whether a wrong key counts as a
        try; what pages of other sites ask, which anybody's browser may be shown, locks nobody out.
        """
        if self.is_link_locked():
            return None
        if not self._key or not secrets.compare_digest(_hashed(key), self._key):
            if counts:
                self._links.fail(self.clock.monotonic_s(), MOST_WRONG)
            if self.is_link_locked():
                self._links.wrong = 0
            return None
        self._key, self._links = "", _Tries()
        return self._begin(self.host_name, "move", None, before)

    def is_locked(self, name: str) -> bool:
        """Return whether too many secrets were tried for a name: then none is even looked at."""
        return self._tries_of(name).is_locked(self.clock.monotonic_s())

    def log_in(self, name: str, person: Person | None, before: str | None = None) -> str | None:
        """Return the token of a new session; None for nobody, which counts as a wrong try for that name.

        Raises: RequestError where accounts have every place, and this one has none.
        """
        if person is None:
            self._tries_of(name).fail(self.clock.monotonic_s(), MOST_WRONG_SECRETS)
            return None
        self._names.pop(same_name(name), None)
        return self._begin(person.name, person.role, person, before)

    def tell_code(self, token: str | None, code: str) -> bool:
        """Let a session begin motion from elsewhere where it tells the code, which is then used up."""
        now_s, visitor = self.clock.monotonic_s(), self.visitor(token)
        if visitor is None or self._codes.is_locked(now_s):
            return False
        if not self._code or not secrets.compare_digest(_hashed("".join(code.split())), self._code):
            self._codes.fail(now_s, MOST_WRONG_SECRETS)
            return False
        self._code, self._codes = "", _Tries()
        self._visitors[visitor.token] = replace(visitor, may_move=True)
        return True

    def end(self, token: str | None) -> None:
        """Forget a session."""
        if token:
            self._forget(_hashed(token))

    def visitor(self, token: str | None) -> Visitor | None:
        """Return whose session it is; None for one that has ended, or whose account is another now."""
        found = self._visitors.get(_hashed(token)) if token else None
        if found is None:
            return None
        if self._has_ended(found):
            self._forget(found.token)
            return None
        return found

    def _has_ended(self, visitor: Visitor) -> bool:
        is_over = self.clock.monotonic_s() >= visitor.until_s
        return is_over or (visitor.account is not None and self.people.find(visitor.name) != visitor.account)

    def _forget(self, hashed: str) -> None:
        self._visitors.pop(hashed, None)
        self._acts.pop(hashed, None)

    def counts_act(self, visitor: Visitor) -> bool:
        """Count an act of a session; False where it has done too many."""
        now_s = self.clock.monotonic_s()
        done = [act_s for act_s in self._acts.get(visitor.token, []) if now_s - act_s < ACTS_WITHIN_S]
        is_allowed = len(done) < ACTS
        self._acts[visitor.token] = [*done, now_s] if is_allowed else done
        return is_allowed

    def _begin(self, name: str, role: Role, account: Person | None, before: str | None) -> str:
        self._make_room(account, "" if before is None else _hashed(before))
        self.end(before)
        token = self.new_secret()
        until_s = self.clock.monotonic_s() + LIFE_S
        hashed = _hashed(token)
        self._visitors[hashed] = Visitor(name, role, hashed, self.new_secret(), account, until_s)
        return token

    def _make_room(self, account: Person | None, leaving: str) -> None:
        """End the oldest session of the same account, or of those by links, where there are too many.

        Raises: RequestError where there is none that could end.
        """
        for ended in [visitor for visitor in self._visitors.values() if self._has_ended(visitor)]:
            self._forget(ended.token)
        stay = [visitor for visitor in self._visitors.values() if visitor.token != leaving]
        same = [visitor for visitor in stay if visitor.account == account]
        by_accounts = sum(visitor.account is not None for visitor in stay)
        is_full = len(stay) >= MOST or (account is not None and by_accounts >= MOST - OF_AN_ACCOUNT)
        if is_full and not same:
            raise RequestError(ALL_TAKEN)
        if is_full or len(same) >= (BY_LINKS if account is None else OF_AN_ACCOUNT):
            self._forget(same[0].token)

    def _tries_of(self, name: str) -> _Tries:
        while len(self._names) > 1000:
            self._names.pop(next(iter(self._names)))
        return self._names.setdefault(same_name(name), _Tries())


def _hashed(secret: str) -> str:
    return hashlib.sha256(secret.encode("utf-8", errors="surrogateescape")).hexdigest()
