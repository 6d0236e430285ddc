"""Importing ams is cheap: numpy and nothing heavier, whatever the package offers."""

import subprocess
import sys
from pathlib import Path

import numpy as np

import ams

ROOT = Path(__file__).parents[2]
SET = ROOT / "tests" / "data" / "coefficient_set_v1.json"

HEAVY = ("scipy", "pandas", "matplotlib", "sqlalchemy", "pydantic", "pymodbus", "jsonschema")


def loaded_by(statement: str) -> set[str]:
    code = f"import sys\n{statement}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(result.stdout.split())


def test_the_package_and_its_core_names_need_numpy_only() -> None:
    loaded = loaded_by(
        "import ams, ams.calibration.calibrate; ams.apply; ams.read_csv; ams.to_document; ams.evaluate_design; "
        "ams.load; ams.load_gyros"
    )
    assert "numpy" in loaded
    assert not loaded & set(HEAVY)


def test_what_is_offered_is_listed_for_those_who_look_around() -> None:
    assert set(ams.__all__) <= set(dir(ams))
    assert all(hasattr(ams, name) for name in ams.__all__)


NUMPY_ALONE = """
import importlib.abc, sys
import numpy

class NothingElse(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in ("numpy", "ams") and top not in sys.stdlib_module_names and not top.startswith("_"):
            raise ModuleNotFoundError(f"no {name} here", name=name)

sys.meta_path.insert(0, NothingElse())
import ams
from ams.errors import SolveError

found = ams.load_set("tests/data/coefficient_set_v1.json")
assert ams.verify("tests/data/coefficient_set_v1.json").forward_vectors > 0
volts = ams.apply(found, numpy.deg2rad([10.0, -20.0]), numpy.deg2rad([30.0, 60.0]), 20.0)
ams.export_set(found, "json", sys.argv[1])
print({axis: numpy.round(values, 3).tolist() for axis, values in volts.items()})
try:
    from ams.calibration.calibrate import calibrate
    axes = {"x": "sx_v", "y": "sy_v", "z": "sz_v"}
    calibrate(ams.read_csv("examples/observations.csv", axes), ams.CalibrationRequest(model="pitch-roll"))
except SolveError as error:
    print(error)
"""


def test_a_set_is_read_verified_applied_and_written_with_numpy_alone(tmp_path: Path) -> None:
    command = [sys.executable, "-c", NUMPY_ALONE, str(tmp_path / "set.json")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    volts, sentence = done.stdout.splitlines()
    expected = ams.apply(ams.load_set(SET), np.deg2rad([10.0, -20.0]), np.deg2rad([30.0, 60.0]), 20.0)
    assert volts == str({axis: np.round(values, 3).tolist() for axis, values in expected.items()})
    assert sentence.startswith("tests and intervals of a calibration need scipy, which is not installed")
    assert (tmp_path / "set.json").read_bytes() == SET.read_bytes()
