"""Chance by counters: every random number of a twin has an address, and the address has one number.

The noise of a reading is drawn from the key (seed, source) at the counter (step, phase, attempt, running number
since the announcement), by Philox: never from time and never from what was drawn before. So an interrupted run
that is resumed sees the noise that its uninterrupted brother saw, and a run over real ports that of a run in memory.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np

_BLOCK = 32
_WORD = 2**64


@dataclass(frozen=True, slots=True)
class Announcement:
    """Which step the twins are being measured for."""

    step: int
    phase: str
    attempt: int
    replications: float
    """Replications completed so far: drift follows it."""


NOTHING_ANNOUNCED = Announcement(step=-1, phase="unannounced", attempt=0, replications=0.0)


class Chance:
    """Random numbers by address. Not shared between threads."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self._announcement = NOTHING_ANNOUNCED
        self._running: dict[str, Iterator[float]] = {}
        self._keys: dict[str, int] = {}

    @property
    def announcement(self) -> Announcement:
        return self._announcement

    def announce(self, announcement: Announcement) -> None:
        """Start the running numbers from zero under a new address."""
        self._announcement = announcement
        self._running.clear()

    def normal(self, source: str) -> float:
        """Return the next standard normal number of ``source`` since the announcement."""
        running = self._running.get(source)
        if running is None:
            key = self._keys.get(source)
            if key is None:
                key = self._keys[source] = _hash(f"{self.seed}|{source}", 16)
            now = self._announcement
            # From the second word on: the lowest counts the blocks that one address has given.
            words = (now.step % _WORD, _hash(now.phase, 8), now.attempt % _WORD)
            counter = sum(word << 64 * index for index, word in enumerate(words, start=1))
            running = self._running[source] = _normals(np.random.Generator(np.random.Philox(key=key, counter=counter)))
        return next(running)

    def fixed(self, *address: object) -> np.random.Generator:
        """Return a generator of its own for what never changes: a tooth's error, a mounting."""
        return np.random.Generator(np.random.Philox(key=_hash(f"{self.seed}|fixed|{'|'.join(map(str, address))}", 16)))


def _normals(generator: np.random.Generator) -> Iterator[float]:
    """Yield blocks drawn as needed: the n-th number is the same however many are taken."""
    while True:
        yield from generator.standard_normal(_BLOCK).tolist()


def _hash(text: str, size: int) -> int:
    return int.from_bytes(blake2b(text.encode(), digest_size=size).digest(), "little")
