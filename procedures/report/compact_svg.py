"""A figure's SVG without what nobody sees: less than half of the bytes, drawn the same.

Matplotlib writes six decimals of a point, a group around every tick and a style at every mark. Coordinates keep a
tenth of a point (35 µm on paper); scales, which multiply, keep every digit.
"""

import re
from collections import Counter
from xml.etree import ElementTree

_NAMESPACE, _HREF = "http://www.w3.org/2000/svg", "{http://www.w3.org/1999/xlink}href"
_POINTS = ("x", "y", "x1", "x2", "y1", "y2", "width", "height", "points")
_NUMBER = re.compile(r"-?\d+\.\d{2,}(?:e-?\d+)?")
_TRANSLATION = re.compile(r"translate\([^)]*\)")
_LINE = re.compile(r"^M ([-\d.]+) ([-\d.]+) L ([-\d.]+) ([-\d.]+)$")
_ONLY_TRANSLATION = re.compile(r"translate\((-?[\d.]+) (-?[\d.]+)\)")
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_NOT_INHERITED = ("opacity:", "clip-path", "mask", "filter")
"""Of a style that holds one of these nothing is moved to the group: it would act on the group as a whole."""


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
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


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
        element.set("d", _tight(drawn))
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


def _tight(drawn: str) -> str:
    """Return a path without the spaces that its letters and signs make needless."""
    text = _LINE.sub(_straight, _rounded(" ".join(drawn.split())))
    return re.sub(r" ?([A-Za-z]) ?", r"\1", text).replace(" -", "-")


def _straight(found: re.Match[str]) -> str:
    x, y, to_x, to_y = found.groups()
    return f"M{x} {y}V{to_y}" if x == to_x else f"M{x} {y}H{to_x}" if y == to_y else found[0]


def _rounded(text: str) -> str:
    return _NUMBER.sub(lambda found: f"{float(found[0]):.1f}".rstrip("0").rstrip("."), text)


def _simplify(parent: ElementTree.Element) -> None:
    """From the innermost outwards: a style once for a group, and no group that says nothing."""
    children: list[ElementTree.Element] = []
    for child in parent:
        _simplify(child)
        if child.tag == "g":
            _hoist_style(child)
        children.extend(child if child.tag == "g" and not child.attrib else [child])
    parent[:] = children


def _hoist_style(group: ElementTree.Element) -> None:
    """Say once for a group what every one of its marks says."""
    styles = {child.get("style", "") for child in group}
    if len(group) < 2 or len(styles) != 1 or "style" in group.attrib or any(child.tag != "use" for child in group):
        return
    style = styles.pop()
    if not style or any(word in style for word in _NOT_INHERITED):
        return
    group.set("style", style)
    for child in group:
        del child.attrib["style"]


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
