"""A section of the report of your own: the share of dwells that was accepted (docs/report-and-certificate.md).

The fragment is a Jinja template; it is given the whole view of the run (``procedures/report/view.py``) and its figures.
"""

from procedures.report.section import Section

FRAGMENT = """
<h2 id="dwells">Dwells</h2>
<p>{{ view.counts.design_accepted }} of {{ view.counts.design_planned }} design dwells of “{{ view.title }}” were
accepted: {{ (100 * view.counts.design_accepted / view.counts.design_planned) | round(1) }} %.</p>
"""

SECTION = Section(
    "dwells",
    250,  # behind "run", which has 200
    FRAGMENT,
    lambda _view: {"dwells": "Dwells"},
    is_shown=lambda view: view.counts.design_planned > 0,
)
