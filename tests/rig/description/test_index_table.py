"""Laws of a file of index errors: read whole, every mistake named by file, line and column."""

from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG

from rig.description.index_table import IndexTable, read_index_table
from rig.description.read import read_rig, rig_from_json
from rig.errors import DescriptionError

HEADER = "angle_deg,error_arcsec,uncertainty_arcsec\n"
LIMITS_DEG = (-90.0, 90.0)
FAULTS = [
    ("angle,error\n0,1\n", r"index.csv:1: header: got angle, error, allowed angle_deg,error_arcsec,uncertainty_arcsec"),
    ("", "index.csv:1: header: got an empty file"),
    (HEADER + "-90,1,0.1\n90,x,0.1\n", r"index.csv:3: error_arcsec: got x, allowed a finite number"),
    (HEADER + "-90,1,0.1\n,1,0.1\n", r"index.csv:3: angle_deg: got nothing, allowed a finite number"),
    (HEADER + "-90,1,0.1\n90,1,-0.1\n", r"index.csv:3: uncertainty_arcsec: got -0.1, allowed 0 or more"),
    (HEADER + "-90,1\n", r"index.csv:2: got 2 cells, allowed 3"),
    (HEADER + "-90,1,0.1\n", r"index.csv:1: got 1 angles, allowed 2 or more"),
    (HEADER + "-90,1,0.1\n60,1,0.1\n30,1,0.1\n", r"index.csv:4: angle_deg: got 30 after 60, .*sort the rows"),
    (HEADER + "-60,1,0.1\n0,1,0.1\n60,1,0.1\n", r"index.csv:4: angle_deg: got -60 to 60, needed are .* -90 to 90; add"),
    (HEADER + "-180,1,0.1\n0,1,0.1\n180,2,0.1\n", r"index.csv:4: error_arcsec: got 2 at 180 and 1 at -180, .* same"),
    (HEADER + "-180,1,0.1\n0,1,0.1\n180,1,0.2\n", r"index.csv:4: uncertainty_arcsec: got 0.2 at 180 and 0.1 at -180"),
    (
        HEADER + "-180,0.0832747,0.1\n0,1,0.1\n180,0.083275,0.1\n",
        r"got 0.083275 at 180 and 0.0832747 at -180, allowed the same",
    ),
    (HEADER + "-180,1,0.1\n0,1,0.1\n185,1,0.1\n", r"index.csv:4: .*-180 to 185, allowed at most one turn.*each index"),
    (HEADER + "-180,1,0.1\n180,1,0.1\n", r"index.csv:3: .*got one index, -180 and 180, .*list those between"),
]


@pytest.mark.parametrize(("text", "sentence"), FAULTS)
def test_a_mistake_is_named_by_line_and_column(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "index.csv").write_text(text)
    with pytest.raises(DescriptionError, match=sentence):
        read_index_table(tmp_path / "index.csv", LIMITS_DEG)


@pytest.mark.parametrize("angles_deg", [[-90.0, 0.0, 90.0], [0.0, 90.0, 180.0, 270.0], [-180.0, -60.0, 60.0]])
def test_the_limits_or_the_whole_turn_are_enough(tmp_path: Path, angles_deg: list[float]) -> None:
    (tmp_path / "index.csv").write_text(HEADER + "".join(f"{angle},1.0,0.1\n" for angle in angles_deg))
    assert list(read_index_table(tmp_path / "index.csv", LIMITS_DEG).angle_deg) == angles_deg


def test_both_ends_of_a_turn_are_one_index(tmp_path: Path) -> None:
    """So a certificate prints it, and so the message about missing angles asks for it; the last step may be wider."""
    ends = "-180,0.5,0.1\n-60,-0.3,0.1\n60,0.2,0.1\n"
    (tmp_path / "open.csv").write_text(HEADER + ends)
    (tmp_path / "closed.csv").write_text(HEADER + ends + "180,0.5,0.1\n")
    limits_deg = (-180.0, 180.0)
    closed, opened = (read_index_table(tmp_path / name, limits_deg) for name in ("closed.csv", "open.csv"))
    assert closed.model_copy(update={"file": ""}) == opened.model_copy(update={"file": ""})
    (tmp_path / "wide.csv").write_text(HEADER + "-180,1,0.1\n-170,1,0.1\n-160,1,0.1\n180,1,0.1\n")
    assert read_index_table(tmp_path / "wide.csv", limits_deg).angle_deg == (-180.0, -170.0, -160.0)


def test_ends_that_were_computed_may_differ_in_their_last_digits(tmp_path: Path) -> None:
    """Printed with all digits 0.1 + 0.2 and 0.3 are two numbers; both are the error of one index."""
    rows = f"-180,{0.1 + 0.2!r},0.1\n0,1,0.1\n180,0.3,0.1\n"
    (tmp_path / "index.csv").write_text(HEADER + rows)
    assert read_index_table(tmp_path / "index.csv", (-180.0, 180.0)).error_arcsec == (0.1 + 0.2, 1.0)


def test_what_is_asked_for_where_limits_exceed_a_turn_is_a_turn(tmp_path: Path) -> None:
    (tmp_path / "index.csv").write_text(HEADER + "-90,1,0.1\n0,1,0.1\n90,1,0.1\n")
    with pytest.raises(DescriptionError, match=r"-90 to 90, needed are the whole turn .*; add the angles"):
        read_index_table(tmp_path / "index.csv", (-90.0, 180.0))
    with pytest.raises(DescriptionError) as refused:
        read_index_table(tmp_path / "index.csv", (-185.0, 185.0))
    assert "185" not in str(refused.value)
    assert "limits_deg" not in str(refused.value)


def with_table(folder: Path, value: str, text: str = HEADER + "-180,0.5,0.1\n-60,-0.3,0.1\n60,0.2,0.1\n") -> Path:
    (folder / "index.csv").write_text(text)
    rig = EXAMPLE_RIG.read_text().replace("uncertainty_arcsec = 1.0", f"uncertainty_arcsec = 1.0\n{value}", 1)
    (folder / "rig.toml").write_text(rig)
    return folder / "rig.toml"


def test_a_rig_keeps_the_rows_and_so_does_its_journal(tmp_path: Path) -> None:
    rig = read_rig(with_table(tmp_path, 'index_table = "index.csv"'))
    kept = rig.axes["pitch"].index_table
    assert isinstance(kept, IndexTable)
    assert kept.error_arcsec == (0.5, -0.3, 0.2)
    assert rig_from_json(rig.model_dump_json()).axes["pitch"].index_table == kept


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ('index_table = "none.csv"', r"axes.pitch.index_table: .*none.csv: cannot be read"),
        ('index_errors = "rough"', r"axes.pitch.index_errors: got 'rough'"),
        ("index_zero_uncertainty_arcsec = 0.2", r"index_zero_uncertainty_arcsec needs index_zero_deg"),
    ],
)
def test_a_rig_names_what_is_wrong_with_its_index_errors(tmp_path: Path, value: str, sentence: str) -> None:
    with pytest.raises(DescriptionError, match=sentence):
        read_rig(with_table(tmp_path, value))


BY_STANDARD = [("limit", 1.0), ("standard", 4.0), ("expanded", 2.0)]


@pytest.mark.parametrize(("kind", "allowed_arcsec"), BY_STANDARD)
def test_a_list_beyond_what_is_declared_of_the_errors_is_refused(
    tmp_path: Path, kind: str, allowed_arcsec: float
) -> None:
    """1″ as a limit, as a standard uncertainty (4 of them), and expanded with k = 2 (4 of its halves)."""

    def rig_with(error_arcsec: float) -> Path:
        rows = f"{HEADER}-180,0.5,0.1\n-60,{-error_arcsec},0.1\n60,0.2,0.1\n"
        path = with_table(tmp_path, 'index_table = "index.csv"', rows)
        text = path.read_text().replace('kind = "limit"', f'kind = "{kind}"')
        path.write_text(text)
        return path

    assert read_rig(rig_with(allowed_arcsec + 0.09)).axes["pitch"].index_table is not None
    place = r"rig.toml:\d+: axes.pitch.index_table: index.csv lists an error"
    sentence = rf"{place} of -{allowed_arcsec + 0.2:g}″ at -60°, .*uncertainty_arcsec = 1 .*correct the list"
    with pytest.raises(DescriptionError, match=sentence):
        read_rig(rig_with(allowed_arcsec + 0.2))
