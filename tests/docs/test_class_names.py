"""In one room a name stands for one class: who reads it need not ask which module it is from."""

import re
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[2]
CLASS = re.compile(r"^class ([A-Z]\w*)", re.MULTILINE)
OF_A_DEVICE = {"Chamber", "Command", "Preset", "Status", "VoltageSource"}
"""Words of one device's protocol or twin, always read with the module that is named for the device."""
OF_THE_INTERFACE = {"Attitude"}
"""Where a model is evaluated, in radians, and what `ams` answers its user, in degrees with standard deviations."""
PACKAGES = ("ams", "rig", "procedures")


def named_twice(room: Path) -> dict[str, list[str]]:
    """Return every name of a public class that stands in two files of a folder, with the files."""
    found: dict[str, list[str]] = defaultdict(list)
    for path in sorted(room.glob("*.py")):
        for name in CLASS.findall(path.read_text(encoding="utf-8")):
            found[name].append(path.name)
    return {name: files for name, files in found.items() if len(files) > 1}


def test_no_public_class_name_stands_twice_in_one_room() -> None:
    rooms = {path.parent for package in PACKAGES for path in (ROOT / package).rglob("__init__.py")}
    assert len(rooms) > 50
    twice = {str(room.relative_to(ROOT)): set(named_twice(room)) - OF_A_DEVICE - OF_THE_INTERFACE for room in rooms}
    assert {room: names for room, names in twice.items() if names} == {}


def test_a_name_that_stands_twice_is_found(tmp_path: Path) -> None:
    for name in ("first", "second"):
        (tmp_path / f"{name}.py").write_text("class Section:\n    pass\nclass _Own:\n    pass\n", encoding="utf-8")
    assert named_twice(tmp_path) == {"Section": ["first.py", "second.py"]}
