"""axe-core on a page that Chromium shows: what a person with a keyboard, a reader or weak eyes would stumble over."""

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

SERIOUS = ("serious", "critical")


def serious_findings(page: Page) -> list[str]:
    """Return the serious and critical findings: rule, and the elements it is about."""
    found = Axe().run(page).response["violations"]
    return [
        f"{entry['id']}: {node['html'][:90]} {node.get('failureSummary', '')[:200]}"
        for entry in found
        if entry["impact"] in SERIOUS
        for node in entry["nodes"]
    ]
