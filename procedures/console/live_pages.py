"""Who follows runs by a socket: so many places, and of whoever has the most of them the longest there makes room."""

from collections import Counter
from dataclasses import dataclass, field

MOST_SOCKETS = 64
"""Pages that follow runs, of all sessions: sixty tabs that somebody forgot, and a few that are looked at."""
PUT_ASIDE = 1013
"""The code of a socket's end by which a page knows that it need not ask again by itself."""
ALL_TAKEN = f"{MOST_SOCKETS} pages follow runs already; close some, then touch this one: it asks again"


@dataclass(eq=False)
class LivePage:
    """Of one page."""

    session: str
    leaves: bool = False
    """Whether it makes room for another."""


@dataclass
class LivePages:
    """Of one console, in one thread."""

    _taken: list[LivePage] = field(default_factory=list)

    def take(self, session: str) -> LivePage | None:
        """Return a place; None where nobody has two more than this session would have."""
        if len(self._taken) >= MOST_SOCKETS:
            have = Counter(page.session for page in self._taken)
            most, count = have.most_common(1)[0]
            if count < have[session] + 2:
                return None
            leaving = next(page for page in self._taken if page.session == most)
            self.give_back(leaving)
            leaving.leaves = True
        self._taken.append(page := LivePage(session))
        return page

    def give_back(self, page: LivePage) -> None:
        """Free it; twice is harmless."""
        if page in self._taken:
            self._taken.remove(page)
