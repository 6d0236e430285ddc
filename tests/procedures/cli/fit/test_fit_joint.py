"""Laws of ``calrig fit --joint``: a table's error is found by two mounts, and named as confounded with one."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call
from cr_outputs import write_rows
from package_outputs import TRUTH as OF_EITHER_POLARITY
from package_outputs import pitch_matrix, roll_matrix

import ams
from ams.exports.formats import FORMATS, export_set

ARCSEC = np.pi / 180 / 3600
AXES = ("--axis", "x=x_v", "--axis", "y=y_v", "--axis", "z=z_v")
RIG = Path(__file__).parents[4] / "examples" / "rig.toml"
TRUTH = {axis: (offset, abs(s), *angles) for axis, (offset, s, *angles) in OF_EITHER_POLARITY.items()}
"""Of the polarity that the rig file declares."""
HALF_TURN = np.diag([-1.0, -1.0, 1.0])


def direction(axis: str) -> np.ndarray:
    """k = S·u, from the definition of the angles."""
    _, s, coning, azimuth = TRUTH[axis]
    c, w, a = np.cos(np.radians(coning)), np.sin(np.radians(coning)), np.radians(azimuth)
    along = {"x": (c, w * np.cos(a), w * np.sin(a)), "y": (w * np.sin(a), c, w * np.cos(a))}
    return s * np.array(along.get(axis, (w * np.cos(a), w * np.sin(a), c)))


def write_mounts(
    path: Path,
    mounts: tuple[str, ...],
    roll_zero_arcsec: float,
    noise_v: float = 5e-6,
    extra_v: Callable[[int, int, np.ndarray], float] = lambda replication, point, force: 0.0,
    seed: int = 6,
) -> Path:
    """Two replications a mount on a table whose roll zero is wrong, by explicit rotations; z reads ``extra_v`` more."""
    chance = np.random.default_rng(seed)
    rows: list[list[object]] = []
    for number, mount in enumerate(mounts):
        turn = HALF_TURN if mount == "reversed" else np.eye(3)
        for replication in (2 * number + 1, 2 * number + 2):
            for point, (p, r) in enumerate([(p, r) for p in range(-60, 61, 20) for r in range(-180, 180, 30)], 1):
                true_roll = np.radians(r) + roll_zero_arcsec * ARCSEC
                force = turn @ roll_matrix(true_roll) @ pitch_matrix(np.radians(p)) @ np.array([0.0, 0.0, -1.0])
                volts = [TRUTH[a][0] + direction(a) @ force + noise_v * chance.normal() for a in "xyz"]
                volts[2] += extra_v(replication, point, force)
                rows.append([replication, point, p, r, mount, *map(float, volts)])
    return write_rows(path, ["pitch_deg", "roll_deg", "mount", "x_v", "y_v", "z_v"], rows)


def test_a_reversed_mount_finds_the_roll_zero(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_mounts(tmp_path / "two.csv", ("upright", "reversed"), 10.0)
    priors = ("--prior", "roll-zero=30", "--prior", "seat=0.5")
    document = call(capsys, "fit", file, *AXES, "--joint", "--rig", RIG, *priors, "--mount", "mount", "--json").document
    found = document["nuisances"]["roll zero"]
    assert found["is_observed"]
    assert abs(found["estimate_arcsec"] - 10.0) < 4 * found["standard_deviation_arcsec"] < 4.0
    y = document["axes"]["y"]["parameters"]["sensitivity_v_per_g"]
    assert abs(y["value"] - 2.48) < 5 * y["standard_uncertainty"]


def test_one_mount_says_that_the_roll_zero_stays_confounded(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_mounts(tmp_path / "one.csv", ("upright",), 10.0)
    said = ("fit", file, *AXES, "--joint", "--rig", RIG, "--prior", "roll-zero=30")
    document = call(capsys, *said, "--json").document
    assert not document["nuisances"]["roll zero"]["is_observed"]
    assert any("roll zero: not observable" in sentence for sentence in document["confounded"])
    assert document["axes"]["y"]["parameters"]["azimuth_deg"]["standard_uncertainty"] > 0.5  # 30″ of 0.3° of coning
    text = call(capsys, *said).out
    assert "confounded: roll zero: not observable" in text
    assert "not told by these rows" in text


TWO = ("--joint", "--rig", RIG, "--prior", "roll-zero=30", "--prior", "seat=0.5", "--mount", "mount")


def significant(document: dict[str, Any]) -> dict[str, list[str]]:
    return {
        axis: [finding["text"] for finding in section["findings"] if finding["significant"]]
        for axis, section in document["axes"].items()
    }


def test_a_sound_joint_fit_is_tested_and_nothing_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also not the roll zero of 10″, which the fit has found. (By chance any fit of z at seed 6 finds K_io.)"""
    file = write_mounts(tmp_path / "two.csv", ("upright", "reversed"), 10.0, seed=7)
    document = call(capsys, "fit", file, *AXES, *TWO, "--json").document
    assert significant(document) == {"x": [], "y": [], "z": []}
    text = [entry["text"] for entry in document["axes"]["z"]["findings"] if not entry["kind"].endswith("-undeclared")]
    assert {text.partition(":")[0] for text in text} == {"mounting 1", "mounting 2"}
    assert document["verdict"] == "usable", "what stays confounded has to be read"


def test_a_wrong_dwell_and_a_cubic_sensor_are_named_in_the_joint_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mounts = ("upright", "reversed")
    jump = write_mounts(tmp_path / "jump.csv", mounts, 10.0, extra_v=lambda r, p, f: 0.02 if (r, p) == (3, 40) else 0.0)
    found = significant(call(capsys, "fit", jump, *AXES, *TWO, "--json").document)
    assert (found["x"], found["y"]) == ([], [])
    assert len(found["z"]) == 1
    assert found["z"][0].startswith("mounting 2: ")
    assert "replication 3" in found["z"][0]
    bent = write_mounts(tmp_path / "bent.csv", mounts, 10.0, extra_v=lambda r, p, f: 2e-4 * float(f[2]) ** 3)
    stored = tmp_path / "bent.json"
    document = call(capsys, "fit", bent, *AXES, *TWO, "--json", "--set", stored, "--sensor", "SN1047").document
    kinds = [entry["kind"] for entry in document["axes"]["z"]["findings"] if entry["significant"]]
    assert kinds.count("cubic") == len(mounts), "seen in both"
    assert set(significant(document)["z"]) <= set(document["axes"]["z"]["warnings"])
    assert json.loads(stored.read_text())["axes"]["z"]["findings"] == document["axes"]["z"]["findings"]


REQUESTS = [
    (("--joint",), "needs --rig RIG"),
    (("--prior", "droop=1"), "belong to --joint"),
    (("--joint", "--rig", str(RIG), "--prior", "wobble=1"), "pitch-zero, roll-zero"),
    (("--joint", "--rig", str(RIG), "--extended", "test"), "goes with --model pitch-roll"),
    (("--joint", "--rig", str(RIG), "--mount", "side"), "column 'side' missing"),
    (("--joint", "--rig", str(RIG), "--mount", "pitch_deg"), "line 2: column pitch_deg: got '-60', allowed upright"),
]


@pytest.mark.parametrize(("options", "sentence"), REQUESTS, ids=[sentence for _, sentence in REQUESTS])
def test_a_wrong_request_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], sentence: str
) -> None:
    outcome = call(capsys, "fit", write_mounts(tmp_path / "one.csv", ("upright",), 0.0), *AXES, *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert sentence in outcome.err


def test_an_unknown_roll_zero_ties_y_and_z_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It turns both sensitive axes about x by the same angle: y's share along z and z's along y are one unknown."""
    file = write_mounts(tmp_path / "one.csv", ("upright",), 0.0)
    document = call(capsys, "fit", file, *AXES, "--joint", "--rig", RIG, "--prior", "roll-zero=30", "--json").document
    package = document["package_covariance"]
    covariance = np.array(package["covariance"])
    entry, other = (package["order"].index(entry) for entry in (["y", "k_z_v_per_g"], ["z", "k_y_v_per_g"]))
    correlation = covariance[entry, other] / np.sqrt(covariance[entry, entry] * covariance[other, other])
    assert abs(correlation) > 0.99
    assert np.sqrt(covariance[entry, entry]) == pytest.approx(2.48 * 30.0 * ARCSEC, rel=0.02)


def test_a_joint_fit_makes_a_set_that_carries_what_the_table_left(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its angles come back, its numbers are the document's, and every format takes it."""
    file = write_mounts(tmp_path / "two.csv", ("upright", "reversed"), 10.0)
    where = ("--joint", "--rig", RIG, "--prior", "roll-zero=30", "--prior", "seat=0.5", "--mount", "mount")
    path = tmp_path / "joint.json"
    document = call(capsys, "fit", file, *AXES, *where, "--set", path, "--sensor", "SN1047", "--json").document
    assert call(capsys, "verify", path).status == 0
    stored = json.loads(path.read_text())
    for axis, solved in document["axes"].items():
        section = stored["axes"][axis]
        for name, parameter in solved["parameters"].items():
            assert section["parameters"][name]["value"] == parameter["value"]
            assert section["parameters"][name]["standard_uncertainty"] == parameter["standard_uncertainty"]
    together = sum(np.array(part["covariance"]) for part in stored["package"]["components"].values())
    np.testing.assert_allclose(together, document["package_covariance"]["covariance"], rtol=1e-12, atol=1e-25)
    force = roll_matrix(np.radians(40.0)) @ pitch_matrix(np.radians(-25.0)) @ np.array([0.0, 0.0, -1.0])
    found = ams.load(path).attitude([TRUTH[axis][0] + direction(axis) @ force for axis in "xyz"])
    assert abs(found.pitch_deg + 25.0) < 4 * found.pitch_sd_deg < 0.01
    assert abs(found.roll_deg - 40.0) < 4 * found.roll_sd_deg < 0.03
    for form in FORMATS.values():
        written = tmp_path / form.file_name("SN1047")
        export_set(ams.load_set(path), form.name, written)
        assert ams.load_set(written).document == stored


@pytest.mark.parametrize(("true_arcsec", "contradicts"), [(6.0, False), (60.0, True)])
def test_an_error_of_the_table_far_beyond_its_prior_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], true_arcsec: float, contradicts: bool
) -> None:
    """Two mounts tell the roll zero; 5″ are declared of it, 60″ are twelve times that."""
    file = write_mounts(tmp_path / "two.csv", ("upright", "reversed"), true_arcsec)
    text = ("--joint", "--rig", RIG, "--prior", "roll-zero=5", "--prior", "seat=0.5", "--mount", "mount", "--json")
    document = call(capsys, "fit", file, *AXES, *text).document
    found = [text for axis in significant(document).values() for text in axis if text.startswith("roll zero: ")]
    assert bool(found) == contradicts, found
    assert all("the rows contradict the prior" in text and "--prior" in text for text in found)
    assert document["verdict"] == ("not usable" if contradicts else "usable")


def rig_with(folder: Path, meter_limit_v: float, of_sensor: str = "") -> Path:
    """Return the example's rig file with a meter of a limit on its readings, and a line for its sensor."""
    text = RIG.read_text(encoding="utf-8").replace("nplc = 10\n", 'nplc = 10\nstandard = "dmm"\n')
    text = text.replace('model = "three-axis package"\n', f'model = "three-axis package"\n{of_sensor}')
    known = 'serial = "D7"\ncertificate = "26-2"\ndue = 2099-01-01\nkind = "limit"\n'
    meter = f"\n[standards.dmm]\n{known}uncertainty_v = {meter_limit_v}\n"
    path = folder / f"rig-{meter_limit_v}.toml"
    path.write_text(text.replace("\n[twin]\n", f"{meter}\n[twin]\n", 1), encoding="utf-8")
    return path


@pytest.mark.parametrize("mounts", [("upright",), ("upright", "reversed")], ids=["one", "two"])
def test_what_the_meter_is_wrong_by_is_in_a_joint_fit_as_in_any_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mounts: tuple[str, ...]
) -> None:
    """A zero of ±L moves every offset by as much (GUM 4.3.7: u = L/√3), whatever else is solved beside it."""
    file = write_mounts(tmp_path / "rows.csv", mounts, 0.0)
    limits_v = (2e-6, 2e-3)
    for options in ((), ("--joint", *(("--prior", "seat=0.5", "--mount", "mount") if len(mounts) > 1 else ()))):
        if not options and len(mounts) > 1:
            continue
        found = []
        for limit_v in limits_v:
            rig = rig_with(tmp_path, limit_v)
            document = call(capsys, "fit", file, *AXES, "--rig", rig, "--sensor", "SN1047", *options, "--json").document
            found.append(document["axes"])
        for axis in "xyz":
            u_v = [section[axis]["parameters"]["offset_v"]["standard_uncertainty"] for section in found]
            added = (limits_v[1] ** 2 - limits_v[0] ** 2) / 3.0
            assert u_v[1] ** 2 - u_v[0] ** 2 == pytest.approx(added, rel=1e-6)
            lines = {line["source"]: line for line in found[1][axis]["budget"]["lines"]}
            zero = lines["multimeter zero"]["standard_uncertainty"]["offset_v"]
            assert zero == pytest.approx(limits_v[1] / 3.0**0.5, rel=1e-3)


def test_what_a_sensor_may_shift_by_is_in_a_joint_fit_of_two_mounts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The shift until the next calibration is a rectangle of its limit: u = L/√3 at the least."""
    file, limit_v = write_mounts(tmp_path / "two.csv", ("upright", "reversed"), 10.0), 1e-3
    rig = rig_with(tmp_path, 2e-6, f"largest_offset_shift_v = {limit_v}\n")
    two = ("--joint", "--rig", rig, "--prior", "roll-zero=30", "--prior", "seat=0.5", "--mount", "mount")
    axes = call(capsys, "fit", file, *AXES, *two, "--sensor", "SN1047", "--json").document["axes"]
    for section in axes.values():
        u_v = section["parameters"]["offset_v"]["standard_uncertainty"]
        assert limit_v / 3.0**0.5 < u_v < limit_v * 2.0**0.5, "shift since, and within: each at most its limit"


@pytest.mark.parametrize("mounts", [("upright",), ("upright", "reversed")], ids=["one", "two"])
def test_use_at_other_temperatures_is_in_a_joint_fit_or_said_as_in_any_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mounts: tuple[str, ...]
) -> None:
    """GUM 4.3.7: a limit over the 12 °C to the farther end of use is a rectangle; it was neither counted nor said."""
    file, limit_v_per_degc, range_of_use = write_mounts(tmp_path / "rows.csv", mounts, 0.0), 3e-5, "10 to 30 °C"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    at_22 = [f"{head},temperature_degc", *(f"{row},22.0" for row in rows)]
    two = ("--prior", "seat=0.5", "--mount", "mount") if len(mounts) > 1 else ()

    def fitted(limits: str, lines: list[str]) -> tuple[dict[str, float], str]:
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        rig = rig_with(tmp_path, 2e-6, f"use_temperature_degc = [10.0, 30.0]\n{limits}")
        document = call(
            capsys, "fit", file, *AXES, "--joint", "--rig", rig, "--sensor", "SN1047", *two, "--json"
        ).document
        offsets = {axis: found["parameters"]["offset_v"] for axis, found in document["axes"].items()}
        said = [text for text in document["warnings"] if f"is to be used at {range_of_use}" in text]
        return {axis: offset["standard_uncertainty"] for axis, offset in offsets.items()}, " ".join(said)

    limit = f"largest_offset_tc_v_per_degc = {limit_v_per_degc}\n"
    (unknown, said), (limited, silent), (_, unread) = (
        fitted("", at_22), fitted(limit, at_22), fitted(limit, [head, *rows])
    )  # fmt: skip
    assert ("without a model of temperature" in said, silent) == (True, "")
    assert "as declared, and no temperature was recorded" in unread
    for axis, u_v in limited.items():
        added = (limit_v_per_degc * 12.0) ** 2 / 3.0
        assert u_v**2 - unknown[axis] ** 2 == pytest.approx(added, rel=1e-5)


def test_a_meter_that_nobody_declared_is_told_by_a_joint_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_mounts(tmp_path / "one.csv", ("upright",), 0.0)
    document = call(capsys, "fit", file, *AXES, "--joint", "--rig", RIG, "--sensor", "SN1047", "--json").document
    for section in document["axes"].values():
        assert "meter-undeclared" in [finding["kind"] for finding in section["findings"]]
    assert any("zero and its gain" in remark for remark in document["remarks"])


def test_a_dead_axis_has_nulls_in_the_document_of_a_joint_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_mounts(tmp_path / "one.csv", ("upright",), 0.0)
    head, *rows = (line.split(",") for line in path.read_text(encoding="utf-8").splitlines())
    chance, column = np.random.default_rng(1), head.index("y_v")
    for row in rows:
        row[column] = repr(0.123 + 2e-5 * float(chance.standard_normal()))
    path.write_text("\n".join(",".join(row) for row in (head, *rows)) + "\n", encoding="utf-8")
    document = call(capsys, "fit", path, *AXES, "--joint", "--rig", RIG, "--json").document
    assert document["verdict"] == "not usable"
    unknown = [name for name, entry in document["axes"]["y"]["parameters"].items() if entry["value"] is None]
    assert unknown, "coning and azimuth of nothing"
    assert all(document["axes"]["y"]["parameters"][name]["standard_uncertainty"] is None for name in unknown)


def test_a_joint_fit_says_of_rows_and_rig_what_the_plain_fit_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Angles in radians, on a table that the rig file states to be exact: the joint fit was silent of both."""
    file = write_mounts(tmp_path / "rows.csv", ("upright",), 0.0)
    head, *rows = (line.split(",") for line in file.read_text(encoding="utf-8").splitlines())
    angles = [head.index("pitch_deg"), head.index("roll_deg")]
    for row in rows:
        for column in angles:
            row[column] = repr(float(np.radians(float(row[column]))))
    file.write_text("\n".join(",".join(row) for row in (head, *rows)) + "\n", encoding="utf-8")
    rig = rig_with(tmp_path, 2e-6, "")
    exact = "".join(
        line for line in rig.read_text(encoding="utf-8").splitlines(keepends=True) if "uncertainty_arcsec" not in line
    )
    rig.write_text(exact, encoding="utf-8")
    said = ("fit", file, *AXES, "--rig", rig, "--sensor", "SN1047")
    plain, joint = (call(capsys, *said, *option, "--json").document for option in ((), ("--joint",)))
    for axis, section in plain["axes"].items():
        of_rows = {text for text in section["warnings"] if "radians?" in text or "states 0 of them" in text}
        assert len(of_rows) == 2
        assert of_rows <= set(joint["axes"][axis]["warnings"])
