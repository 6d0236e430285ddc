"""How a law is stated: what must be so, in a sentence that says what was found."""

from collections.abc import Callable

from rig.errors import RequestRefused


def expect(is_so: bool, sentence: str) -> None:
    """Raise AssertionError with the sentence unless it is so."""
    if not is_so:
        raise AssertionError(sentence)


def expect_near(got: float, need: float, tolerance: float, what: str) -> None:
    expect(abs(got - need) <= tolerance, f"{what}: got {got:g}, need {need:g} ± {tolerance:g}")


def expect_refusal(request: Callable[[], object], what: str, words: str = "") -> None:
    """Require that a request is refused before anything is done, by a sentence with ``words`` in it."""
    try:
        request()
    except RequestRefused as refusal:
        expect(words in str(refusal), f"{what}: it is refused without the words {words!r}: {refusal}")
        return
    raise AssertionError(f"{what}: it is not refused (RequestRefused)")
