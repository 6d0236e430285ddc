"""A figure's SVG without what nobody sees: less than half of the bytes, drawn the same.

Matplotlib writes six decimals of a point, a group around every tick, a style at every mark, and every point of a curve
from the corner of the page. Coordinates keep a tenth of a point (35 µm on paper), those of letters a thousandth of
their height; lines go on from the point before. Scales, which multiply, keep every digit.
"""

import re
from collections import Counter
from functools import lru_cache
from xml.etree import ElementTree

_NAMESPACE, _HREF = "http://www.w3.org/2000/svg", "{http://www.w3.org/1999/xlink}href"
_POINTS = ("x", "y", "x1", "x2", "y1", "y2", "width", "height", "points")
_NUMBER = re.compile(r"-?\d+\.\d{2,}(?:e-?\d+)?")
_TRANSLATION = re.compile(r"translate\([^)]*\)")
_DRAWN = re.compile(r"[A-Za-z]|-?[\d.]+(?:e-?\d+)?")
_PAIRS = {"M": 1, "L": 1, "Q": 2, "C": 3}
"""Points that a command takes, of those that matplotlib writes."""
_SCALED = re.compile(r"scale\(([\d.]+)\)")
_ONLY_TRANSLATION = re.compile(r"translate\((-?[\d.]+) (-?[\d.]+)\)")
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_NOT_INHERITED = frozenset({"opacity", "clip-path", "mask", "filter"})
"""What is not moved to a group: it would act on the group as a whole."""


def compact_svg(svg: bytes) -> bytes:
    """Return the same picture in fewer bytes; the same bytes for the same bytes."""
    root = ElementTree.fromstring(svg)  # noqa: S314  our own
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
        element.tail = None
        if element.tag != "style":
            element.text = None
        if _HREF in element.attrib:
            element.set("href", element.attrib.pop(_HREF))
    for metadata in root.findall("metadata"):
        root.remove(metadata)
    _shorten_names(root)
    for element in root.iter():
        _shorten(element)
    _simplify(root)
    _name_styles(root)
    root.set("xmlns", _NAMESPACE)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)).replace(b" />", b"/>")


def _shorten_names(root: ElementTree.Element) -> None:
    """Give what is referred to a short name, and take the name from what is not."""
    used: Counter[str] = Counter()
    for element in root.iter():
        if (target := element.get("href", "")).startswith("#"):
            used[target[1:]] += 1
        used.update(name for value in element.attrib.values() for name in _REFERENCE.findall(value))
    often = sorted(used, key=lambda name: (-used[name], name))
    short = {name: _name(index) for index, name in enumerate(often)}
    for element in root.iter():
        name = element.get("id")
        if name is not None and name in short:
            element.set("id", short[name])
        elif name is not None:
            del element.attrib["id"]
        if (target := element.get("href", "")).startswith("#"):
            element.set("href", f"#{short[target[1:]]}")
        for key, value in element.attrib.items():
            if "url(#" in value:
                element.set(key, _REFERENCE.sub(lambda found: f"url(#{short[found[1]]})", value))


def _name(index: int) -> str:
    letters = "abcdefghijklmnopqrstuvwxyz"
    return letters[index] if index < len(letters) else _name(index // len(letters) - 1) + letters[index % len(letters)]


def _shorten(element: ElementTree.Element) -> None:
    if (drawn := element.get("d")) is not None:
        of_letter = _SCALED.fullmatch(element.get("transform", ""))
        element.set("d", _tight(drawn, float(of_letter[1]) if of_letter else 1.0))
        if of_letter:
            del element.attrib["transform"]
    for key in _POINTS:
        if (value := element.get(key)) is not None:
            element.set(key, _rounded(" ".join(value.split())))
    if (value := element.get("transform")) is not None:
        element.set("transform", _TRANSLATION.sub(lambda found: _rounded(found[0]), value))
    moved = _ONLY_TRANSLATION.fullmatch(element.get("transform", ""))
    if element.tag == "use" and moved is not None and "x" not in element.attrib and "y" not in element.attrib:
        del element.attrib["transform"]
        for key, value in zip("xy", moved.groups(), strict=True):  # of a letter: far less than what is seen
            if round(float(value)):
                element.set(key, f"{float(value):.0f}")
    if (style := element.get("style")) is not None:
        element.set("style", re.sub(r"\s*([:;])\s*", r"\1", style.strip()).rstrip(";"))


@lru_cache(maxsize=1024)  # of letters, which stand in every figure
def _tight(drawn: str, scale: float) -> str:
    """Return a path, scaled, in tenths: every point as the step from the one before, a command said once in a row.

    Steps are those between rounded points, so that they do not add up to an error.
    """
    words, at = _DRAWN.findall(drawn), 0
    parts: list[str] = []
    here, begun, before = (0, 0), (0, 0), ""
    while at < len(words):
        command = words[at]
        if command in "zZ":
            parts.append("z")
            here, before, at = begun, "", at + 1
            continue
        taken = 2 * _PAIRS[command]
        numbers = [round(10.0 * scale * float(word)) for word in words[at + 1 : at + 1 + taken]]
        points = list(zip(numbers[::2], numbers[1::2], strict=True))
        said, steps = _step(command, points, here)
        parts.append(_glued("" if said == before != "M" else said, steps))
        here, before, at = points[-1], said, at + 1 + taken
        begun = here if command == "M" else begun
    return "".join(parts)


def _step(command: str, points: list[tuple[int, int]], here: tuple[int, int]) -> tuple[str, list[int]]:
    """Return a command and its numbers, from the point before; where a path begins stays where it is."""
    if command == "M":
        return "M", list(points[0])
    steps = [value - start for point in points for value, start in zip(point, here, strict=True)]
    if command == "L" and 0 in steps:
        return ("h", steps[:1]) if steps[1] == 0 else ("v", steps[1:])
    return command.lower(), steps


def _glued(command: str, tenths: list[int]) -> str:
    """Return a command with its numbers; a sign parts as well as a space does."""
    numbers = [f"{value / 10:g}".replace("0.", ".", 1) if abs(value) < 10 else f"{value / 10:g}" for value in tenths]
    text = " ".join(numbers).replace(" -", "-")
    return f"{command}{text}" if command or text.startswith("-") else f" {text}"


def _rounded(text: str) -> str:
    return _NUMBER.sub(lambda found: f"{float(found[0]):.1f}".rstrip("0").rstrip("."), text)


def _simplify(parent: ElementTree.Element) -> None:
    """From the innermost outwards: a style once for a group, and no group that says nothing."""
    children: list[ElementTree.Element] = []
    for child in parent:
        _simplify(child)
        if child.tag == "g":
            _hoist_style(child)
        children.extend(child if child.tag == "g" and not child.attrib else [child] if _is_seen(child) else [])
    parent[:] = children


def _is_seen(element: ElementTree.Element) -> bool:
    """Return whether an element draws, or is referred to: an empty line may be neither."""
    return element.tag != "path" or "d" in element.attrib or "id" in element.attrib


def _hoist_style(group: ElementTree.Element) -> None:
    """Say once for a group what every one of its marks says; what it defines is drawn as its marks are."""
    marks = [child for child in group if child.tag != "defs"]
    if len(marks) < 2 or "style" in group.attrib or any(mark.tag != "use" for mark in marks):
        return
    said = [_declarations(mark) for mark in marks]
    shared = {
        name: value
        for name, value in said[0].items()
        if name not in _NOT_INHERITED and all(other.get(name) == value for other in said)
    }
    if not shared:
        return
    group.set("style", _style_of(shared))
    for mark, declared in zip(marks, said, strict=True):
        rest = _style_of({name: value for name, value in declared.items() if name not in shared})
        if rest:
            mark.set("style", rest)
        else:
            del mark.attrib["style"]


def _declarations(element: ElementTree.Element) -> dict[str, str]:
    parts = (entry.partition(":") for entry in element.get("style", "").split(";") if entry)
    return {name: value for name, _, value in parts}


def _style_of(declarations: dict[str, str]) -> str:
    return ";".join(f"{name}:{value}" for name, value in declarations.items())


def _name_styles(root: ElementTree.Element) -> None:
    """Say every style that is said more than once in the sheet of the picture, and only its name where it is used."""
    said: dict[str, list[ElementTree.Element]] = {}
    for element in root.iter():
        if (style := _whole_style(element)) and element.tag != "style":
            said.setdefault(style, []).append(element)
    sheet = root.find(".//style")
    if sheet is None:
        return
    rules = [" ".join((sheet.text or "").split())]
    for index, (style, elements) in enumerate(entry for entry in said.items() if len(entry[1]) > 1):
        rules.append(f".{_name(index)}{{{style}}}")
        for element in elements:
            element.set("class", _name(index))
            for key in ("style", "clip-path"):
                if key in element.attrib:
                    del element.attrib[key]
    sheet.text = "".join(rules)


def _whole_style(element: ElementTree.Element) -> str:
    clipped = element.get("clip-path")
    parts = (element.get("style", ""), f"clip-path:{clipped}" if clipped else "")
    return ";".join(filter(None, parts))
