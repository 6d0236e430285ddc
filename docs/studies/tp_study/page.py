"""The page: beside every picture which of TP's figures it stands for, what agrees and what differs, in numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tp_study.campaigns import GRIDS
from tp_study.designs import curve_facts, table_1
from tp_study.evidence import FULL, Evidence, extended_sigma_e, rms
from tp_study.judged import PARTS, UNIT_RAD, Inferred, share_inside
from tp_study.laboratory import TEETH_ARCSEC
from tp_study.printed import ROWS, SIGMA_INVERSE_22
from tp_study.settings import describe, expected_bias, lack_of_fit_form
from tp_study.soft_mount import NOISE_DEG

TEMPLATE = Path(__file__).with_name("page.template.md")
REDUCED_NOTICE = (
    "**Reduced setting: two replications, few test runs. Its numbers show that the script works, no more.**"
)
TOO_NARROW = 0.9
"""A 95 % prediction interval with fewer of the full data inside is called too narrow."""
HEADINGS = "| row | K | σ_E | σ_bias | σ_prec | T_bias (F₀.₉₅) | σ_b | σ_S | T_b | T_S (F₀.₉₅) | default tests find |"
TRUTH_HEADINGS = "| campaign, sensor | noise of a dwell | offset drift | sensitivity drift | Q: xx, xy, xz, yy, yz |"


@dataclass(frozen=True)
class Rows:
    """Formats as a part of table 2: ``{rows:22,24}``."""

    evidence: Evidence

    def __format__(self, figures: str) -> str:
        return table_2_text(figures.split(","), self.evidence)


def write_page(path: Path, evidence: Evidence) -> None:
    """The template with every number filled in."""
    parts: dict[str, object] = {
        "notice": "" if evidence.setting == FULL else REDUCED_NOTICE,
        "truths": _truths_text(evidence),
        "table_1": table_1_text(),
        "rows": Rows(evidence),
    }
    template = TEMPLATE.read_text("utf-8")
    path.write_text(template.format_map(parts | facts(evidence)), encoding="utf-8")


def _truths_text(evidence: Evidence) -> str:
    truths = {
        f"{name}, {serial} {axis}": truth
        for name, campaign in evidence.truths.items()
        for serial, axes in campaign.sensors.items()
        for axis, truth in axes.items()
    }
    return "\n".join([TRUTH_HEADINGS, "|---|---|---|---|---|", *describe(truths)])


def table_1_text() -> str:
    lines = [
        "| figure | V^½ printed | here | V_R^½ printed | here |",
        "|---|---|---|---|---|",
        *(
            f"| {name} | {printed:.3f} | {here:.3f} | {_or_none(usage_printed)} | {_or_none(usage)} |"
            for name, printed, here, usage_printed, usage in table_1()
        ),
    ]
    return "\n".join(lines)


def _or_none(value: float | None) -> str:
    return "" if value is None else f"{value:.3f}"


def table_2_text(rows: Sequence[str], evidence: Evidence) -> str:
    """Printed / twin in every cell."""
    lines = [HEADINGS, "|" + "---|" * HEADINGS[1:].count("|")]
    for figure in rows:
        printed, twin = ROWS[figure], evidence.table_2[figure]
        pairs = [
            f"{a:.3g} / {b:.3g}"
            for a, b in (
                (printed.sigma_e, twin.sigma_e),
                (printed.sigma_bias, twin.sigma_bias),
                (printed.sigma_prec, twin.sigma_prec),
            )
        ]
        tests = (("lack of fit", twin.lack_of_fit), ("b", twin.drift_b), ("S", twin.drift_s))
        found = [name for name, is_found in tests if is_found]
        lines.append(
            f"| {figure} | {printed.points} / {twin.points} | {' | '.join(pairs)} | "
            f"{printed.t_bias:.3g} / {twin.t_bias:.3g} ({twin.f_bias:.2f}) | "
            f"{printed.sigma_b:.3g} / {twin.sigma_b:.3g} | {printed.sigma_s:.3g} / {twin.sigma_s:.3g} | "
            f"{printed.t_b:.3g} / {twin.t_b:.3g} | {printed.t_s:.3g} / {twin.t_s:.3g} ({twin.f_bs:.2f}) | "
            f"{', '.join(found) or 'nothing'} |"
        )
    remarks = [f"row {figure}: {ROWS[figure].remark}" for figure in rows if ROWS[figure].remark]
    return "\n".join(lines) + (f"\n\nPrinted values put right: {'; '.join(remarks)}." if remarks else "")


def facts(evidence: Evidence) -> dict[str, str]:
    """Every number that the text of the sections names."""
    twin = evidence.table_2
    before, after = extended_sigma_e(evidence)
    known, blind = evidence.false_alarms
    runs, blind_runs = evidence.setting.test_runs, evidence.setting.blind_runs
    numbers: dict[str, object] = dict(curve_facts())
    numbers |= {f"bias_{name}": value.sigma_bias for name, value in twin.items()}
    numbers |= {f"e_{name}": value.sigma_e for name, value in twin.items()}
    numbers |= {f"t_{name}": value.t_bias for name, value in twin.items()}
    numbers |= {f"tb_{name}": value.t_b for name, value in twin.items()}
    numbers |= {f"ts_{name}": value.t_s for name, value in twin.items()}
    numbers |= {f"full_{name}": value for name, value in evidence.held_sigma_e.items()}
    for name, sensor, form_of in (("22", "S0", False), ("28(b)", "S1", True)):
        truth = evidence.truths[name[:2]].sensors[sensor]["x"]
        numbers[f"expected_{name}"] = expected_bias(
            ROWS[name], truth, lack_of_fit_form(*GRIDS[name], with_roll=form_of)
        )
    numbers |= {f"pitch_rms_{name}": rms(found.error) for name, found in evidence.pitch.items()}
    numbers |= {f"pitch_covered_{name}": 100.0 * covered(found) for name, found in evidence.pitch.items()}
    numbers |= {f"roll_rms_{name}": rms(found.error) for name, found in evidence.roll.items()}
    numbers |= {f"roll_covered_{name}": 100.0 * covered(found) for name, found in evidence.roll.items()}
    numbers |= {f"withheld_{name}": int(np.isnan(found.error).sum()) for name, found in evidence.pitch.items()}
    numbers |= {f"roll_withheld_{name}": int(np.isnan(found.error).sum()) for name, found in evidence.roll.items()}
    for name in ("36", "52", "54"):
        held = evidence.held[name]
        numbers |= {
            f"inside_{name} {axis}": 100.0 * share_inside(solved, held.observations)
            for axis, solved in held.axes.items()
        }
    for axis, tumbled in evidence.tumbles.items():
        numbers |= {
            f"least_t_{axis}": min(tumbled.t_bias),
            f"most_t_{axis}": max(tumbled.t_bias),
            f"drifts_{axis}": sum(t > twin[f"50 {axis}"].f_bs for t in tumbled.t_s),
            f"least_inside_{axis}": 100.0 * min(tumbled.inside),
            f"too_narrow_{axis}": sum(share < TOO_NARROW for share in tumbled.inside),
        }
    numbers |= {
        "repeats": evidence.setting.repeats,
        "coarse_bias": evidence.coarse_22.sigma_bias,
        "coarse_t": evidence.coarse_22.t_bias,
        "sigma_inverse_22": SIGMA_INVERSE_22,
        "before": before,
        "after": after,
        "noise_with_drift": twin["37"].sigma_prec * np.sqrt(_inflation(evidence)),
        "tp_noise": NOISE_DEG * PARTS * np.sqrt(4.0 / 3.0),
        "extension_f": evidence.extension.test.t,
        "extension_f95": evidence.extension.test.f_95,
        "engine_v": evidence.engine_against_world_v * 1e9,
    }
    text = {name: f"{value:.3g}" if isinstance(value, float) else str(value) for name, value in numbers.items()}
    return text | {
        "known": str(known),
        "runs": str(runs),
        "known_percent": f"{100.0 * known / runs:.1f}",
        "blind": str(blind),
        "blind_runs": str(blind_runs),
        "teeth": f"{TEETH_ARCSEC:g}",
        "q_found": ", ".join(f"{q:.2f}" for q in _q_in_table_units(evidence)),
        "q_true": ", ".join(f"{q:.2f}" for q in evidence.truths["37"].sensors["S1"]["x"].q),
    }


def _inflation(evidence: Evidence) -> float:
    n = evidence.truths["37"].replications
    return n / (n - 1)


def _q_in_table_units(evidence: Evidence) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    k = np.linalg.norm(evidence.solved["37"].x.sensitive_axis_v_per_g)
    return np.asarray(evidence.extension.q_v_per_g2 / (k * UNIT_RAD))


def covered(found: Inferred) -> float:
    """Share of the angles that were given which lie inside their own prediction interval."""
    given = np.isfinite(found.error)
    return float(np.mean(np.abs(found.error[given]) <= found.prediction[given]))
