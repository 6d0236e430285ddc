import base64
import hashlib
import re
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
from report_scene import Scene, run_view

from ams.archive.sign_offs import SignOff
from ams.sets.signature import Signature
from procedures.report.figures import Figures, draw_figures
from procedures.report.page import render_page
from procedures.report.view import RunView
from procedures.report.write import Drawn, write_screen

HOSTILE = "<script>alert('x')</script> & \"quoted\" {{ 7 * 7 }}"
VOID = {"meta", "br", "img", "link", "hr", "input"}


class _Page(HTMLParser):
    """Collects what the page is made of and checks that every tag is closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] != "style":
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())

    def having(self, tag: str) -> list[dict[str, str | None]]:
        return [attrs for name, attrs in self.tags if name == tag]


def _without_figures(view: RunView) -> Figures:
    return Figures((), {sensor.name: () for sensor in view.sensors})


def _page(view: RunView) -> _Page:
    return _Page(render_page(view, _without_figures(view)))


@pytest.mark.parametrize(
    "scene",
    [
        Scene(),
        Scene(axes=("x",), replications=1, null_azimuth=True, simulated=False),
        Scene(sensors=tuple(f"SN{index}" for index in range(8))),
        Scene(interruptions=3, rejected=4, note="bumped", tooth_arcsec=2.0, offset_drift_v=4e-6),
    ],
)
def test_the_page_is_well_formed_and_every_link_leads_somewhere(scene: Scene) -> None:
    page = _page(run_view(scene))
    anchors = {attrs["id"] for _, attrs in page.tags if "id" in attrs}
    links = [attrs["href"] for attrs in page.having("a")]
    assert links
    assert all(link is not None and link.startswith("#") and link[1:] in anchors for link in links)


def test_the_duration_has_what_came_before_the_first_dwell() -> None:
    """Two hours and a half of homing and soak, then half an hour of dwells."""
    view = run_view(Scene())
    first = view.started_utc
    view = replace(view, began_utc=first - timedelta(hours=2.5), ended_utc=first + timedelta(hours=0.5))
    facts = _page(view).text
    assert f"First dwell (UTC) {first:%Y-%m-%d %H:%M:%S}" in facts
    assert f"Began (UTC) {view.began_utc:%Y-%m-%d %H:%M:%S}" in facts
    assert "Duration 3" in facts


def test_names_and_notes_reach_the_page_as_text() -> None:
    view = run_view(Scene(note=HOSTILE, rejected=1))
    hostile = replace(view.sensors[0], name=HOSTILE, mount=HOSTILE, warnings=(HOSTILE,))
    view = replace(view, title=HOSTILE, operator=HOSTILE, rig=HOSTILE, sensors=(hostile,))
    text = render_page(view, _without_figures(view))
    page = _Page(text)
    assert page.having("script") == []
    assert "<script" not in text
    assert page.text.count("alert('x')") >= 7
    assert "{{ 7 * 7 }}" in page.text


@pytest.mark.thorough
def test_a_figure_stands_in_the_page_with_nothing_but_its_quotes_changed() -> None:
    view = run_view(Scene(axes=("x",), pitch_deg=(-60, 0, 60), note=HOSTILE))
    figures = draw_figures(view)
    sources = [str(attrs["src"]) for attrs in _Page(render_page(view, figures)).having("img")]
    assert len(sources) == len(figures.all())
    shown = {unquote(source.removeprefix("data:image/svg+xml,")).encode() for source in sources}
    assert shown == {figure.svg.replace(b"\n", b" ").replace(b'"', b"'") for figure in figures.all()}


def test_nothing_outside_the_page_is_asked_for() -> None:
    view = run_view(Scene())
    text = render_page(view, _without_figures(view))
    page = _Page(text)
    assert not re.search(r"https?:|//[a-z]|@import|url\(", text)
    assert [name for name, _ in page.tags if name in ("script", "link", "iframe", "object", "form")] == []
    policy = next(attrs["content"] for attrs in page.having("meta") if "http-equiv" in attrs)
    assert policy is not None
    assert policy.startswith("default-src 'none'; img-src data:")


def test_the_style_is_the_one_that_the_policy_allows() -> None:
    view = run_view(Scene())
    text = render_page(view, _without_figures(view))
    style = text[text.index("<style>") + 7 : text.index("</style>")]
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    assert f"style-src 'sha256-{digest}'" in text
    assert not any("style" in attrs for _, attrs in _Page(text).tags)


@pytest.mark.thorough
def test_the_same_run_gives_the_same_page() -> None:
    scene = Scene(axes=("x",), pitch_deg=(-60, 0, 60))
    pages = [render_page(view, draw_figures(view)) for view in (run_view(scene), run_view(scene))]
    assert pages[0] == pages[1]


def test_a_simulated_and_an_unapproved_run_say_so_before_any_number() -> None:
    page = _page(run_view(Scene()))
    assert page.text.index("SIMULATED") < page.text.index("standard error")
    bench = _page(replace(run_view(Scene(simulated=False)), approved_by="C. Metrologist"))
    assert "SIMULATED" not in bench.text
    assert "ENGINEERING" not in bench.text
    assert "Approved by: C. Metrologist" in bench.text


def test_what_a_calibration_lacks_makes_it_an_engineering_one_and_is_listed() -> None:
    lacking = replace(
        run_view(Scene()), approved_by="QM", is_simulated=False, missing=("level.before: the base was not levelled",)
    )
    assert lacking.stamps == ("ENGINEERING",)
    text = render_page(lacking, _without_figures(lacking))
    assert "Something is missing for a calibration." in text
    assert "<li>level.before: the base was not levelled</li>" in text
    assert replace(lacking, missing=()).stamps == ()


def test_whoever_took_the_run_up_again_stands_beside_the_reason() -> None:
    view = run_view(Scene(interruptions=1))
    taken_up = replace(view.interruptions[0], resumed_by="carla", resumed_because="<b>looked</b>")
    text = render_page(replace(view, interruptions=(taken_up,)), _without_figures(view))
    assert "carla: &lt;b&gt;looked&lt;/b&gt;" in text


def test_the_twins_truth_stands_beside_the_estimate_only_when_simulated() -> None:
    assert "Twin’s truth" in _page(run_view(Scene())).text
    assert "Twin’s truth" not in _page(run_view(Scene(simulated=False))).text


def test_every_interruption_and_every_rejected_dwell_is_listed() -> None:
    page = _page(run_view(Scene(interruptions=3, rejected=4)))
    assert page.text.count("7 min 12 s") == 3
    assert page.text.count("allowed 3 times") == 4
    clean = _page(run_view(Scene()))
    assert "None: the run went through without a stop." in clean.text
    assert "None: every dwell was accepted at its first attempt." in clean.text


def test_what_is_not_determined_is_said_and_leaves_no_nan() -> None:
    page = _page(run_view(Scene(null_azimuth=True, replications=1)))
    assert page.text.count("not determined (see below)") == 6
    assert "nan" not in page.text.lower().split()
    assert "None" not in page.text.replace("None: ", "")


def test_numbers_carry_two_digits_of_their_uncertainty_and_their_unit() -> None:
    view = run_view(Scene(axes=("x",)))
    row = view.sensors[0].axes[0].parameters[1]
    assert row.expanded_uncertainty is not None
    plain = re.sub(r"<span class=\"g\">(\d+)</span>", r"\1", render_page(view, _without_figures(view)))
    cells = re.findall(r"sensitivity <i>S</i></td><td class=\"s\">V/g</td>\s*(.*?)</tr>", plain, re.DOTALL)[0]
    numbers = re.findall(r">([\d.]+)</td>", cells)
    assert float(numbers[1]) == pytest.approx(row.standard_uncertainty, rel=0.05)
    assert len(numbers[0].partition(".")[2]) == len(numbers[1].partition(".")[2])
    assert len(numbers[1].partition(".")[2].lstrip("0")) == 2


def test_the_page_is_written_whole_and_over_an_older_one(tmp_path: Path) -> None:
    view = run_view(Scene(axes=("x",)))
    target = tmp_path / "report.html"
    target.write_text("an older report", encoding="utf-8")
    page = render_page(view, _without_figures(view))
    write_screen(Drawn(view, _without_figures(view), page), tmp_path)
    assert target.read_text(encoding="utf-8") == page
    assert sorted(path.name for path in tmp_path.iterdir()) == ["figures", "report.html", "verdict.json"]


def test_what_holds_for_every_axis_is_said_once() -> None:
    view = run_view(Scene(axes=("x", "y")))
    (sensor,) = view.sensors
    axes = tuple(replace(axis, remarks=("of all", f"of {axis.axis} alone")) for axis in sensor.axes)
    view = replace(view, sensors=(replace(sensor, axes=axes),))
    page = render_page(view, draw_figures(view))
    assert page.count("of all<") == 1
    assert all(f"<b>{axis.axis}:</b> of {axis.axis} alone" in page for axis in axes)


def test_a_sensor_that_is_not_usable_is_stamped_until_its_set_is_signed() -> None:
    """As archive and list have it: who approved the rig said nothing of such a calibration."""
    view = replace(run_view(Scene(simulated=False)), approved_by="QM")
    assert view.stamps == ()
    (sensor, *others) = view.sensors
    unusable = replace(view, sensors=(replace(sensor, verdict="not usable"), *others))
    assert unusable.stamps == ("ENGINEERING",)
    text = render_page(unusable, _without_figures(unusable))
    assert f"Not usable, and nobody signed for it: {sensor.name}." in text
    when = datetime(2026, 3, 1, tzinfo=UTC)
    approved = SignOff("0" * 64, (Signature("approved", "QM", when, ""),), ())
    signed = replace(sensor, verdict="not usable", signed=approved)
    assert replace(view, sensors=(signed, *others)).stamps == ()
