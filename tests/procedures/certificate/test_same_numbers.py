"""One run's numbers on its page, on its paper, in its JSON, in its set, in the archive and on its certificate.

The page prints two digits of the standard uncertainty, the certificate of the expanded one; what they print is read
back and held against the numbers of the machine-readable forms, which are the same to the last bit.
"""

import json
import re
import subprocess
from datetime import date
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from finished_job import FinishedJob
from programs import require_program
from report_journal import PROCEDURE, Slip, write_journal
from solved import provenance

from ams.analysis.diagnostics.beliefs import SLIP
from ams.archive.connection import reading
from ams.archive.sets import find_set, list_sets, stored_set
from ams.archive.sign_offs import SignOff
from ams.archive.signatures import sign_off
from ams.calibration.calibrate import calibrate
from ams.errors import ArchiveUnknown
from ams.exports.dcc import to_dcc
from ams.exports.formats import load_set
from ams.exports.statement import statement
from ams.inputs.observations_csv import read_csv
from ams.inputs.request import CalibrationRequest
from ams.parameter_words import words_of
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet, build_set
from procedures.certificate.grounds import Grounds, gaps_of
from procedures.certificate.page import certificate_page
from procedures.cli.results.coefficients_text import set_text
from procedures.delivery.deliver import deliver, run_document, solve_run

SENSOR = "SN1047"
SLIP_ARCSEC, SLIPPED = 72.0, 80
"""By how much, and the first step after it: in the third replication of six."""
WITHOUT = (
    ", without the level of the base, the uncertainty of the meter and the crosstalk of the scanner, which are not "
    "declared"
)
"""What the rig of the run does not declare: no word of the verdict stands without it."""
ROOT = Path(__file__).parents[3]


def _cells(page: str) -> dict[tuple[str, str], list[str]]:
    """Axis and label of every coefficient of a page's tables to its cells: plain text, decimals ungrouped."""
    found: dict[tuple[str, str], list[str]] = {}
    axis = ""
    for row in re.findall(r"<tr[^>]*>(.*?)</tr>", _with_low_lines(page), flags=re.DOTALL):
        cells = [unescape(re.sub(r"<[^>]+>", "", cell)).strip() for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        if len(cells) >= 6 and cells[0] in ("", "x", "y", "z"):
            axis = cells[0] or axis
            found.setdefault((axis, cells[1]), cells)
    return found


def _with_low_lines(page: str) -> str:
    return re.sub(r"<sub>(.*?)</sub>", r"_\1", page)


def _number(text: str) -> float:
    return float(text.replace("−", "-"))


def _last_digit(text: str) -> float:
    """Half of the last digit."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2]) * (1.0 + 1e-9)


@pytest.fixture(scope="module")
def slipped(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any], str]:
    """A run without a reference visit whose roll axis slips by 72″ between two dwells, and nobody is told."""
    run = tmp_path_factory.mktemp("slipped")
    procedure = PROCEDURE.partition("[check]")[0].replace("replications = 3", "replications = 6")
    write_journal(run, slip=Slip(SLIPPED, SLIP_ARCSEC / 3600.0), procedure=procedure)
    url = f"sqlite:///{run / 'archive.sqlite'}"
    delivery = deliver(solve_run(run), url)
    assert not delivery.failures
    return run, json.loads(json.dumps(run_document(delivery))), url


@pytest.fixture(scope="module", params=["sound", "slipped"])
def forms(request: pytest.FixtureRequest, finished_job: FinishedJob) -> dict[str, Any]:
    if request.param == "slipped":
        return _forms(*request.getfixturevalue("slipped"))
    archive = finished_job.folder / "runs" / "archive.sqlite"
    return _forms(finished_job.run, finished_job.summary, f"sqlite:///{archive}")


def _forms(run: Path, found: dict[str, Any], url: str) -> dict[str, Any]:
    (listed,) = list_sets(url)
    with reading(url, 5.0) as connection:
        archived = stored_set(connection, find_set(connection, listed.sha256))
    grounds = Grounds("1", date(2026, 3, 3), archived, None, sign_off(url, archived.sha256))
    return {
        "stored": archived,
        "certificate page": certificate_page(grounds),
        "gaps": tuple(gaps_of(grounds)),
        "json": found["sensors"][SENSOR]["axes"],
        "verdict": found["sensors"][SENSOR]["verdict"],
        "set": load_set(run / "coefficients" / f"{SENSOR}.json").document["axes"],
        "archive": archived.document["axes"],
        "html": _cells((run / "report.html").read_text(encoding="utf-8")),
        "certificate": _cells(certificate_page(grounds)),
        "paper": run / "report.pdf",
    }


def test_set_archive_and_json_have_the_same_numbers_to_the_last_bit(forms: dict[str, Any]) -> None:
    assert json.dumps(forms["set"], sort_keys=True) == json.dumps(forms["archive"], sort_keys=True)
    for axis, section in forms["json"].items():
        stored = forms["set"][axis]
        for name, parameter in section["parameters"].items():
            for key in ("value", "standard_uncertainty", "tp_standard_uncertainty"):
                assert stored["parameters"][name][key] == parameter[key], f"{axis} {name} {key}"
        assert stored["findings"] == section["findings"]


def _flat(text: str) -> str:
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", text)).split())


def test_the_verdict_is_one_word_in_json_set_archive_export_and_certificate(forms: dict[str, Any]) -> None:
    verdict = forms["verdict"]
    assert verdict in ("sound", "usable", "not usable")
    assert forms["stored"].document["verdict"] == verdict
    (said,) = (line for line in statement(forms["stored"]) if line.startswith("verdict of the calibration"))
    assert said.startswith(f"verdict of the calibration: {verdict}{WITHOUT}")
    goes_on = said.removeprefix(f"verdict of the calibration: {verdict}")
    assert f"verdict of the calibration: {verdict}" in set_text(forms["stored"].document, "engineering")
    assert f"Verdict of the calibration: <b>{verdict}</b>{goes_on}" in forms["certificate page"]
    assert f"verdict of the calibration {verdict}{goes_on}" in _flat(to_dcc(forms["stored"]).decode("utf-8"))
    if verdict != "not usable":
        assert WITHOUT in set_text(forms["stored"].document, "engineering").replace("\n", " ")


@pytest.mark.parametrize("form", ["html", "certificate"])
def test_what_is_printed_is_what_is_stored(forms: dict[str, Any], form: str) -> None:
    printed, compared = forms[form], 0
    for axis, section in forms["json"].items():
        for name, parameter in section["parameters"].items():
            words = words_of(name)
            cells = printed.get((axis, f"{words.label} {words.symbol}".strip()))
            if parameter["value"] is None or not parameter["standard_uncertainty"]:
                continue
            assert cells is not None, f"{axis} {name} stands on no row"
            assert abs(_number(cells[3]) - parameter["value"]) <= _last_digit(cells[3]), f"{axis} {name}: {cells}"
            compared += 1
    assert compared >= 12, "offset, sensitivity, coning and azimuth of three axes"


def test_the_expanded_uncertainty_of_page_and_certificate_is_one_number(forms: dict[str, Any]) -> None:
    shared = forms["html"].keys() & forms["certificate"].keys()
    assert len(shared) >= 12
    for row in shared:
        page, certificate = forms["html"][row], forms["certificate"][row]
        assert abs(_number(page[3]) - _number(certificate[3])) <= _last_digit(page[3]) + _last_digit(certificate[3])
        assert page[7] == certificate[4], f"{row}: {page} {certificate}"


def _paper(path: Path) -> str:
    """The letters of a PDF without what is between them."""
    done = subprocess.run([require_program("pdftotext"), "-layout", path, "-"], capture_output=True, check=True).stdout
    return re.sub(r"\s", "", done.decode("utf-8").replace("\u200e", ""))


def test_a_step_that_the_fit_finds_is_the_same_sentence_everywhere_and_keeps_the_set_apart(
    slipped: tuple[Path, dict[str, Any], str],
) -> None:
    run, document, url = slipped
    forms, sensor = _forms(*slipped), document["sensors"][SENSOR]
    (finding,) = (
        entry for entry in forms["json"]["x"]["findings"] if entry.get("test") == SLIP and entry["significant"]
    )
    text, stored = finding["text"], forms["stored"]
    assert finding["kind"] == "table-rotation"
    assert finding["turned_arcsec"] == pytest.approx(SLIP_ARCSEC, abs=2.0)
    assert finding["steps"][0] == SLIPPED
    assert sensor["verdict"] == "not usable"
    assert text in sensor["axes"]["y"]["warnings"]
    assert all(text in section["warnings"] for section in stored.document["axes"].values())
    (listed,) = list_sets(url)
    assert listed.quarantine == finding["fact"]
    with reading(url, 5.0) as connection, pytest.raises(ArchiveUnknown, match="only sets in quarantine"):
        find_set(connection, SENSOR)
    page = (run / "report.html").read_text(encoding="utf-8")
    words = re.sub(r"\s", "", text)
    assert words in re.sub(r"\s", "", unescape(re.sub(r"<[^>]+>", "", page)))
    assert words in _paper(forms["paper"])
    assert "the set is in quarantine: what its findings say" in forms["gaps"], "no certificate is issued on it"
    (gap,) = (gap for gap in forms["gaps"] if finding["fact"] in gap)
    assert gap.startswith("axes x, y, z: ")
    assert gap.endswith(finding["what_to_do"])


def test_the_paper_has_every_number_of_the_page(forms: dict[str, Any]) -> None:
    text = _paper(forms["paper"])
    for (axis, label), cells in forms["html"].items():
        for cell in (cells[3], cells[4], cells[7]) if len(cells) > 7 else ():
            assert re.sub(r"\s", "", cell) in text, f"{axis} {label}: {cell}"


def _formula(page: str, axis: str) -> str:
    """The equation of an axis as it is printed, made Python."""
    (text,) = re.findall(rf"<p>Axis {axis}: (v = .*?);", unescape(page))
    for printed, code in {"−": "-", "·": "*", "²": "**2", "³": "**3", "α": "alpha", "₃": "3"}.items():
        text = text.replace(printed, code)
    spaced = re.sub(r"(cos|sin) (alpha|Ω|[RA]\b|\([^()]*\))", r"\1(\2)", text.partition(" = ")[2])
    return re.sub(r"\)\s+(?=cos|sin|\()", ")*", spaced)


def hold_told_outputs(page: str, coefficients: CoefficientSet) -> None:
    """Hold the outputs by the printed equation with the printed values, what is taken off included, to the set's."""
    page = _with_low_lines(page)
    rng = np.random.default_rng(5)
    pitch, roll = rng.uniform(-0.7, 0.7, 40), rng.uniform(-2.3, 2.3, 40)
    f = (np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll))
    expected = apply(coefficients, pitch, roll)
    taken_off: dict[str, dict[str, list[float]]] = {}
    axis = ""
    for row in re.findall(r"<tr[^>]*>(.*?)</tr>", page.partition("Taken off")[2], flags=re.DOTALL):
        cells = [unescape(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        if len(cells) == 6 and re.match("q_|K₃", cells[1]):
            axis = cells[0] or axis
            taken_off.setdefault(axis, {})[cells[1]] = [_number(cell) for cell in cells[2:]]
    for label in coefficients.axes:
        values: dict[str, float] = {}
        slack = 0.0
        for (of, words), cells in _cells(page).items():
            if of == label and words not in taken_off.get(label, {}):
                scale = np.pi / 180.0 if cells[2] == "°" else 1.0
                number = re.sub(r"\s", "", cells[3])
                values[words.split()[-1].replace("₃", "3")] = scale * _number(number)
                slack += 2.0 * scale * _last_digit(number)
        names = {
            **values,
            "alpha": pitch,
            "R": roll,
            "f_x": f[0],
            "f_y": f[1],
            "f_z": f[2],
            "cos": np.cos,
            "sin": np.sin,
        }
        found = eval(_formula(page, label), {}, names)
        for symbol, (c_0, c_x, c_y, c_z) in taken_off.get(label, {}).items():
            found = found - values[symbol.replace("₃", "3")] * (c_0 + c_x * f[0] + c_y * f[1] + c_z * f[2])
        np.testing.assert_allclose(found, expected[label], rtol=0.0, atol=slack)
        assert slack < 2e-3


def test_whoever_has_the_certificate_alone_gets_the_outputs_of_the_set(forms: dict[str, Any]) -> None:
    hold_told_outputs(forms["certificate page"], forms["stored"])


def test_that_holds_for_terms_of_second_and_third_order() -> None:
    columns = {axis: f"s{axis}_v" for axis in "xyz"}
    rows = read_csv(ROOT / "examples" / "observations.csv", columns, ("pitch", "roll"))
    request = CalibrationRequest(model="pitch-roll", nominal_axes={axis: axis for axis in "xyz"}, extended="yes")
    entry = build_set(calibrate(rows, request), provenance())
    assert all(numbers.centred_terms for numbers in entry.axes.values())
    grounds = Grounds("1", date(2026, 3, 3), entry, None, SignOff(entry.sha256, (), ()), is_specimen=True)
    page = certificate_page(grounds)
    hold_told_outputs(page, entry)
    assert "model “pitch-roll” (TP" in page
    assert "q<sub>xx</sub>·(f<sub>x</sub>² − f<sub>z</sub>²)" in page
    shown = " ".join(re.findall(r"<p>Axis .*?</p>", page))
    assert "_" not in shown, "an index stands beside its letter"
    assert "IEEE Std 1293" in page
