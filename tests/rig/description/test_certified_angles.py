"""One certificate, one number: what an axis, a level or a reference declares is never better than its standard."""

from math import radians
from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG, changed

from procedures.solution.level_of_base import level_errors
from procedures.solution.type_b import standard_uncertainty_arcsec
from rig.description.read import read_rig
from rig.errors import DescriptionError

CERTIFIED = 'kind = "limit"\nuncertainty_arcsec = 1.0'
DECLARED = "uncertainty_arcsec = 1.0\nstandard"


def test_an_axis_better_than_its_certificate_is_refused(tmp_path: Path) -> None:
    """The report listed ±40″ of the table beside an uncertainty that was counted with 1″."""
    path = changed(EXAMPLE_RIG, CERTIFIED, CERTIFIED.replace("1.0", "40.0"), tmp_path / "rig.toml")
    with pytest.raises(DescriptionError) as refused:
        read_rig(path)
    for name in ("pitch", "roll"):
        sentence = (
            f"axes.{name}.uncertainty_arcsec: got 1, and its standard states 40 (standards.table.uncertainty_arcsec)"
        )
        assert sentence in str(refused.value)


def test_an_axis_may_be_worse_than_its_certificate(tmp_path: Path) -> None:
    path = changed(EXAMPLE_RIG, CERTIFIED, CERTIFIED.replace("1.0", "0.5"), tmp_path / "rig.toml")
    assert read_rig(path).axes["pitch"].uncertainty_arcsec == 1.0


@pytest.mark.parametrize(("kind", "u_arcsec"), [("limit", 3.0**0.5), ("standard", 3.0), ("expanded", 1.5)], ids=str)
def test_an_axis_that_leaves_it_to_its_standard_has_the_certificates_number(
    tmp_path: Path, kind: str, u_arcsec: float
) -> None:
    text = EXAMPLE_RIG.read_text(encoding="utf-8").replace(DECLARED, "standard")
    path = tmp_path / "rig.toml"
    path.write_text(text.replace(CERTIFIED, f'kind = "{kind}"\nuncertainty_arcsec = 3.0'), encoding="utf-8")
    rig = read_rig(path)
    assert [standard_uncertainty_arcsec(rig, name) for name in ("pitch", "roll")] == pytest.approx([u_arcsec] * 2)


def test_a_reference_better_than_its_certificate_is_refused(tmp_path: Path) -> None:
    """5.76″ at k = 2 is a standard uncertainty of 0.0008°."""
    example = EXAMPLE_RIG.parent / "inclinometer" / "rig.toml"
    assert read_rig(example).attitude_reference is not None
    path = changed(example, "uncertainty_deg = 0.0008", "uncertainty_deg = 0.0004", tmp_path / "rig.toml")
    with pytest.raises(DescriptionError, match=r"attitude_reference.uncertainty_deg: got 0.0004 .* states 0.0008 "):
        read_rig(path)


LEVEL = """
[standards.level]
serial = "L-12"
certificate = "26-0311"
due = 2027-06-30
kind = "{kind}"
uncertainty_arcsec = 0.6

[level]
instrument = "electronic level 6"
standard = "{name}"
"""


def _with_level(folder: Path, more: str = "", *, kind: str = "expanded", name: str = "level") -> Path:
    path = folder / "rig.toml"
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    path.write_text(text + LEVEL.format(kind=kind, name=name) + more, encoding="utf-8")
    return path


@pytest.mark.parametrize("kind", ["limit", "standard", "expanded"])
def test_a_level_that_leaves_it_to_its_standard_has_the_certificates_number(tmp_path: Path, kind: str) -> None:
    """Of U at k = 2 half is the standard uncertainty, of a limit the part 1/√3: GUM 4.3.3, 4.3.7."""
    rig = read_rig(_with_level(tmp_path, kind=kind))
    u_arcsec = {"limit": 0.6 / 3.0**0.5, "standard": 0.6, "expanded": 0.3}[kind]
    found = {error.effect: error.standard_uncertainty for error in level_errors(rig)}
    assert found == pytest.approx(dict.fromkeys(("pitch", "base-tilt"), radians(u_arcsec / 3600.0)))


def test_a_level_may_be_worse_than_its_certificate_and_not_better(tmp_path: Path) -> None:
    assert read_rig(_with_level(tmp_path, "uncertainty_arcsec = 0.8")).level.uncertainty_arcsec == 0.8
    better = _with_level(tmp_path, "uncertainty_arcsec = 0.5")
    with pytest.raises(DescriptionError, match=r"level.uncertainty_arcsec: got 0.5, and its standard states 0.6 "):
        read_rig(better)


def test_a_level_names_a_standard_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"level.standard: no standard 'spirit' \(allowed: table, level\)"):
        read_rig(_with_level(tmp_path, name="spirit"))
