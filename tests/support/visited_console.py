"""A console over one run in this process, its clock, and browsers that visit it from wherever a test says."""

import hashlib
from pathlib import Path

from journals import a_clock
from run_folders import make_run
from starlette.testclient import TestClient

from procedures.accounts.people import People
from procedures.console.app import make_app
from procedures.console.gate import Site
from procedures.console.sessions import Sessions
from procedures.console.shared import Console
from procedures.journal.journal_reader import JournalReader
from procedures.journal.status.run_list import RunList
from procedures.records.states import State
from rig.clock import VirtualClock

HOST = "127.0.0.1:8600"
BASE = f"http://{HOST}"
CHEAP = 2
"""Cost of a hash in tests."""
Fields = dict[str, str]


class Visited:
    """The console; a browser that has not entered is :attr:`browser`."""

    def __init__(self, folder: Path, state: State = State.FINISHED) -> None:
        self.run = make_run(folder / "runs" / "night-1", state)
        self.clock: VirtualClock = a_clock()
        self.people = People(folder / "people.json", cost=CHEAP)
        self.sessions = Sessions(self.clock, self.people, "lab")
        archive = f"sqlite:///{folder / 'none.sqlite'}"
        site = Site(frozenset([HOST]))
        self.console = Console(
            RunList(folder / "runs", verifies=True),
            lambda: archive,
            self.clock,
            self.sessions,
            site,
            folder / "queues",
            folder / "files",
        )
        self.browser = self.new_browser()

    def new_browser(self, address: str = "127.0.0.1") -> TestClient:
        return TestClient(
            make_app(self.console), base_url=BASE, follow_redirects=False, client=(address, 50000), cookies={}
        )

    def enter(self) -> TestClient:
        assert self.browser.get("/enter", params={"key": self.sessions.new_key()}).status_code == 200
        return self.browser

    def person(self, name: str, role: str, address: str = "127.0.0.1") -> TestClient:
        """A browser in which a person of a role has logged in."""
        secret = self.people.add(name, role, self.clock.now_utc())
        browser = self.new_browser(address)
        answer = browser.post("/login", data={"name": name, "secret": secret}, headers={"origin": BASE})
        assert answer.status_code == 303
        return browser

    def csrf(self, browser: TestClient) -> str:
        visitor = self.sessions.visitor(browser.cookies["calrig"])
        assert visitor is not None
        return visitor.csrf

    def expects(self) -> int:
        """The number of the event with which the run entered its state."""
        with JournalReader.open(self.run) as reader:
            entered = reader.last_event("state")
        assert entered is not None
        return entered.sequence

    def fields(self, browser: TestClient, **changed: str) -> Fields:
        """What a button of the run's page sends."""
        return {"csrf": self.csrf(browser), "expects": str(self.expects()), "key": "k1"} | changed

    def requests(self) -> list[str]:
        """Every request that lies in the run's folder."""
        return sorted(path.read_text() for path in (self.run / "requests").glob("*.json"))

    def digest(self) -> str:
        return hashlib.sha256((self.run / "journal.sqlite").read_bytes()).hexdigest()
