"""What is said of what rows do not tell: errors of outputs that stay unseen, and the angles they turn."""

from collections.abc import Iterable

from ams.inference.watch.reliability import AngleChange, Unseen, UnseenError
from ams.rounding import significant
from ams.units import ARCSEC_PER_DEG

_LARGEST_ARCSEC = 1000.0
"""Of an error that is told in seconds of arc."""


def unseen_in_words(unseen: Unseen) -> str:
    """Say which errors turn angles by more than is stated of them, and how far; else by how much they do at most."""
    names = ", ".join(dict.fromkeys(output.sensor for output in unseen.outputs))
    rows = "1 row does" if unseen.rows == 1 else f"{unseen.rows} rows do"
    head = f"{names}: what {rows} not show"
    missed = f"has no flag in {_percent(1.0 - unseen.found_share)} of such files and more"
    beyond = [*_by_output(unseen.outputs), *_by_dead(unseen.outputs)]
    if beyond:
        return (
            f"{head} (an error of one output that {missed}): {'; '.join(beyond)}; rows in which the axis is further "
            "from level show more"
        )
    most = max((change.change_deg for output in unseen.outputs for change in output.changes), default=0.0)
    return (
        f"{head}: an error of one output that {missed} turns no angle by more than {significant(most)}°, which is "
        "within what is stated of it (k = 2)"
    )


def _by_output(outputs: Iterable[UnseenError]) -> list[str]:
    """Say of each angle the output whose error turns it most, where that is more than is stated; each output once."""
    worst: dict[str, tuple[UnseenError, AngleChange]] = {}
    for output in outputs:
        for change in output.changes:
            if change.is_beyond_stated and (
                change.angle not in worst or change.change_deg > worst[change.angle][1].change_deg
            ):
                worst[change.angle] = output, change
    said = []
    for output in dict.fromkeys(output for output, _ in worst.values()):
        turned = _turned(change for of_angle, change in worst.values() if of_angle is output)
        said.append(f"up to {_size(output)} of {_axis(output)}, {turned}")
    said += [f"one of {_axis(output)} of any size" for output in outputs if output.found_v is None]
    return said


def _by_dead(outputs: Iterable[UnseenError]) -> list[str]:
    """Say which axes may be dead without a flag, where that turns an angle by more than is stated."""
    said = []
    for output in outputs:
        beyond = [change for change in output.dead_changes if change.is_beyond_stated]
        if output.is_dead_unseen and beyond:
            missed = f"no flag in {_percent(1.0 - output.dead_found_share)}"
            said.append(f"a dead {_axis(output)} ({missed}), {_turned(beyond)}")
    return said


def _turned(changes: Iterable[AngleChange]) -> str:
    return " and ".join(
        f"{change.angle} off by up to {significant(change.change_deg)}° "
        f"(stated ±{significant(change.expanded_uncertainty_deg)}°, k = 2)"
        for change in changes
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _size(output: UnseenError) -> str:
    assert output.found_arcsec is not None
    if output.found_arcsec < _LARGEST_ARCSEC:
        return f"{significant(output.found_arcsec)}″"
    return f"{significant(output.found_arcsec / ARCSEC_PER_DEG)}°"


def _axis(output: UnseenError) -> str:
    return f"{output.axis} of the {output.package} package" if output.package else output.axis
