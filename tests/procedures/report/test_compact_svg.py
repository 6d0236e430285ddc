"""The same picture in fewer bytes: every mark, letter and colour where it was, to a tenth of a point."""

import re
from collections.abc import Iterator
from xml.etree import ElementTree

import pytest
from fontTools.pens.recordingPen import RecordingPen
from fontTools.svgLib.path import parse_path
from report_scene import Scene, run_view

from procedures.report import canvas
from procedures.report.compact_svg import compact_svg
from procedures.report.figures import draw_figures

SVG = b"""<?xml version="1.0" encoding="utf-8" standalone="no"?>
<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="100pt" viewBox="0 0 100 50">
 <metadata><x/></metadata>
 <defs><style type="text/css">*{stroke-linejoin: round}</style></defs>
 <g id="figure_1">
  <g id="grid"><path d="M 10.123456 20.000001
L 90.5 20.000001
" clip-path="url(#clip-1)" style="fill: none; stroke: #e3e3e3"/><path d="M 1 2
L 3 4
" clip-path="url(#clip-1)" style="fill: none; stroke: #e3e3e3"/></g>
  <!-- a remark -->
  <defs><path id="mark-7" d="M 0 0
L 0 2.5
" style="stroke: #1a1a1a"/></defs>
  <g><use xlink:href="#mark-7" x="33.333333" y="4.444444" style="fill: #0072b2"/>
   <use xlink:href="#mark-7" x="55.555555" y="-6.666666" style="fill: #0072b2"/></g>
  <g transform="translate(22.361111 77.648888) scale(0.015625 -0.015625)">
   <defs><path id="DejaVu-1" d="M 794 531 L 1825 531 z" transform="scale(0.015625)"/></defs>
   <use xlink:href="#DejaVu-1"/><use xlink:href="#DejaVu-1" transform="translate(63.623047 0)"/></g>
  <g style="opacity: 0.5"><use xlink:href="#mark-7" x="1" y="2" style="opacity: 0.5"/></g>
 </g>
 <defs><clipPath id="clip-1"><rect x="0" y="0" width="100.44444" height="50"/></clipPath></defs>
</svg>
"""
NAMES = "{http://www.w3.org/2000/svg}"


def test_marks_letters_and_lines_stand_where_they_were() -> None:
    root = ElementTree.fromstring(compact_svg(SVG))
    uses = [(use.get("href"), use.get("x"), use.get("y"), use.get("transform")) for use in root.iter(f"{NAMES}use")]
    mark, letter = uses[0][0], uses[2][0]
    assert uses == [
        (mark, "33.3", "4.4", None), (mark, "55.6", "-6.7", None), (letter, None, None, None),
        (letter, "64", None, None), (mark, "1", "2", None),
    ]  # fmt: skip
    ids = {entry.get("id") for entry in root.iter() if entry.get("id")}
    assert {str(mark)[1:], str(letter)[1:]} < ids
    text = next(entry for entry in root.iter(f"{NAMES}g") if entry.get("transform"))
    assert text.get("transform") == "translate(22.4 77.6) scale(0.015625 -0.015625)"
    drawn = [path.get("d") for path in root.iter(f"{NAMES}path")]
    assert drawn[:2] == ["M10.1 20h80.4", "M1 2l2 2"]


def test_every_colour_is_still_said_and_what_is_referred_to_is_there() -> None:
    text = compact_svg(SVG).decode()
    for colour in ("#e3e3e3", "#1a1a1a", "#0072b2", "opacity:0.5"):
        assert colour in text
    targets = set(re.findall(r'href="#(\w+)"', text)) | set(re.findall(r"url\(#(\w+)\)", text))
    assert targets == set(re.findall(r' id="(\w+)"', text))
    assert "metadata" not in text
    assert len(text) < len(SVG)


def test_it_is_done_once_and_the_same_every_time() -> None:
    once = compact_svg(SVG)
    assert compact_svg(SVG) == once


def _outlines(svg: bytes) -> list[tuple[float, list[tuple[str, list[float]]]]]:
    """What every path draws, in absolute points by fontTools' own reader, with the scale at which it is drawn."""
    found = []
    for path in ElementTree.fromstring(svg).iter(f"{NAMES}path"):
        if drawn := path.get("d"):
            scale = re.fullmatch(r"scale\((.*)\)", path.get("transform", ""))
            pen = RecordingPen()
            parse_path(drawn, pen)
            steps = [(word, list(_flat(points))) for word, points in pen.value]
            found.append((float(scale[1]) if scale else 1.0, steps))
    return found


def _flat(points: tuple[tuple[float, float], ...]) -> Iterator[float]:
    for point in points:
        yield from point


def test_every_line_and_letter_of_real_figures_goes_where_it_went(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps from rounded point to rounded point: the last of a thousand is no further off than the first."""
    drawn: list[bytes] = []

    def kept(svg: bytes) -> bytes:
        drawn.append(svg)
        return compact_svg(svg)

    monkeypatch.setattr(canvas, "compact_svg", kept)
    draw_figures(run_view(Scene(interruptions=3, offset_drift_v=4e-6)))
    assert len(drawn) > 5
    for svg in drawn:
        before, after = _outlines(svg), _outlines(compact_svg(svg))
        assert len(before) == len(after) > 20
        for (scale, old), (own_scale, new) in zip(before, after, strict=True):
            assert own_scale == 1.0
            assert [word for word, _ in old] == [word for word, _ in new]
            for (_, was), (_, now) in zip(old, new, strict=True):
                assert now == pytest.approx([scale * number for number in was], abs=0.0501)


def test_marks_of_one_look_say_it_once_and_what_acts_on_a_group_stays_with_each_mark() -> None:
    marks = "".join(
        f'<use xlink:href="#m" x="{x}.5" y="2.5" style="fill: #{x}{x}{x}; fill-opacity: 0.75; opacity: 0.5"/>'
        for x in range(1, 9)
    )
    text = compact_svg(
        b'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"><g>'
        b'<defs><path id="m" d="M 0 0 L 1 1"/></defs>' + marks.encode() + b"</g></svg>"
    ).decode()
    assert text.count("fill-opacity") == 1
    assert len(re.findall(r"[^-]opacity:0.5", text)) == 8
    assert [f"fill:#{x}{x}{x};" in text for x in range(1, 9)] == [True] * 8
