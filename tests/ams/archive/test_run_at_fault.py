"""As found falls where the run falls, and stands where only the sensor does; list, store and page have the same."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from archived_runs import TURNED, a_run, a_sensor
from changed_sets import changed

from ams.archive.run_at_fault import run_at_fault
from ams.archive.runs import MeasuredSensor, adjustment_of, publish_run
from ams.archive.sets import list_sets
from ams.sets.coefficients import from_document

NOW = datetime(2026, 6, 1, tzinfo=UTC)
OF_THE_RUN = [
    ("table-rotation", "slip of the table in mid-run"),
    ("lack-of-fit", "table's declared limit"),
    ("lack-of-fit", "squareness of the table's axes"),
    ("meter-gain", "slip of the table in mid-run"),
    ("meter-offset", "step of the output in mid-run"),
    ("temperature-lag", "temperature lag"),
    ("drift", "settling at the start of every replication"),
    ("wrong-dwell", "wrong dwell"),
    ("field-contradicted", "declared field"),
    ("axis-contradicted", "sensitivity far from the declared one"),
]
OF_THE_SENSOR = [
    ("sensor-change", "step of the output in mid-run"),
    ("lack-of-fit", "lack of fit"),
    ("cubic", "cubic"),
    ("temperature-curvature", "temperature curvature"),
    ("time-confounded", "drift in the parameters"),
    ("autocorrelation", "memory of about 3 dwells"),
]


def found(measured: MeasuredSensor, kind: str, test: str, *, is_exceeded: bool = True) -> MeasuredSensor:
    """What a run measured with a finding of its x axis in the set."""

    def change(document: dict) -> None:
        finding = {"kind": kind, "text": f"{test}: found", "significant": True, "p_value": 1e-9, "test": test}
        finding |= {"stated_uncertainties": "exceeded"} if is_exceeded else {}
        document["axes"]["x"].setdefault("findings", []).append(finding)
        document["verdict"] = "not usable" if is_exceeded else "usable"

    return replace(measured, coefficients=from_document(changed(measured.coefficients, change), f"with {test}"))


def published(tmp_path: Path, second: MeasuredSensor) -> tuple[str, str]:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish_run(url, a_run(0), [a_sensor(0)], NOW)
    publish_run(url, a_run(10), [second], NOW)
    return url, second.coefficients.sha256


@pytest.mark.parametrize(("kind", "test"), OF_THE_RUN)
def test_by_a_finding_against_the_run_neither_is_judged(tmp_path: Path, kind: str, test: str) -> None:
    url, sha256 = published(tmp_path, found(a_sensor(10, gain=1.01), kind, test))
    adjustment = adjustment_of(url, sha256)
    assert adjustment is not None
    assert adjustment.as_found is None
    assert adjustment.no_as_found == f"not judged, this run does not tell: {test}: found"
    assert adjustment.not_judged == "the calibration is not usable"
    (listed,) = [entry for entry in list_sets(url) if entry.sha256 == sha256]
    assert (listed.as_found, listed.as_left, listed.quarantine) == (None, None, None)


@pytest.mark.parametrize(("kind", "test"), OF_THE_SENSOR)
def test_by_a_finding_about_the_sensor_as_found_stands(tmp_path: Path, kind: str, test: str) -> None:
    url, sha256 = published(tmp_path, found(a_sensor(10, gain=1.01), kind, test))
    adjustment = adjustment_of(url, sha256)
    assert adjustment is not None
    assert adjustment.as_found is not None
    assert (adjustment.as_found.verdict, adjustment.as_left.verdict) == ("fail", None)


@pytest.mark.parametrize(("kind", "test"), OF_THE_RUN)
def test_what_the_stated_uncertainties_hold_takes_neither(kind: str, test: str) -> None:
    assert run_at_fault(found(a_sensor(10), kind, test, is_exceeded=False).coefficients) is None


def test_a_finding_that_set_and_run_both_have_is_said_once() -> None:
    measured = found(a_sensor(10), "table-rotation", "slip of the table in mid-run")
    assert (
        run_at_fault(measured.coefficients, [TURNED, TURNED]) == f"{TURNED.text}; slip of the table in mid-run: found"
    )


@pytest.mark.parametrize("factor", [10.0, 0.1, 3.0])
def test_of_outputs_read_in_another_unit_than_declared_as_found_is_not_judged(tmp_path: Path, factor: float) -> None:
    url, sha256 = published(tmp_path, a_sensor(10, read_times=factor))
    adjustment = adjustment_of(url, sha256)
    assert adjustment is not None
    assert adjustment.as_found is None
    assert adjustment.no_as_found is not None
    assert adjustment.no_as_found.startswith("not judged, this run does not tell: the sensitivity is ")
    (listed,) = [entry for entry in list_sets(url) if entry.sha256 == sha256]
    assert listed.as_found is None


def test_of_outputs_read_as_declared_as_found_is_judged(tmp_path: Path) -> None:
    adjustment = adjustment_of(*published(tmp_path, a_sensor(10, read_times=1.0)))
    assert adjustment is not None
    assert adjustment.as_found is not None
    assert adjustment.as_found.verdict == "pass"


def test_what_the_laboratory_does_about_it_is_in_no_reason_that_a_certificate_prints(tmp_path: Path) -> None:
    finding = replace(TURNED, what_to_do="look at coupling and base, and measure again")
    second = replace(a_sensor(10), findings=(finding,))
    url, sha256 = published(tmp_path, second)
    (listed,) = [entry for entry in list_sets(url) if entry.sha256 == sha256]
    adjustment = adjustment_of(url, sha256)
    assert adjustment is not None
    for said in (listed.quarantine, adjustment.no_as_found):
        assert finding.fact in str(said)
        assert "measure again" not in str(said)
