"""A procedure file as text, with the reasons for what stands in it as comments."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from procedures.check.toml_text import toml_text


@dataclass(frozen=True)
class Written:
    """What a procedure of attitudes asks for."""

    title: str
    design: Mapping[str, object]
    """The keys of ``[design]``."""
    replications: int
    samples: int
    model: str = "pitch-roll"
    nplc: float | None = None
    reference_every: int | None = None
    reasons: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Table, or empty for the whole file, to the sentences that stand above it."""


def procedure_text(written: Written) -> str:
    """Return the file."""
    dwell: dict[str, object] = {"samples": written.samples}
    if written.nplc is not None:
        dwell["nplc"] = written.nplc
    tables: dict[str, Mapping[str, object]] = {
        "procedure": {"title": written.title, "kind": "grid", "replications": written.replications},
        "design": written.design,
        "dwell": dwell,
        **({} if written.reference_every is None else {"check": _reference(written)}),
        "solve": {"model": written.model},
    }
    return toml_text(tables, written.reasons)


def _reference(written: Written) -> Mapping[str, object]:
    """Return two attitudes of the design that differ in pitch and in roll, nearest to level first."""
    found: dict[str, object] = {"reference_every": written.reference_every}
    for key in ("pitch_deg", "roll_deg"):
        angles = written.design.get(key)
        if isinstance(angles, tuple) and len(angles) > 1:
            level = min(angles, key=abs)
            found[key] = (
                level,
                min((angle for angle in angles if angle != level), key=lambda angle: abs(angle - 30.0)),
            )
    return found
