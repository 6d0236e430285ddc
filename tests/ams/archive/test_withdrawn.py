"""A set that was withdrawn: it says so wherever the archive hands it out, and nothing rests on it."""

from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from archived_runs import EXPIRED, a_run, a_sensor

from ams.archive.histories import history
from ams.archive.runs import adjustment_of, publish_run
from ams.archive.sets import list_sets, publish, show
from ams.archive.signatures import sign
from ams.errors import ArchiveError, ArchiveUnknown, SetWithdrawn
from ams.exports.formats import export_set
from ams.inference.inference import Package
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet
from procedures.cli.archive.text import adjustment_lines, history_lines, plain
from procedures.report.history_figure import WITHDRAWN, history_figure

NOW = datetime(2026, 3, 5, tzinfo=UTC)
SAID = "withdrawn by C. Lim on 2026-03-05 (UTC): wrong mount"
DAYS = (0, 90, 180, 270, 360)


def _archive(path: Path, wrong: dict[int, float], days: tuple[int, ...] = DAYS) -> str:
    """A sensor calibrated on days; those of ``wrong`` found its x axis that much larger, and are withdrawn."""
    url = f"sqlite:///{path}"
    for day in days:
        publish_run(url, a_run(day), [a_sensor(day, gain=wrong.get(day, 1.0))], NOW)
    for entry in list_sets(url):
        if any(entry.run_id == f"run-{day}" for day in wrong):
            sign(url, entry.sha256, "withdrawn", "C. Lim", NOW, "wrong mount.")
    return url


def _withdrawn(folder: Path) -> tuple[str, CoefficientSet]:
    url = _archive(folder / "archive.sqlite", {180: 1.01}, (0, 180))
    return url, show(url, "SN1")


def test_what_the_archive_hands_out_says_who_withdrew_it_when_and_why(tmp_path: Path) -> None:
    url, found = _withdrawn(tmp_path)
    assert (found.status, found.standing, found.approved_by) == ("withdrawn", SAID, None)
    assert found.withdrawal is not None
    assert asdict(found.withdrawal) == {"name": "C. Lim", "withdrawn_utc": NOW, "reason": "wrong mount."}
    assert found.doubt == f"SN1: set {found.sha256[:12]} is {SAID}: it must not be used"
    assert SAID in repr(found)
    assert SAID in found._repr_html_()
    first, listed = list_sets(url)
    assert (first.withdrawal, listed.withdrawal) == (None, found.withdrawal)
    assert (listed.status, listed.standing, listed.verdict) == ("withdrawn", SAID, None)
    assert (listed.as_found, listed.as_left) == (None, None)


def test_nothing_is_computed_with_it_written_of_it_or_published_of_it_elsewhere(tmp_path: Path) -> None:
    _, found = _withdrawn(tmp_path)
    other = f"sqlite:///{tmp_path / 'other.sqlite'}"
    refused = {
        "nothing was written": lambda: export_set(found, "c", tmp_path / "SN1.h"),
        "nothing was published": lambda: publish(other, [found], NOW),
    }
    columns = {axis: f"{axis}_v" for axis in found.axes}
    computed = (
        lambda: apply(found, 0.0, 0.0),
        lambda: Package(found, columns),
    )
    for spared, do in (*refused.items(), *(("nothing was computed", each) for each in computed)):
        with pytest.raises(SetWithdrawn, match=f"of SN1 is {SAID}".replace("(", r"\(").replace(")", r"\)")) as error:
            do()
        assert spared in str(error.value)
    assert not (tmp_path / "SN1.h").exists()
    assert not (tmp_path / "other.sqlite").exists()


def test_a_set_without_its_run_rests_on_no_expired_standard_either(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    with pytest.raises(
        ArchiveError, match=r"SN1: standards had expired .*: table \(26-0117, due 2025-12-31\); nothing"
    ):
        publish(url, [a_sensor(0, due=EXPIRED).coefficients], NOW)
    assert not (tmp_path / "archive.sqlite").exists()


def test_a_history_is_what_it_were_had_a_withdrawn_calibration_never_been(tmp_path: Path) -> None:
    """1 % of gain in the middle and at the end: steps, another mean, another scatter, other limits, other advice."""
    wrong = {180: 1.01, 360: 1.02}
    found = history(_archive(tmp_path / "with.sqlite", wrong), "SN1")
    without = history(_archive(tmp_path / "without.sqlite", {}, tuple(day for day in DAYS if day not in wrong)), "SN1")
    assert plain(asdict(found) | {"withdrawn": ()}) == plain(asdict(without))
    assert [gone.created_utc for gone in found.withdrawn] == [a_run(day).ended_utc for day in wrong]
    assert {str(gone.withdrawal) for gone in found.withdrawn} == {SAID}
    chart = next(each for each in found.history.charts if each.name == "sensitivity_v_per_g.x")
    gains = [gone.value[chart.name] / chart.value[0] for gone in found.withdrawn]
    assert gains == pytest.approx(list(wrong.values()), abs=1e-5)


def test_a_withdrawn_calibration_is_named_and_drawn_apart(tmp_path: Path) -> None:
    found = history(_archive(tmp_path / "with.sqlite", {180: 1.01}), "SN1")
    text = list(history_lines(found))
    assert text[0].startswith("SN1: 4 calibrations, ")
    (line,) = [line for line in text if line.startswith("left out: ")]
    assert f"is {SAID}; it is in no mean, no limit and no scatter" in line
    figure = history_figure(found)
    without = history_figure(replace(found, withdrawn=()))
    assert (without.caption + WITHDRAWN, figure.svg.count(b"<use") > without.svg.count(b"<use")) == (
        figure.caption,
        True,
    )


def test_a_sensor_of_which_nothing_counts_is_refused_in_a_sentence(tmp_path: Path) -> None:
    url = _archive(tmp_path / "all.sqlite", {0: 1.0, 180: 1.0}, (0, 180))
    with pytest.raises(ArchiveUnknown, match=r"'SN1': no calibration of it counts: all are withdrawn, .* names them"):
        history(url, "SN1")


def test_as_found_says_where_its_own_set_or_the_one_it_rests_on_was_withdrawn(tmp_path: Path) -> None:
    url = _archive(tmp_path / "archive.sqlite", {}, (0, 180, 360))
    first, second, third = (entry.sha256 for entry in list_sets(url))
    sign(url, second, "withdrawn", "C. Lim", NOW, "wrong mount")
    by_withdrawn, its = adjustment_of(url, third), adjustment_of(url, second)
    assert by_withdrawn is not None
    assert by_withdrawn.as_found is not None
    assert by_withdrawn.as_found.set_sha256 == second
    assert f"  the set that it was found by is {SAID}" in list(adjustment_lines(by_withdrawn))
    assert its is not None
    assert (its.as_found, its.as_left.verdict, its.not_judged) == (None, None, "the set is withdrawn")
    assert next(adjustment_lines(its)) == "as found: none (not judged, the set of this run is withdrawn)"
    before: Any = adjustment_of(url, first)
    assert (before.withdrawn_since, before.not_judged) == (None, None)
