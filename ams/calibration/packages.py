"""Packages that stood on one table, calibrated: each by itself, and what all of them show of the table's single dwells.

``calrig fit``, the studies and the count of false alarms go through here. A run does the same with what its procedure
says of each sensor: ``procedures/kinds/solve.py``, and a law holds both to the same findings.
"""

from collections.abc import Mapping
from dataclasses import replace

from ams.calibration.calibrate import calibrate
from ams.calibration.together.table_dwell_search import StoodPackage
from ams.calibration.together.table_dwells import judge_dwells
from ams.calibration_result import Calibration, with_findings
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations


def calibrate_packages(packages: Mapping[str, Observations], request: CalibrationRequest) -> Mapping[str, Calibration]:
    """Return by name the calibration of every package that one table turned.

    Where all of them together show that the table stood off at single dwells, they are solved again with these dwells
    in no test of a sensor, and all carry the one finding.

    Raises: as :func:`ams.calibration.calibrate.calibrate` does.
    """
    solved = {name: calibrate(rows, request) for name, rows in packages.items()}
    stood = [StoodPackage(name, rows, solved[name]) for name, rows in packages.items()]
    on_table = judge_dwells(stood, request.tested_axes)
    if not on_table.known.has_dwells:
        return solved
    again = replace(request, known_of_run=on_table.known)
    return {name: with_findings(calibrate(rows, again), on_table.findings) for name, rows in packages.items()}
