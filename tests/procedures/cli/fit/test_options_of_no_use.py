"""An option that would be in no result of ``calrig fit`` is refused by its name, and nothing is solved."""

from pathlib import Path

import calrig
import pytest
from command import call
from example_files import EXAMPLE_RIG
from package_outputs import write_observations

from procedures.errors import RequestError

REQUESTS = [
    (("--sensor", "SN1"), "--sensor: belongs to --set or --rig, which are missing; nothing was solved"),
    (("--gravity-mps2", "9.8"), "--gravity-mps2: belongs to --set, which is missing; nothing was solved"),
    (("--gravity-mps2", "9.8", "--rig", EXAMPLE_RIG), "--gravity-mps2: belongs to --set, which is missing"),
    (
        ("--reference-temperature-degc", "30"),
        "--reference-temperature-degc: belongs to --temperature apply or estimate, not to --temperature none",
    ),
    (
        ("--rate-uncertainty-ppm", "100", "--rig", EXAMPLE_RIG),
        "--rate-uncertainty-ppm: belongs to --model gyro, not to --model pitch-roll",
    ),
]


@pytest.mark.parametrize(("options", "sentence"), REQUESTS, ids=[" ".join(map(str, r[0][::2])) for r in REQUESTS])
def test_what_would_be_in_no_result_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[object, ...], sentence: str
) -> None:
    file = write_observations(tmp_path / "obs.csv", range(-60, 61, 30), range(-180, 180, 60), 2)
    asked = call(capsys, "fit", file, "--axis", "x=sx_v", *options)
    assert (asked.status, asked.out) == (2, "")
    assert sentence in asked.err


def test_python_refuses_a_reference_temperature_of_no_coefficient_too(tmp_path: Path) -> None:
    file = write_observations(tmp_path / "obs.csv", range(-60, 61, 30), range(-180, 180, 60), 2)
    with pytest.raises(RequestError, match="fit: reference_temperature_degc: belongs to fit: temperature apply or"):
        calrig.fit(file, {"x": "sx_v"}, reference_temperature_degc=30.0)
    with pytest.raises(RequestError, match="fit: rate_uncertainty_ppm: belongs to fit: model gyro"):
        calrig.fit(file, {"x": "sx_v"}, rig=EXAMPLE_RIG, rate_uncertainty_ppm=100.0)
