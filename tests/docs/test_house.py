"""The house is as its page draws it: no circle, no knot, and nothing is imported late but what is named here."""

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from definitions import unreached

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs"))
from house import BEGIN, PAGE, circle_in, drawing, imported_by_name, read_house, redraw, tree_of  # noqa: E402

OWN = ("ams", "rig", "procedures")
LONGEST_FILE, LONGEST_BODY = 400, 50
"""Lines; what is longer has a seam at which it is divided."""
LATER = {
    # ours: what one command of several needs, and the facade whose names load at their first use
    "procedures.jog_screen.session": {"procedures/cli/bench/jog.py"},
    "importlib.metadata": {"procedures/cli/main.py", "procedures/import_name/calrig/__init__.py"},
    "procedures.cli.support": {"procedures/cli/main.py"},
    # the stop goes before anything else is imported
    "procedures.cli": {"procedures/cli/main.py", "procedures/cli/start.py", "procedures/cli/stop_at_once.py"},
    "procedures.journal.requests.spool": {"procedures/cli/stop_at_once.py"},
    "procedures.errors": {"procedures/cli/stop_at_once.py"},
    "rig.clock": {"procedures/cli/stop_at_once.py"},
    "rig.plain_text": {"procedures/cli/stop_at_once.py"},
    "pathlib": {"procedures/cli/stop_at_once.py"},
    "pwd": {"procedures/cli/stop_at_once.py"},
    "json": {"procedures/cli/stop_at_once.py"},
    # heavy: half a second and more, and most commands do without
    "matplotlib": {"procedures/report/canvas.py", "procedures/report/paper/letters.py"},
    "procedures.data.drawings": {  # matplotlib
        "procedures/data/run_data.py",
        "procedures/data/solved.py",
        "procedures/facade/planning.py",
    },
    "typst": {"procedures/report/paper/pdf.py"},
    "scipy.special": {"ams/statistics/distributions.py"},
    "scipy.linalg": {"ams/solve/gauss_newton.py"},
    "scipy.signal": {"ams/attitude/filters.py"},
    "scipy.io": {"ams/exports/matlab.py"},
    "pandas": {"ams/inputs/number_blocks.py", "procedures/cli/attitude/rows.py"},
    "alembic": {"ams/archive/connection.py"},
    "jsonschema": {"ams/sets/schema.py"},
    # optional: extras of the installation
    "procedures.console.serve": {"procedures/cli/steer/console.py"},  # uvicorn
    "procedures.console.shared": {"procedures/cli/steer/console.py"},  # starlette
    "pyvisa": {"rig/link/visa.py"},
    "apprise": {"procedures/alerts/channels.py"},
    "distributed": {"procedures/delivery/resolve_workers.py"},
    "h5py": {"ams/exports/hdf5.py", "ams/inputs/hdf5_blocks.py"},
    "pyarrow": {"procedures/cli/attitude/rows.py", "ams/inputs/number_blocks.py"},
    "procedures.data.dataset": {"procedures/data/write.py"},  # xarray
}
"""What is imported inside functions, and the only files that may."""

WORDS = {
    "told": "message",
    "asked": "request",
    "one": "item",
    "own": "settings",
    "place": "location",
    "places": "locations",
    "felt": "specific_force",
    "seam": "restart_step",
    "desk": "dispatcher",
    "courier": "channel",
    "couriers": "channels",
    "conduct": "context",
    "kids": "children",
    "signoff": "signatures",
    "takeover": "upgrade",
    "admission": "start_checks",
    "beforehand": "preflight",
    "precautions": "run_limits",
    "inhibit": "keep_awake",
    "widened": "added_parameters",
    "belonging": "applicability",
    "native": "plain_values",
    "seal": "checksum_line",
}
"""Words that say nothing of what a name holds, and what was written instead where they stood."""
GONE = {"admission", "conduct", "courier", "couriers", "desk", "felt", "kids", "pen", "seam", "takeover"}
"""Those of them, and ``pen``, that are no word of what is said about the code either."""
RIGHT = {
    # the number 1
    "BEYOND_ONE_G", "ONE_AXIS_WORDS", "ONE_LINE_ONLY", "ON_ONE_SIDE", "OneAxis", "_ONE", "_ONE_OF_TWO", "_ONE_SIDE",
    "_ON_ONE_LINE", "_at_one_gravity", "_is_one_of_many", "_is_one_plain_line", "_of_one_and_two", "_one_axis",
    "_of_one_temperature", "_one_or_several", "_one_replication", "_one_sided", "_one_thread",
    "_stop_one_after_the_other", "_tells_its_unit_in_one_way", "draw_one_axis", "dwells_on_one_clock",
    "is_of_one_channel", "is_of_one_quantity", "on_one_clock", "on_one_line", "on_one_side", "one_axis",
    "one_axis_codes", "one_axis_factor", "one_line", "one_thread",
    # keys of files, journals and the archive: what is stored keeps its name
    "own_temperature_degc", "own_temperature_drift_degc_per_h", "own_thermometer",
    # of a decimal
    "decimal_place", "last_place", "to_place",
}  # fmt: skip
FOR_TESTS = {
    "rig.link.faults:FaultScript",
    "rig.link.faults:hang_up",
    "rig.twins.serving.servers:serve_pty",
    "rig.twins.serving.servers:serve_tcp",
}
"""Twins on ports and lines with faults, which stand beside what they imitate and serve tests alone."""
STORED = {("procedures/journal/requests/spool.py", "place"), ("ams/archive/leases.py", "place")}
"""Fields whose names are keys of what is stored."""


@pytest.fixture(scope="module")
def house():
    return read_house(ROOT)


def test_files_import_in_no_circle(house):
    assert circle_in(house.imports) == []


def test_rooms_import_in_no_circle(house):
    assert circle_in(house.knots()) == []


def test_the_page_is_drawn_from_the_house(house):
    page = (ROOT / PAGE).read_text(encoding="utf-8")
    assert BEGIN in page
    assert page == redraw(page, drawing(house)), "run `make house` and look at what changed"


def test_where_to_look_leads_to_files_that_are_there():
    page = (ROOT / PAGE).read_text(encoding="utf-8")
    rows = re.findall(r"^\| .* \| (.*`.*) \|$", page.partition("## Where to look")[2].partition(BEGIN)[0], re.MULTILINE)
    assert rows
    lost = []
    for row in rows:
        folder = ROOT
        for name in re.findall(r"`([a-z_0-9./]+(?:\.py|\.json|/))`", row):
            found = next((path for path in (ROOT / name, folder / name) if path.exists()), None)
            lost += [name] if found is None else []
            folder = folder if found is None else found.parent
    assert lost == []


def test_every_room_says_what_is_in_it(house):
    silent = [room for room in house.rooms() if not ast.get_docstring(tree_of(house.files[room]))]
    assert silent == []


@pytest.fixture(scope="module")
def trees(house) -> dict[str, ast.Module]:
    return {path.relative_to(ROOT).as_posix(): tree_of(path) for path in house.files.values()}


def test_files_and_bodies_stay_short(house, trees):
    files = [path for path in house.files.values() if len(path.read_text(encoding="utf-8").splitlines()) > LONGEST_FILE]
    bodies = [
        f"{path}: {node.name}"
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and _body_lines(node) > LONGEST_BODY
    ]
    assert (files, bodies) == ([], [])


def _body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return how many lines a body has without its docstring."""
    body = function.body[1 if ast.get_docstring(function) is not None else 0 :]
    return (function.end_lineno or 0) - body[0].lineno + 1 if body else 0


def test_nothing_else_is_imported_inside_a_function(trees):
    unnamed = [f"{path}: {name}" for path, name in _imported_later(trees) if path not in _allowed(name)]
    assert unnamed == []


def test_every_late_import_that_is_named_is_still_there(trees):
    found = {(path, library) for path, name in _imported_later(trees) for library in LATER if _is_of(name, library)}
    assert found == {(path, library) for library, paths in LATER.items() for path in paths}


def _allowed(name: str) -> set[str]:
    return set().union(*(paths for library, paths in LATER.items() if _is_of(name, library)))


def _is_of(name: str, library: str) -> bool:
    return name == library or name.startswith(f"{library}.")


def _imported_later(trees: dict[str, ast.Module]) -> Iterator[tuple[str, str]]:
    for path, tree in trees.items():
        for node in _in_functions(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                yield path, node.module
            elif isinstance(node, ast.Import):
                yield from ((path, alias.name) for alias in node.names)
            elif name := imported_by_name(node):
                yield path, name


@cache
def _in_functions(tree: ast.Module) -> list[ast.AST]:
    """Imports and calls of names that stand inside functions; walked once for every law that looks at them."""
    waiting: list[tuple[ast.AST, bool]] = [(tree, False)]
    found: list[ast.AST] = []
    while waiting:
        node, is_inside = waiting.pop()
        if is_inside and isinstance(node, (ast.Import, ast.ImportFrom, ast.Call)):
            found.append(node)
        is_inside = is_inside or isinstance(node, ast.FunctionDef)
        waiting += ((child, is_inside) for child in ast.iter_child_nodes(node))
    return found


def test_what_is_imported_by_a_name_that_is_made_up_stands_in_two_files(trees):
    """A name that is not spelled out is seen by no contract: the facade's table, optional libraries."""
    found = set()
    for path, tree in trees.items():
        if "import_module" not in (text := (ROOT / path).read_text(encoding="utf-8")) and "__import__" not in text:
            continue
        calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
        names = {call.func.id: call for call in calls if call.func.id in ("import_module", "__import__")}
        by_name = [call for call in calls if call.func.id == "import_module"]
        if any(not imported_by_name(call) for call in by_name) or "__import__" in names:
            found.add(path)
    assert found == {
        "ams/__init__.py",
        "ams/exports/optional_libraries.py",
        "procedures/import_name/calrig/__init__.py",
        "rig/system_parts.py",
    }


def test_what_only_tests_use_is_no_part_of_the_product(trees) -> None:
    """A law about a function that nothing comes to proves what no user runs; yardsticks stand in tests/support."""
    modules = {_dotted(path): tree for path, tree in trees.items()}
    for path in (ROOT / "ams/archive/migrations").rglob("*.py"):
        modules[_dotted(path.relative_to(ROOT).as_posix())] = tree_of(path)
    entries = set(re.findall(r'"([\w.]+):(\w+)"', (ROOT / "pyproject.toml").read_text(encoding="utf-8")))
    facades = ("ams", "procedures.import_name.calrig", "rig.testing")
    offered = {
        (node.module or "", alias.name)
        for name in facades
        for node in ast.walk(modules[name])
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    hooks = {(name, hook) for name in facades for hook in ("__dir__", "__getattr__")}
    hooks |= {(name, hook) for name in modules if ".migrations." in name for hook in ("upgrade", "downgrade")}
    found = unreached(modules, entries | offered | hooks | _documented(modules))
    assert set(found) == FOR_TESTS


def _dotted(path: str) -> str:
    return path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")


def _documented(modules: dict[str, ast.Module]) -> set[tuple[str, str]]:
    """Return the definitions that a page names as code, beside the whole name of their module."""
    found = set()
    for page in sorted((ROOT / "docs").glob("*.md")):
        code = re.findall(r"`([^`\n]+)`", page.read_text(encoding="utf-8"))
        dotted = {part for text in code for part in re.findall(r"[\w.]+\w", text)}
        words = {word for text in code for word in re.findall(r"\w+", text)}
        for whole in dotted:
            module = whole if whole in modules else whole.rpartition(".")[0]
            if module in modules and "." in module:
                names = {node.name for node in modules[module].body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
                found |= {(module, name) for name in names & words}
    return found


def test_rig_and_ams_register_in_one_way() -> None:
    """They never meet, so each has the file; whoever mends one mends both."""
    assert (ROOT / "rig/registry.py").read_text(encoding="utf-8") == (ROOT / "ams/registry.py").read_text(
        encoding="utf-8"
    )


def test_names_say_what_they_hold(trees) -> None:
    """Modules, classes, functions, fields, parameters and variables, in the tests' support as well."""
    beside = [
        path for folder in ("bench", "docs", "examples", "tests/support") for path in (ROOT / folder).rglob("*.py")
    ]
    every = trees | {path.relative_to(ROOT).as_posix(): tree_of(path) for path in beside}
    vague = {
        (path, name, word)
        for path, tree in every.items()
        for name in {Path(path).stem, *_names_in(tree)} - RIGHT
        for word in _words_of(name)
        if word in WORDS and (path, name) not in STORED
    }
    assert sorted(f"{path}: {name}: for example {WORDS[word]}" for path, name, word in vague) == []


def test_what_is_written_about_the_code_has_its_words(trees) -> None:
    """Docstrings say dispatcher where the name does; what stands in ``…`` is a word of a file."""
    beside = {path.relative_to(ROOT).as_posix(): tree_of(path) for path in (ROOT / "tests/support").rglob("*.py")}
    gone = [
        f"{path}:{node.lineno}: {word}"
        for path, tree in (trees | beside).items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        for word in re.findall(r"[a-z]+", re.sub(r"``.*?``", "", node.value.value.lower(), flags=re.DOTALL))
        if word in GONE
    ]
    assert gone == []


def _names_in(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case (
                ast.FunctionDef(name=name)
                | ast.AsyncFunctionDef(name=name)
                | ast.ClassDef(name=name)
                | ast.ExceptHandler(name=str(name))
            ):
                yield name
            case ast.arg(arg=name) | ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                yield name
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield name


@cache
def _words_of(name: str) -> list[str]:
    return re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name).lower().split("_")
