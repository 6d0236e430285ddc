"""Of several sensors a row each, what they share once, and no word of one in the document of another."""

from pathlib import Path

import pytest
from many_packages import many_packages, serial
from report_scene import Scene, run_view

from procedures.cli.main import run_command
from procedures.journal.sidecar.verdict_file import VERDICT_FILE
from procedures.report.overview import overview_rows, stated_once

EVERYONE = ("SN1", "SN2", "SN3")


def test_a_statement_is_said_once_with_all_of_whom_it_is_true() -> None:
    of_all = [(name, "", "the level is not declared") for name in EVERYONE]
    of_axes = [("SN1", "x", "drifts"), ("SN1", "y", "drifts"), ("SN3", "x", "drifts")]
    everywhere = [(name, axis, "curved") for name in EVERYONE for axis in "xy"]
    assert stated_once([*of_all, *of_axes, ("SN2", "", "was dropped"), *everywhere], EVERYONE) == [
        "all 3 sensors: the level is not declared",
        "SN1 x, y; SN3 x: drifts",
        "SN2: was dropped",
        "all 3 sensors, x, y: curved",
    ]


def test_what_differs_in_its_size_alone_is_said_once_with_the_range() -> None:
    """Twelve packages had the same sentence thirteen times; what tells which one, or has a sign, is no size."""
    bends = [
        ("SN1", "x", "bends by 0.3″ and 9 V"),
        ("SN2", "x", "bends by 10″ and 9 V"),
        ("SN3", "x", "bends by 2.5″ and 9 V"),
    ]
    assert stated_once(bends, EVERYONE) == ["all 3 sensors, x: bends by 0.3″ to 10″ and 9 V"]
    assert stated_once([*bends[:1], ("SN1", "x", "bends by 0.3″ and 8 V")], EVERYONE) == [
        "SN1 x: bends by 0.3″ and 9 V", "SN1 x: bends by 0.3″ and 8 V",
    ]  # fmt: skip
    of_others = [("SN1", "", "step 5"), ("SN2", "", "step 6"), ("SN1", "", "off by −1.5″"), ("SN2", "", "off by −2.5″")]
    assert len(stated_once(of_others, EVERYONE)) == 4


def test_one_turn_that_each_shows_by_its_own_size_and_uncertainty_is_said_once_with_both_ranges() -> None:
    sizes = (("+72.5", "0.38"), ("+71.6", "0.4"), ("+71.9", "0.37"))
    for sign, range_ in (("+", "+71.6″ to +72.5″ (u 0.37″ to 0.4″)"), ("−", "−71.6″ to −72.5″ (u 0.37″ to 0.4″)")):
        turns = [
            (name, axis, f"turned by {size.replace('+', sign)}″ (u {u}″) about roll; 146 dwells")
            for name, (size, u) in zip(EVERYONE, sizes, strict=True)
            for axis in "xyz"
        ]
        assert stated_once(turns, EVERYONE) == [f"all 3 sensors, x, y, z: turned by {range_} about roll; 146 dwells"]
    back = ("SN1", "x", "turned by −72.5″ (u 0.38″) about roll; 146 dwells")
    assert len(stated_once([("SN2", "x", back[2].replace("−", "+")), back], EVERYONE)) == 2, (
        "another way is another turn"
    )
    alone = ("SN1", "x", "turned by +72″ (u 0.38″) about roll")
    assert stated_once([alone, ("SN2", "x", alone[2])], EVERYONE) == [f"SN1 x; SN2 x: {alone[2]}"]


def test_a_term_found_in_several_is_said_once_with_what_it_came_to() -> None:
    """Eight packages with one bend had eight sentences; another sign, unit or meaning is another statement."""
    found = [
        ("SN1", "x", "K₃ = 32 ± 8.6 µV/g³ (2.6″): the output bends"),
        ("SN2", "x", "K₃ = 19 ± 4.8 µV/g³ (1.5″): the output bends"),
        ("SN3", "x", "K₃ = 20.5 ± 7.3 µV/g³ (10″): the output bends"),
        ("SN1", "y", "K₃ = −19 ± 4.8 µV/g³ (1.5″): the output bends"),
        ("SN2", "x", "K₂ = 19 ± 4.8 µV/g² (1.5″): the output bends"),
    ]
    assert stated_once(found, EVERYONE) == [
        "all 3 sensors, x: K₃ = 19 to 32 µV/g³ (1.5″ to 10″): the output bends",
        "SN1 y: K₃ = −19 ± 4.8 µV/g³ (1.5″): the output bends",
        "SN2 x: K₂ = 19 ± 4.8 µV/g² (1.5″): the output bends",
    ]


def test_of_many_sensors_the_few_are_named_of_whom_it_is_not_true() -> None:
    names = [f"SN{number}" for number in range(1, 13)]
    of_most = [(name, "", "the level is not declared") for name in names if name != "SN9"]
    assert stated_once(of_most, names) == ["all 12 sensors but SN9: the level is not declared"]
    assert stated_once([(name, "x", "bends") for name in names[2:]], names) == [
        "x of all 12 sensors but SN1, SN2: bends"
    ]
    assert stated_once([(name, "", "bends") for name in names[3:]], names)[0].startswith("SN4; SN5; ")


def test_one_sensor_is_called_by_its_name() -> None:
    assert stated_once([("SN1", "", "was dropped")], ["SN1"]) == ["SN1: was dropped"]


def test_a_row_tells_a_sensor_in_five_words() -> None:
    (row,) = overview_rows(run_view(Scene()))
    assert (row.sensor, row.verdict, row.as_found, row.findings) == ("SN1047", "sound", "—", "none")
    assert row.angle.startswith("±")
    (drifted,) = overview_rows(run_view(Scene(offset_drift_v=4e-6)))
    assert (drifted.verdict, drifted.findings) == ("usable", "drift")


@pytest.mark.soak
@pytest.mark.timeout(900)
@pytest.mark.parametrize(("packages", "most_bytes"), [(8, 3_000_000), (12, 3_300_000)])
def test_many_packages_fit_into_three_megabytes_and_each_has_its_own_document(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, packages: int, most_bytes: int
) -> None:
    monkeypatch.setattr("procedures.report.write.paper_of", lambda *_: b"%PDF")  # nine of them take longest
    rig, procedure = many_packages(tmp_path, packages)
    assert run_command(["run", str(procedure), "--rig", str(rig), "--out", str(tmp_path / "runs"), "--json"]) == 0
    (run,) = (path.parent for path in (tmp_path / "runs").glob("*/journal.sqlite"))
    page = (run / "report.html").read_text(encoding="utf-8")
    assert len(page.encode()) < most_bytes
    assert page.count("the level of the base is not declared") == 1
    assert page.index('id="overview"') < page.index('id="sensor-1-')
    documents = sorted((run / "documents").glob("*.html"), key=lambda path: int(path.name.partition("-")[0]))
    assert len(documents) == packages
    for own, number in zip(documents, range(1, packages + 1), strict=True):
        text = own.read_text(encoding="utf-8")
        others = [serial(other) for other in range(1, packages + 1) if other != number]
        assert serial(number) in text
        assert [other for other in others if other in text] == []
        assert own.with_suffix(".pdf").read_bytes().startswith(b"%PDF")
    assert (run / VERDICT_FILE).exists()
