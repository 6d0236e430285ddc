"""What a section of a run's page is: a place in the order, a fragment of a template, and its lines in the contents.

A section is one file and one entry point ``calrig.sections``; calrig's own stand in :mod:`procedures.report.sections`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from jinja2 import Environment, Template
from markupsafe import Markup

from procedures.errors import RequestError
from procedures.report.figures import Figures
from procedures.report.view import RunView
from rig.registry import Registry


@dataclass(frozen=True)
class Section:
    """One section of the page."""

    name: str
    order: int
    """Sections stand by their order, then by their name; calrig's own have hundreds."""
    fragment: str
    """A Jinja template that is given ``view`` and ``figures``, the filters of the report and ``parts.html.j2``; what it
    prints is escaped."""
    contents: Callable[[RunView], Mapping[str, str]] = lambda _view: {}
    """Anchor to title of each of its lines in the contents."""
    is_shown: Callable[[RunView], bool] = lambda _view: True

    def rendered(self, environment: Environment, view: RunView, figures: Figures) -> Markup:
        """Return its HTML."""
        return Markup(_template(environment, self.fragment).render(view=view, figures=figures))  # noqa: S704


@lru_cache(maxsize=64)
def _template(environment: Environment, fragment: str) -> Template:
    return environment.from_string(fragment)


SECTIONS: Registry[Section] = Registry("calrig.sections", Section, RequestError)


def sections_in_order() -> list[Section]:
    """Return every registered section as the page shows them."""
    return sorted(SECTIONS.values(), key=lambda section: (section.order, section.name))


def fragment_beside(module_file: str) -> str:
    """Return the template of the same name beside a module."""
    return Path(module_file).with_suffix(".html.j2").read_text(encoding="utf-8")
