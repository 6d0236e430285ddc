"""Draw the house: the rooms of each package, floor by floor, from the import contracts and the imports themselves.

    make house        writes the drawn part of docs/architecture.md anew; fails where rooms or files import in a circle

The floors are the `layers` contracts of pyproject.toml, what a room holds is the docstring of its package, and whom it
imports is read from the source, imports inside functions included.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("procedures", "rig", "ams")
PAGE = Path("docs") / "architecture.md"
BEGIN, END = "<!-- drawn by `make house` -->\n", "<!-- end of what is drawn -->\n"


@dataclass(frozen=True)
class House:
    """Modules with their imports of each other, and the floors that the contracts give them."""

    files: Mapping[str, Path]
    """Module to file."""
    imports: Mapping[str, frozenset[str]]
    """Module to the modules that it imports."""
    floors: Mapping[str, tuple[tuple[str, ...], ...]]
    """Package, or room with floors of its own, to its floors, the highest first, each of rooms and loose modules."""

    def room(self, module: str) -> str:
        """Return the package in which a module stands."""
        return module if self.files[module].name == "__init__.py" else module.rpartition(".")[0]

    def knots(self) -> dict[str, frozenset[str]]:
        """Return room to the rooms it imports, where none may hang in a circle with another.

        A room and those inside it are two; what stands loose in a top package is a room of its own, on its own floor.
        """
        rooms = {module: self.room(module) for module in self.files}
        rooms |= {module: module for module, room in rooms.items() if room in PACKAGES}
        found: dict[str, set[str]] = {room: set() for room in rooms.values()}
        for module, imported in self.imports.items():
            found[rooms[module]] |= {rooms[other] for other in imported} - {rooms[module]}
        return {room: frozenset(others) for room, others in found.items()}

    def rooms(self) -> dict[str, frozenset[str]]:
        """Return room to the rooms it imports outside itself: what lies inside it is its own business."""
        found: dict[str, set[str]] = {self.room(module): set() for module in self.files}
        for module, imported in self.imports.items():
            here = self.room(module)
            there = {self.room(other) for other in imported} - {here}
            found[here] |= {room for room in there if not _is_inside(room, here) and not _is_inside(here, room)}
        return {room: frozenset(others) for room, others in found.items()}


def _is_inside(room: str, outer: str) -> bool:
    return room.startswith(f"{outer}.")


def read_house(root: Path = ROOT) -> House:
    """Read every module of the three packages, and the contracts."""
    files = {_module(path.relative_to(root)): path for path in _sources(root)}
    imports = {module: frozenset(_imported(module, path, files)) for module, path in files.items()}
    settings = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    return House(files, imports, dict(_floors(settings)))


def circle_in(graph: Mapping[str, Iterable[str]]) -> list[str]:
    """Return one circle of the graph, or nothing."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def drawing(house: House) -> str:
    """Return the drawn part of the page: a list of floors for every package."""
    rooms = house.rooms()
    parts = []
    for package in PACKAGES:
        parts.append(f"### `{package}/`: {_purpose(house.files[package])}\n")
        parts.append("| floor | room | what is in it | files | imports |\n|---|---|---|---|---|")
        floors = house.floors[package]
        for height, floor in enumerate(floors):
            for room in (f"{package}.{name}" for name in floor):
                parts += _rows(house, rooms, room, len(floors) - height)
        parts.append("")
        for container in (name for name in house.floors if name.startswith(f"{package}.")):
            parts += _inside(house, container)
    return "\n".join(parts)


def redraw(page: str, drawn: str) -> str:
    """Return the page with its drawn part made anew."""
    head, _, rest = page.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return f"{head}{BEGIN}\n{drawn}{END}{tail}"


def main() -> int:
    """Write the page; 1 and a sentence where something imports in a circle."""
    house = read_house()
    for what, graph in (("files", house.imports), ("rooms", house.knots())):
        if circle := circle_in(graph):
            print(f"{what} import in a circle: {' -> '.join(circle)}")
            return 1
    page = ROOT / PAGE
    page.write_text(redraw(page.read_text(encoding="utf-8"), drawing(house)), encoding="utf-8")
    print(f"{PAGE}: {len(house.files)} files in {len(house.rooms())} rooms, no circle, no knot")
    return 0


def _sources(root: Path) -> Iterator[Path]:
    for package in PACKAGES:
        yield from (path for path in sorted((root / package).rglob("*.py")) if "migrations" not in path.parts)


@cache
def tree_of(path: Path) -> ast.Module:
    """Return what a file says, parsed once."""
    return ast.parse(path.read_text(encoding="utf-8"))


def _module(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(module: str, path: Path, files: Mapping[str, Path]) -> Iterator[str]:
    if module == "ams":
        return  # the facade loads its names when they are first used: whoever imports `ams` imports nothing yet
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in files)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                name = f"{node.module}.{alias.name}"
                found = name if name in files else node.module
                if found in files and found != module:
                    yield found
        elif isinstance(node, ast.Call) and (name := imported_by_name(node)) in files:
            yield name


def imported_by_name(node: ast.AST) -> str:
    """Return what a call of ``import_module`` with its name spelled out imports; empty for anything else."""
    match node:
        case ast.Call(func=ast.Name("import_module"), args=[ast.Constant(str(name)), *_]):
            return name
    return ""


def _floors(settings: Mapping[str, Any]) -> Iterator[tuple[str, tuple[tuple[str, ...], ...]]]:
    for contract in settings["tool"]["importlinter"]["contracts"]:
        for container in contract.get("containers", ()):
            yield container, tuple(tuple(re.split(r"\s*[|:]\s*", layer)) for layer in contract["layers"])


def _purpose(path: Path) -> str:
    docstring = ast.get_docstring(tree_of(path)) or ""
    first, _, _ = docstring.partition("\n\n")
    return " ".join(first.split())


def _rows(house: House, rooms: Mapping[str, frozenset[str]], room: str, floor: int) -> Iterator[str]:
    inside = sorted(name for name in rooms if name == room or name.startswith(f"{room}."))
    if not inside:
        yield f"| {floor} | `{room.replace('.', '/')}.py` | {_purpose(house.files[room])} | 1 | |"
    for name in inside:
        files = sum(house.room(module) == name for module in house.files) - 1
        known = ", ".join(f"`{other.replace('.', '/')}`" for other in sorted(rooms[name]) if other not in PACKAGES)
        where = f"{floor}{_floor_inside(house, room, name)}"
        yield f"| {where} | `{name.replace('.', '/')}/` | {_purpose(house.files[name])} | {files} | {known} |"


def _floor_inside(house: House, room: str, name: str) -> str:
    """Return ``.4`` for a room that stands on the fourth floor of the room around it; empty for any other."""
    floors = house.floors.get(room, ())
    within = name.removeprefix(f"{room}.")
    return next((f".{len(floors) - height}" for height, floor in enumerate(floors) if within in floor), "")


def _inside(house: House, container: str) -> Iterator[str]:
    """Yield the floors of a room that has its own."""
    yield f"Inside `{container.replace('.', '/')}/`:\n"
    yield "| floor | files and rooms |\n|---|---|"
    floors = house.floors[container]
    for height, floor in enumerate(floors):
        names = (f"`{name}{'.py' if house.files[f'{container}.{name}'].stem == name else '/'}`" for name in floor)
        yield f"| {len(floors) - height} | {', '.join(names)} |"
    yield ""


if __name__ == "__main__":
    sys.exit(main())
