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

import pytest
from finished_job import FinishedJob
from programs import require_program

from ams.archive.connection import reading
from ams.archive.sets import find_set, stored_set
from ams.archive.signatures import sign_off
from ams.exports.formats import load_set
from ams.parameter_words import words_of
from procedures.certificate.grounds import Grounds
from procedures.certificate.page import certificate_page

SENSOR = "SN1047"


def _cells(page: str) -> dict[tuple[str, str], list[str]]:
    """Axis and label of every coefficient of a page's tables to its cells: plain text, decimals ungrouped."""
    found: dict[tuple[str, str], list[str]] = {}
    axis = ""
    for row in re.findall(r"<tr[^>]*>(.*?)</tr>", page, flags=re.DOTALL):
        cells = [unescape(re.sub(r"<[^>]+>", "", cell)).strip() for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        if len(cells) >= 6 and cells[0] in ("", "x", "y", "z"):
            axis = cells[0] or axis
            found.setdefault((axis, cells[1]), cells)
    return found


def _number(text: str) -> float:
    return float(text.replace("−", "-"))


def _place(text: str) -> float:
    """Half of the last digit."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2]) * (1.0 + 1e-9)


@pytest.fixture(scope="module")
def forms(finished_job: FinishedJob) -> dict[str, Any]:
    run, told = finished_job.run, finished_job.told
    url = f"sqlite:///{finished_job.folder / 'runs' / 'archive.sqlite'}"
    with reading(url, 5.0) as connection:
        archived = stored_set(connection, find_set(connection, SENSOR))
    grounds = Grounds("1", date(2026, 3, 3), archived, None, sign_off(url, archived.sha256))
    return {
        "json": told["sensors"][SENSOR]["axes"],
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
            assert abs(_number(cells[3]) - parameter["value"]) <= _place(cells[3]), f"{axis} {name}: {cells}"
            compared += 1
    assert compared >= 12, "offset, sensitivity, coning and azimuth of three axes"


def test_the_expanded_uncertainty_of_page_and_certificate_is_one_number(forms: dict[str, Any]) -> None:
    shared = forms["html"].keys() & forms["certificate"].keys()
    assert len(shared) >= 12
    for row in shared:
        page, certificate = forms["html"][row], forms["certificate"][row]
        assert abs(_number(page[3]) - _number(certificate[3])) <= _place(page[3]) + _place(certificate[3])
        assert page[7] == certificate[4], f"{row}: {page} {certificate}"


def test_the_paper_has_every_number_of_the_page(forms: dict[str, Any]) -> None:
    paper: Path = forms["paper"]
    told = subprocess.run([require_program("pdftotext"), "-layout", paper, "-"], capture_output=True, check=True).stdout
    text = re.sub(r"\s", "", told.decode("utf-8").replace("\u200e", ""))
    for (axis, label), cells in forms["html"].items():
        for cell in (cells[3], cells[4], cells[7]) if len(cells) > 7 else ():
            assert re.sub(r"\s", "", cell) in text, f"{axis} {label}: {cell}"
