"""The parts that a run leaves, and what became of each while they are made: one that fails hinders no other."""

import traceback
from collections.abc import Callable, Iterable
from typing import Final, TypeVar

from ams.errors import AmsError
from ams.exports.optional_libraries import missing_sentence
from rig.defects import defect_text

PARTS: Final = ("set", "archive", "lessons", "exports", "html", "pdf")
"""What a run leaves, in the order in which it is made; each part succeeds or fails by itself."""
DONE: Final = "done"
NOT_DUE: Final = "not due"
"""How the word for a part begins that the run does not leave."""
NOT_MADE: Final = "not made"
"""How the word for a part begins that rests on another that failed."""

Made = TypeVar("Made")


class Parts:
    """What became of each part so far. ``run``: as a shell takes it, for the commands in what is told."""

    def __init__(self, run: str) -> None:
        self._run = run
        self._outcomes: dict[str, str] = {}
        self.tracebacks: dict[str, str] = {}
        """Of the parts that a defect hindered."""

    def made(self, part: str, make: Callable[[], Made]) -> Made | None:
        """Make a part and return it; None where it failed, which is kept as a sentence."""
        again = f"calrig solve {self._run}"
        try:
            made = make()
        except AmsError as error:
            self._outcomes[part] = str(error)
        except ModuleNotFoundError as error:
            self._outcomes[part] = f"{missing_sentence(error.name or part)}; then {again} makes it"
        except OSError as error:
            self._outcomes[part] = f"{error.filename or part}: {error.strerror or error}; {again} makes it"
        except Exception as error:  # noqa: BLE001  a rim: a defect in one part takes no other part from the laboratory
            self._outcomes[part] = (
                f"{defect_text(error)}; every dwell of the run is kept in its journal: send the run's folder; "
                f"{again} with a newer version of calrig does it"
            )
            self.tracebacks[part] = "".join(traceback.format_exception(error))
        else:
            self._outcomes.setdefault(part, DONE)
            return made
        return None

    def leave_out(self, parts: Iterable[str], why: str) -> None:
        self._outcomes |= dict.fromkeys(parts, f"{NOT_DUE}: {why}")

    def fail(self, parts: Iterable[str], why: str) -> None:
        self._outcomes |= dict.fromkeys(parts, f"{NOT_MADE}: {why}")

    def hindered(self) -> dict[str, str]:
        """Return the parts that a defect kept from being made, each with its sentence."""
        return {name: self._outcomes[name] for name in self.tracebacks}

    def failure_of(self, part: str) -> str | None:
        """Return the sentence of what kept a part from being made; None where nothing did."""
        outcome = self._outcomes.get(part, DONE)
        return None if outcome == DONE else outcome

    def in_words(self) -> dict[str, str]:
        return {name: self._outcomes.get(name, DONE) for name in PARTS}
