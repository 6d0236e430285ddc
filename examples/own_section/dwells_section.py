"""A section of the report of your own: how many dwells counted, and what they took (docs/report-and-certificate.md).

The fragment is a Jinja template; it is given the whole view of the run (``procedures/report/view.py``), its figures,
and ``data``: what the section takes of the run itself. The view does not know how long a dwell took; the journal does.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from procedures.report.section import Section, SectionSource
from procedures.report.view import RunView

FRAGMENT = """
<h2 id="dwells">Dwells</h2>
<p>{{ view.counts.design_accepted }} of {{ view.counts.design_planned }} design dwells of “{{ view.title }}” were
accepted: {{ (100 * view.counts.design_accepted / view.counts.design_planned) | round(1) }} %. {% if data.count -%}
The {{ data.count }} dwells that count took {{ data.mean_s | round(1) }} s each on average, settling included; the
longest took {{ data.longest_s | round(1) }} s (step {{ data.longest_step }}).{% endif %}</p>
"""


@dataclass(frozen=True)
class DwellTimes:
    """How long the dwells that count took, from their beginning to their end."""

    count: int
    mean_s: float = 0.0
    longest_s: float = 0.0
    longest_step: int = 0


def dwell_times(source: SectionSource) -> DwellTimes:
    """Take them from the run as its journal has it."""
    took_s = {dwell.step: dwell.ended_s - dwell.started_s for dwell in source.record.dwells if dwell.accepted}
    if not took_s:
        return DwellTimes(0)
    longest = max(took_s, key=lambda step: took_s[step])
    return DwellTimes(len(took_s), sum(took_s.values()) / len(took_s), took_s[longest], longest)


def _contents(_view: RunView) -> Mapping[str, str]:
    return {"dwells": "Dwells"}


SECTION = Section(
    "dwells",
    250,  # behind "run", which has 200
    FRAGMENT,
    _contents,
    is_shown=lambda view: view.counts.design_planned > 0,
    data=dwell_times,
)
