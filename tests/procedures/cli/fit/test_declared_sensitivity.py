"""Laws of ``calrig fit`` and ``calrig.fit`` for outputs in another unit than volts, or far from the data sheet's."""

import csv
from pathlib import Path

import calrig
import pytest
from command import call
from package_outputs import write_observations
from planning_files import rig_file

from ams.errors import ObservationsError
from ams.exports.formats import load_set
from ams.sets.stated_findings import significant_findings
from procedures.run.judgement.mount_check import GAIN_RANGE

AXES = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v")
OF_RIG = {"x": (0.005, 2.5, 0.5, 35.0), "y": (-0.003, 2.48, 0.3, -110.0), "z": (0.008, 2.52, 0.4, 160.0)}
"""Of one polarity, as the example rig declares 2.5 V/g on a range of 10 V."""


def rows_of(folder: Path, factor: float, *, axes: str = "xyz") -> Path:
    truth = {
        axis: (offset * factor, sensitivity * factor, coning, azimuth) if axis in axes else entry
        for axis, entry in OF_RIG.items()
        for offset, sensitivity, coning, azimuth in (entry,)
    }
    noise_v = 1e-5 * factor
    return write_observations(folder / "obs.csv", range(-90, 91, 30), range(-180, 180, 60), 3, noise_v, truth=truth)


def by_rig(folder: Path) -> tuple[object, ...]:
    rig_file(folder)
    return ("--rig", folder / "rig.toml", "--sensor", "SN1", "--set", folder / "set.json")


def test_what_the_meter_of_the_rig_cannot_read_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = rows_of(tmp_path, 1000.0)
    done = call(capsys, "fit", path, *AXES, *by_rig(tmp_path))
    assert done.status == 2
    assert f"{path}: column sx_v: " in done.err
    assert "allowed -12 to 12 V (dmm.x of the rig file has a range of 10 V" in done.err
    assert "nothing was solved; the numbers look like millivolts: divide the column by 1000" in done.err
    assert not (tmp_path / "set.json").exists()


@pytest.mark.parametrize("fit", ["command", "joint", "python"])
def test_every_fit_of_a_file_refuses_it(fit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = rows_of(tmp_path, 1000.0)
    options = by_rig(tmp_path)
    if fit == "python":
        with pytest.raises(ObservationsError, match=r"sx_v: .* look like millivolts"):
            calrig.fit(path, {axis: f"s{axis}_v" for axis in "xyz"}, rig=options[1], sensor=str(options[3]))
        return
    done = call(capsys, "fit", path, *AXES, *options, *(("--joint",) if fit == "joint" else ()))
    assert done.status == 2
    assert "look like millivolts" in done.err


def test_what_no_sensor_gives_is_refused_without_a_rig_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done = call(capsys, "fit", rows_of(tmp_path, 1000.0), *AXES)
    assert done.status == 2
    assert "allowed -50 to 50 V (servo accelerometers end at ±15 V)" in done.err


def finding_of(document: dict, axis: str) -> dict | None:
    found = [entry for entry in document["axes"][axis]["findings"] if entry["kind"] == "axis-contradicted"]
    assert len(found) <= 1
    return found[0] if found else None


@pytest.mark.parametrize(
    ("factor", "likely"), [(1e-3, "look like kilovolts"), (0.2, "load resistor"), (4.0, "gain of an amplifier")]
)
def test_a_sensitivity_far_from_the_declared_one_is_not_usable_until_somebody_accepts_it_by_name(
    factor: float, likely: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = rows_of(tmp_path, factor, axes="y")
    document = call(capsys, "fit", path, *AXES, *by_rig(tmp_path), "--json").document
    finding = finding_of(document, "y")
    assert finding is not None
    assert document["verdict"] == "not usable"
    assert finding["sensitivity_v_per_g"] == pytest.approx(2.48 * factor, rel=1e-3)
    assert finding["declared_sensitivity_v_per_g"] == 2.5
    assert likely in finding["text"]
    assert "allowed 0.5 to 2 times" in finding["text"]
    assert finding_of(document, "x") is None
    written = load_set(tmp_path / "set.json")
    assert "y.axis-contradicted" in [entry.name for entry in significant_findings(written)]
    assert written.document["verdict"] == "not usable"
    assert "y: axis-contradicted" in call(capsys, "fit", path, *AXES, *by_rig(tmp_path)).out


@pytest.mark.parametrize("factor", [1.05 * GAIN_RANGE[0], 0.95 * GAIN_RANGE[1]])
def test_a_sensitivity_that_a_run_begins_with_is_no_finding(
    factor: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = call(capsys, "fit", rows_of(tmp_path, factor), *AXES, *by_rig(tmp_path), "--json").document
    assert [finding_of(document, axis) for axis in "xyz"] == [None, None, None]


@pytest.mark.parametrize(("level_v", "of_y"), [(0.0123, 0.0), (0.0, 0.0), (-9.87654321, 0.0), (0.0123, 0.02)])
def test_a_channel_that_is_dead_is_told_not_to_respond_and_not_to_lie_along_another_axis(
    level_v: float, of_y: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = rows_of(tmp_path, 1.0)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row["sz_v"] = repr(level_v + of_y * float(row["sy_v"]))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    options = by_rig(tmp_path)[:4] if of_y else ()
    document = call(capsys, "fit", path, *AXES, *options, "--json").document
    kinds = [entry["kind"] for entry in document["axes"]["z"]["findings"] if entry["significant"]]
    assert "axis-contradicted" not in kinds
    assert kinds.count("axis-undetermined") == 1
    (text,) = (e["text"] for e in document["axes"]["z"]["findings"] if e["kind"] == "axis-undetermined")
    assert "does not respond" in text or "not told from zero" in text
    assert ("reads as" in text) is False
    assert document["verdict"] == "not usable"
