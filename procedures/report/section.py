"""What a section of a run's page is: a place in the order, a fragment of a template, and its lines in the contents.

A section is one file and one entry point ``calrig.sections``; calrig's own stand in :mod:`procedures.report.sections`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from jinja2 import Environment, Template
from markupsafe import Markup

from procedures.errors import RequestError
from procedures.report.figures import Figures
from procedures.report.view import RunView
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from rig.registry import Registry


@dataclass(frozen=True)
class SectionSource:
    """What a section takes its own data from."""

    record: RunRecord
    """The run as its journal has it, with rig file and plan."""
    solved: Mapping[str, SolvedSensor]
    """Sensor to its solution; all of the run, also for the document of one."""
    view: RunView
    """What all sections share; in the document of one sensor with that sensor alone."""


@dataclass(frozen=True)
class Section:
    """One section of the page."""

    name: str
    order: int
    """Sections stand by their order, then by their name; calrig's own have hundreds."""
    fragment: str
    """A Jinja template that is given ``view``, ``figures`` and ``data``, the filters of the report and
    ``parts.html.j2``; what it prints is escaped."""
    contents: Callable[[RunView], Mapping[str, str]] = lambda _view: {}
    """Anchor to title of each of its lines in the contents."""
    is_shown: Callable[[RunView], bool] = lambda _view: True
    data: Callable[[SectionSource], object] | None = None
    """What the fragment is given as ``data``, and ``contents`` and ``is_shown`` find in ``view.of_sections``; None: the
    section has nothing but what the view has."""

    def rendered(self, environment: Environment, view: RunView, figures: Figures) -> Markup:
        """Return its HTML."""
        data = view.of_sections.get(self.name)
        return Markup(_template(environment, self.fragment).render(view=view, figures=figures, data=data))  # noqa: S704


@lru_cache(maxsize=64)
def _template(environment: Environment, fragment: str) -> Template:
    return environment.from_string(fragment)


SECTIONS: Registry[Section] = Registry("calrig.sections", Section, RequestError)


def sections_in_order() -> list[Section]:
    """Return every registered section as the page shows them."""
    return sorted(SECTIONS.values(), key=lambda section: (section.order, section.name))


def with_data_of_sections(record: RunRecord, solved: Mapping[str, SolvedSensor], view: RunView) -> RunView:
    """Return the view with what every registered section takes of the run for itself."""
    source = SectionSource(record, solved, view)
    brought = {section.name: section.data(source) for section in SECTIONS.values() if section.data is not None}
    return replace(view, of_sections=brought)


def fragment_beside(module_file: str) -> str:
    """Return the template of the same name beside a module."""
    return Path(module_file).with_suffix(".html.j2").read_text(encoding="utf-8")
