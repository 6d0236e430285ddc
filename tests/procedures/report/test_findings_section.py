"""The section of findings: what was tested, on which channel, and what of it somebody must read."""

from report_scene import Scene, run_view

from procedures.report.figures import Figures
from procedures.report.page import render_page


def _page(scene: Scene) -> str:
    view = run_view(scene)
    return render_page(view, Figures((), {sensor.name: () for sensor in view.sensors}))


def test_every_test_of_every_axis_stands_in_the_table_and_in_the_contents() -> None:
    page = _page(Scene())
    assert '<a href="#findings">Findings</a>' in page
    section = page[page.index('<h2 id="findings">') : page.index('<h2 id="run">')]
    assert section.count("wrong dwell</td>") == section.count("lack of fit</td>") == 3
    assert "<td>yes</td>" not in section


def test_a_significant_finding_is_marked_and_its_sentence_stands_beside_it() -> None:
    page = _page(Scene(offset_drift_v=4e-6))
    section = page[page.index('<h2 id="findings">') : page.index('<h2 id="run">')]
    assert section.count('<td class="s sig">drift of offset</td>') == 3
    assert section.count("offset changed by 12″") == 3
    assert "SN1047 x, y, z: offset changed by 12″" in page[: page.index('<h2 id="findings">')]


def test_without_tests_there_is_no_section() -> None:
    assert 'id="findings"' not in _page(Scene(replications=1))


def test_of_several_sensors_what_rings_stands_in_rows_and_every_test_in_one() -> None:
    page = _page(Scene(sensors=("SN1", "SN2"), offset_drift_v=4e-6))
    section = page[page.index('<h2 id="findings">') : page.index('<h2 id="run">')]
    assert section.count("offset changed by 12″") == 6
    assert section.count(">lack of fit</td>") == 1
    row = section[section.index(">drift of offset</td>", section.index("Smallest p")) :]
    assert row[: row.index("</tr>")].count('<td class="n">6</td>') == 2  # channels tested, and significant on
    quiet = _page(Scene(sensors=("SN1", "SN2")))
    assert "None is significant." in quiet[quiet.index('<h2 id="findings">') : quiet.index('<h2 id="run">')]
