"""One run as its page shows it: followed, never read anew, and shared by every browser that looks."""

import hashlib
import shlex
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from threading import Lock

from procedures.console.heat_map import MOST_COLUMNS, HeatMap, heat_map
from procedures.journal.audit.event_words import event_words
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import TAKES_BACK
from procedures.journal.sidecar.live import Live, read_live
from procedures.journal.sidecar.verdict_file import read_verdict
from procedures.journal.status.follower import FollowedDwell, Follower, News
from procedures.journal.status.standing import RunStatus, progress_of
from procedures.journal.status.standing_words import Row, rows_of
from procedures.journal.status.stop_advice import StopNumbers, advice, numbers_of
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import Key, key_of, keys_in
from procedures.records.states import State
from rig.clock import Clock

NEWS_KEPT = 40


@dataclass(frozen=True, slots=True)
class Happened:
    """One line of what happened."""

    utc: datetime
    text: str


@dataclass(frozen=True, slots=True)
class ChannelNow:
    """One channel as it was last read."""

    name: str
    mean: float
    standard_deviation: float
    rms_arcsec: float | None


@dataclass(frozen=True)
class RunPage:
    """What stands on the page of a run."""

    run_id: str
    folder: str
    """As a command takes the run wherever it is given: whose browser this is stands in no folder of runs."""
    title: str
    operator: str
    is_simulated: bool
    sensors: tuple[str, ...]
    status: RunStatus
    is_alive: bool
    rows: tuple[Row, ...]
    live: Live | None
    advice: str
    """What a person should do; empty where nothing stands still by itself."""
    happened: tuple[Happened, ...]
    """The newest first."""
    channels: tuple[ChannelNow, ...]
    verdict: Mapping[str, object] | None
    has_report: bool
    last_step: int | None
    """Of the newest dwell that counts, which can be taken back; None where there is none."""
    version: str
    """Another one where anything on the page is another."""

    @property
    def is_unasked_stop(self) -> bool:
        return self.status.state in (State.HELD, State.TRIPPED, State.FAILED, State.INTERRUPTED)

    @property
    def can_be_taken_back(self) -> bool:
        """Whether dwells of it can be taken back now."""
        return not self.is_alive and self.last_step is not None and self.status.state in TAKES_BACK


@dataclass
class WatchedRun:
    """Follows one run for all who look; a look costs what has happened since the last."""

    folder: Path
    clock: Clock
    _follower: Follower = field(init=False)
    _lock: Lock = field(default_factory=Lock)
    _happened: deque[Happened] = field(default_factory=lambda: deque(maxlen=NEWS_KEPT))
    _dwells: deque[FollowedDwell] = field(default_factory=lambda: deque(maxlen=MOST_COLUMNS))
    _taken_back: set[Key] = field(default_factory=set)
    _cause: str = ""
    _seen: int = 0
    """Dwells and those taken back: the picture is another where this is."""
    _numbers: tuple[int, StopNumbers] | None = None
    """Of the journal up to an event: a run that stands still is read once."""
    _map: tuple[int, HeatMap | None] = (0, None)

    def __post_init__(self) -> None:
        self._follower = Follower(self.folder, clock=self.clock)
        with JournalReader.open(self.folder) as reader:
            header = reader.header
        self._title, self._operator, self._is_simulated = header.title, header.operator, header.is_simulated
        sensors = header.plan.sensors
        self._sensors = tuple(sensors)
        self._outputs = frozenset(channel for sensor in sensors.values() for channel in sensor.channels.values())

    def close(self) -> None:
        self._follower.close()

    def page(self) -> RunPage:
        """Return what stands on the page now. Raises: JournalError."""
        with self._lock:
            news = self._follower.poll()
            self._take(news)
            status, live, picture = news.status, read_live(self.folder), self._picture()
            last = self._dwells[-1] if self._dwells else None
            sizes = {} if picture is None else dict(zip(picture.channels, picture.rms_arcsec, strict=True))
            mark = (news.sequence, str(status.state), None if live is None else live.written_utc)
            return RunPage(
                run_id=self.folder.name,
                folder=shlex.quote(str(self.folder.absolute())),
                title=self._title,
                operator=self._operator,
                is_simulated=self._is_simulated,
                sensors=self._sensors,
                status=status,
                is_alive=news.is_alive,
                rows=tuple(rows_of(progress_of("state", status), status.why, live, self.clock.now_utc())),
                live=live,
                advice=self._advice(status.state, news.sequence) if status.state in (State.HELD, State.TRIPPED) else "",
                happened=tuple(reversed(self._happened)),
                channels=()
                if last is None
                else tuple(
                    ChannelNow(name, mean, last.standard_deviation[name], sizes.get(name))
                    for name, mean in last.mean.items()
                ),
                verdict=read_verdict(self.folder, status.state),
                has_report=(self.folder / "report.html").is_file(),
                last_step=self._last_step(),
                version=hashlib.sha256(repr(mark).encode()).hexdigest()[:16],
            )

    def _advice(self, state: State, sequence: int) -> str:
        if self._numbers is None or self._numbers[0] != sequence:
            with JournalReader.open(self.folder) as reader:
                numbers = numbers_of(str(self.folder.absolute()), reader.events(), reader.dwells(with_samples=False))
            self._numbers = sequence, numbers
        return advice(self._cause, state, self._numbers[1])

    def picture(self) -> HeatMap | None:
        """Return the residuals so far. Raises: JournalError."""
        with self._lock:
            self._take(self._follower.poll())
            return self._picture()

    def _take(self, news: News) -> None:
        for event in news.events:
            if message := event_words(event):
                self._happened.append(Happened(event.utc, message))
            if event.kind == "state":
                self._cause = str(event.detail.get("cause", ""))
            if event.kind == VOIDED:
                self._taken_back.update(keys_in(event))
                self._seen += 1
        self._dwells.extend(news.dwells)
        self._seen += len(news.dwells)

    def _last_step(self) -> int | None:
        counted = (
            dwell.record
            for dwell in reversed(self._dwells)
            if dwell.record.accepted and dwell.record.purpose != "check"
        )
        return next((dwell.step for dwell in counted if key_of(dwell) not in self._taken_back), None)

    def _picture(self) -> HeatMap | None:
        if self._map[0] != self._seen:
            self._map = (self._seen, heat_map(list(self._dwells), frozenset(self._taken_back), self._outputs))
        return self._map[1]
