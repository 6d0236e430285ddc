"""Who may look: a link that works once, then a cookie for twelve hours; only hashes are kept, and only in memory."""

import hashlib
import secrets
from collections.abc import Callable
from dataclasses import dataclass, field

from rig.clock import Clock

LIFE_S = 12 * 3600.0
MOST = 32
"""Sessions at once; the oldest ends for a new one."""
MOST_WRONG = 20
LOCKED_S = 60.0
"""After so many wrong keys nobody enters for so long."""


@dataclass
class Sessions:
    """Of one console, in one thread."""

    clock: Clock
    new_secret: Callable[[], str] = lambda: secrets.token_urlsafe(32)
    _key: str = ""
    _until_s: dict[str, float] = field(default_factory=dict)
    _wrong: int = 0
    _locked_until_s: float = 0.0

    def new_key(self) -> str:
        """Return what the next browser enters with; the key before it is worth nothing any more."""
        key = self.new_secret()
        self._key = _hashed(key)
        return key

    def enter(self, key: str) -> str | None:
        """Return the token of a new session and forget the key; None where it is not the key."""
        now_s = self.clock.monotonic_s()
        if now_s < self._locked_until_s:
            return None
        if not self._key or not secrets.compare_digest(_hashed(key), self._key):
            self._wrong += 1
            if self._wrong >= MOST_WRONG:
                self._wrong, self._locked_until_s = 0, now_s + LOCKED_S
            return None
        self._key, self._wrong = "", 0
        while len(self._until_s) >= MOST:
            del self._until_s[next(iter(self._until_s))]
        token = self.new_secret()
        self._until_s[_hashed(token)] = now_s + LIFE_S
        return token

    def knows(self, token: str | None) -> bool:
        """Return True for the token of a session that has not ended."""
        if not token:
            return False
        name = _hashed(token)
        until_s = self._until_s.get(name)
        if until_s is None:
            return False
        if self.clock.monotonic_s() >= until_s:
            del self._until_s[name]
            return False
        return True


def _hashed(secret: str) -> str:
    return hashlib.sha256(secret.encode("utf-8", errors="surrogateescape")).hexdigest()
