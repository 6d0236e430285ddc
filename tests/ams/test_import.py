"""Importing ams is cheap: numpy and nothing heavier, whatever the package offers."""

import subprocess
import sys

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
    import ams

    assert set(ams.__all__) <= set(dir(ams))
    assert all(hasattr(ams, name) for name in ams.__all__)
