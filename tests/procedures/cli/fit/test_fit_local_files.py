"""``calrig fit`` of a spreadsheet's file: other separators and decimal commas change no digit of what is solved."""

from pathlib import Path

import pytest
from command import call
from cr_outputs import (
    TABLE_3_STING,
    table_3_profile,
    write_package,
    write_rows,
    write_second_step,
)
from example_files import EXAMPLE_RIG
from package_outputs import write_observations

AXES = ("--axis", "x=x_v", "--axis", "y=y_v", "--axis", "z=z_v")
LOCAL = ("--separator", "semicolon", "--decimal", "comma")


def with_sting(folder: Path) -> tuple[object, ...]:
    """CR's second step: a model package beside a sting package that is solved."""
    sting = write_package(folder / "sting.csv", "sting", TABLE_3_STING, table_3_profile())
    model = ("--model", "pitch-yaw-roll", "--package")
    set_ = folder / "sting.json"
    solve_sting = ("fit", sting, *model, "sting", *AXES, "--set", set_, "--sensor", "ST", "--gravity-mps2", "9.8")
    return solve_sting, write_second_step(folder / "model.csv"), (*model, "model", "--sting", set_, *AXES)


def with_levels(folder: Path) -> tuple[object, ...]:
    rows = [[n, p, g, 0.3 * g + 0.01 + 1e-5 * n] for n in (1, 2) for p, g in enumerate((1.0, 0.5, -1.0))]
    path = write_rows(folder / "levels.csv", ["reference_g", "x_v"], rows)
    return None, path, ("--model", "linear", "--axis", "x=x_v")


def with_mount(folder: Path) -> tuple[object, ...]:
    path = write_observations(folder / "rows.csv", range(-60, 61, 30), range(-180, 180, 60), 2, noise_v=6e-6)
    header, *rows = path.read_text("utf-8").splitlines()
    path.write_text("\n".join([f"{header},mount", *(f"{row},upright" for row in rows)]) + "\n", encoding="utf-8")
    axes = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
    return None, path, ("--joint", "--rig", EXAMPLE_RIG, "--mount", "mount", *axes)


def with_angles(folder: Path) -> tuple[object, ...]:
    path = write_observations(folder / "rows.csv", range(-60, 61, 30), range(-180, 180, 60), 2, noise_v=6e-6)
    return None, path, ("--axis", "x=sx_v")


@pytest.mark.parametrize("way", [with_angles, with_levels, with_mount, with_sting])
def test_local_separators_change_no_digit(way, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before, path, words = way(tmp_path)
    if before is not None:
        assert call(capsys, *before).status == 0
    plain = call(capsys, "fit", path, *words, "--json")
    assert plain.status == 0, plain.err
    path.write_text(path.read_text("utf-8").replace(",", ";").replace(".", ","), encoding="utf-8")
    refused = call(capsys, "fit", path, *words, "--json")
    assert (refused.status, refused.out) == (2, "")
    assert "--separator semicolon --decimal comma" in refused.err
    assert call(capsys, "fit", path, *words, *LOCAL, "--json").document == plain.document


def test_commas_for_both_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done = call(capsys, "fit", tmp_path / "rows.csv", "--axis", "x=sx_v", "--decimal", "comma")
    assert done.status == 2
    assert "--decimal comma: columns are separated by commas too; nothing was solved" in done.err
