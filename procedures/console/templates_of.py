"""The templates of the console with what every page is given."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from starlette.responses import HTMLResponse

from procedures.numbers import duration
from procedures.pages import page_environment
from rig.local_time import at_both, local_clock

HERE = Path(__file__).parent


class Pages:
    """Fills them in."""

    def __init__(self) -> None:
        self._found = page_environment(HERE / "templates")
        self._found.filters.update({"both": at_both, "lasting": duration, "local": local_clock})

    def html(self, template: str, **values: Any) -> str:
        """Return a page, or a part of one."""
        return self._found.get_template(template).render(**values)

    def shown(self, template: str, status_code: int = 200, **values: Any) -> HTMLResponse:
        """Return a page as an answer; of a visitor that is not named it shows the way in."""
        given = {"here": "", "visitor": None, "now": datetime.now(UTC), **values}
        return HTMLResponse(self.html(template, **given), status_code)
