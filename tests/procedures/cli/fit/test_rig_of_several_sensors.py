"""A fit by a rig file of several sensors: the one named, or whose name the columns begin with, else a warning."""

from pathlib import Path

import calrig
import pytest
from command import call
from package_outputs import write_observations
from planning_files import rig_file

TRUTH = {"x": (0.005, 0.6, 0.5, 35.0), "y": (-0.003, 2.48, 0.3, -110.0), "z": (0.008, 2.52, 0.4, 160.0)}
"""An x of a quarter of the 2.5 V/g that the rig file declares."""


def rig_of_two(folder: Path) -> Path:
    """A rig of SN1 and SN2, on channels of their own."""
    channels = ", ".join(f"{name} = {{ scanner = {5 + index}, range_v = 10.0 }}" for index, name in enumerate("abc"))
    second = (
        '[sensors.SN2]\nmodel = "three-axis package"\nchannels = { x = "dmm.a", y = "dmm.b", z = "dmm.c" }\n'
        "nominal_sensitivity_v_per_g = 2.5\n"
    )
    rig_file(folder, ("channels = { x = { scanner", f"channels = {{ {channels}, x = {{ scanner"), more=second)
    return folder / "rig.toml"


def file_of(folder: Path, column: str = "s{}_v") -> tuple[Path, list[str], dict[str, str]]:
    path = write_observations(folder / "obs.csv", range(-90, 91, 30), range(-180, 180, 60), 3, 1e-5, truth=TRUTH)
    columns = {axis: column.format(axis) for axis in "xyz"}
    text = path.read_text(encoding="utf-8")
    for axis, name in columns.items():
        text = text.replace(f"s{axis}_v", name, 1)
    path.write_text(text, encoding="utf-8")
    return path, [word for axis, name in columns.items() for word in ("--axis", f"{axis}={name}")], columns


def of_sensors(warnings: list[str]) -> list[str]:
    return [text for text in warnings if "nothing says which was measured" in text]


@pytest.mark.parametrize("joint", [(), ("--joint",)])
def test_where_nothing_names_one_it_is_a_warning_and_the_way_out_works(
    joint: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig, (path, words, columns) = rig_of_two(tmp_path), file_of(tmp_path)
    document = call(capsys, "fit", path, *words, "--rig", rig, *joint, "--json").document
    (warning,) = of_sensors(document["warnings"] if joint else document["axes"]["x"]["warnings"])
    assert "has 2 sensors (SN1, SN2)" in warning
    assert "--sensor NAME" in warning
    assert document["verdict"] == "usable"
    named = call(capsys, "fit", path, *words, "--rig", rig, "--sensor", "SN2", *joint, "--json").document
    assert not of_sensors([*named.get("warnings", []), *named["axes"]["x"]["warnings"]])
    if not joint:
        assert named["verdict"] == "not usable"
        assert len(of_sensors(list(calrig.fit(path, columns, rig=rig).warnings))) == 1


def test_columns_that_begin_with_the_name_of_one_name_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig, (path, words, columns) = rig_of_two(tmp_path), file_of(tmp_path, "SN2_{}_v")
    document = call(capsys, "fit", path, *words, "--rig", rig, "--json").document
    kinds = [finding["kind"] for finding in document["axes"]["x"]["findings"] if finding["significant"]]
    assert "axis-contradicted" in kinds
    assert not of_sensors(document["axes"]["x"]["warnings"])
    assert calrig.fit(path, columns, rig=rig).document["verdict"] == "not usable"


def test_a_longer_name_is_another_sensor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig, (path, words, _) = rig_of_two(tmp_path), file_of(tmp_path, "SN20_{}_v")
    document = call(capsys, "fit", path, *words, "--rig", rig, "--json").document
    assert len(of_sensors(document["axes"]["x"]["warnings"])) == 1
