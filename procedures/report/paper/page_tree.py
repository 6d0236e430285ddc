"""A page of ours as a tree that the typesetter reads: elements with classes, text with its white space collapsed.

The paper is made from the page itself, so the two cannot differ. Only the vocabulary of our own templates is known;
anything else is a defect of a template and said so, instead of a paragraph lost on paper.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Any
from urllib.parse import unquote_to_bytes

ON_SCREEN_ONLY = frozenset({"head", "nav"})
INLINE = frozenset({"a", "b", "i", "sub", "span", "br", "img"})
BLOCKS = frozenset(
    {"html", "body", "main", "header", "section", "div", "footer", "h1", "h2", "h3", "p", "ul", "li", "dl", "dt", "dd"}
    | {"table", "thead", "tbody", "tr", "th", "td", "figure", "figcaption"}
)
NEVER_CLOSED = frozenset({"br", "img", "meta"})
KEPT = ("id", "colspan", "alt")
PICTURE = "data:image/svg+xml,"


@dataclass
class Element:
    """One element of the page."""

    tag: str
    classes: Sequence[str] = ()
    attributes: Mapping[str, str] = field(default_factory=dict)
    children: list["Element | str"] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Return the form that the typst template reads: ``tag``, ``class``, ``children`` and its attributes."""
        children = [child if isinstance(child, str) else child.as_json() for child in self.children]
        return {"tag": self.tag, "class": list(self.classes), "children": children, **self.attributes}


@dataclass(frozen=True)
class PageTree:
    """A page taken apart."""

    body: Element
    pictures: Mapping[str, bytes]
    """File name to SVG, as the tree's ``img`` elements name them under ``file``."""


def page_tree_of(page: str) -> PageTree:
    """Take a rendered page apart. Raises: ValueError for an element that the paper has no form of."""
    reader = _Reader()
    reader.feed(page)
    reader.close()
    _tidy(reader.root)
    return PageTree(reader.root, reader.pictures)


class _Reader(HTMLParser):
    """Builds the tree; what is for the screen only is passed over."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.root = Element("page")
        self.pictures: dict[str, bytes] = {}
        self._open = [self.root]
        self._passed_over = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if self._passed_over or tag in ON_SCREEN_ONLY:
            self._passed_over += tag not in NEVER_CLOSED
            return
        if tag not in BLOCKS | INLINE:
            raise ValueError(f"report: the paper has no form of <{tag}>: teach procedures/report/paper or leave it out")
        element = self._element(tag, {name: value or "" for name, value in attrs})
        self._open[-1].children.append(element)
        if tag not in NEVER_CLOSED:
            self._open.append(element)

    def handle_endtag(self, tag: str) -> None:
        if self._passed_over:
            self._passed_over -= 1
        elif self._open.pop().tag != tag:
            raise ValueError(f"report: </{tag}> closes another element: a template is not well formed")

    def handle_data(self, data: str) -> None:
        if not self._passed_over:
            self._open[-1].children.append(data)

    def _element(self, tag: str, attributes: dict[str, str]) -> Element:
        kept = {name: attributes[name] for name in KEPT if name in attributes}
        if tag == "img":
            kept["file"] = self._picture(attributes["src"])
        return Element(tag, attributes.get("class", "").split(), kept)

    def _picture(self, source: str) -> str:
        if not source.startswith(PICTURE):
            raise ValueError(f"report: a picture that is not inside the page: {source[:60]!r}")
        name = f"figure-{len(self.pictures) + 1}.svg"
        self.pictures[name] = unquote_to_bytes(source.removeprefix(PICTURE))
        return name


def _tidy(element: Element) -> None:
    """Collapse white space as a browser does: runs to one space, none at the edges of a block or beside one."""
    children: list[Element | str] = []
    for child in element.children:
        if isinstance(child, str):
            children.append(re.sub(r"[ \t\r\n]+", " ", child))
        else:
            _tidy(child)
            children.append(child)
    if element.tag not in INLINE:
        children = [_trimmed(children, index) for index in range(len(children))]
    element.children = [child for child in children if child != ""]


def _trimmed(children: Sequence[Element | str], index: int) -> Element | str:
    text = children[index]
    if not isinstance(text, str):
        return text
    text = text.lstrip(" ") if index == 0 or _is_block(children[index - 1]) else text
    return text.rstrip(" ") if index == len(children) - 1 or _is_block(children[index + 1]) else text


def _is_block(child: Element | str) -> bool:
    return isinstance(child, Element) and (child.tag in BLOCKS or child.tag == "br")
