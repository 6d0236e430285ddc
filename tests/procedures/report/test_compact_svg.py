"""The same picture in fewer bytes: every mark, letter and colour where it was, to a tenth of a point."""

import re
from xml.etree import ElementTree

from procedures.report.compact_svg import compact_svg

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
    assert drawn[:2] == ["M10.1 20H90.5", "M1 2L3 4"]


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
