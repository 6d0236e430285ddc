"""The exit status of every error, by the table of DESIGN: 1 failed, 2 the request or a file is wrong, 4 aborted."""

from importlib.metadata import version

import pytest
from command import call

from ams import errors as ams
from procedures.cli.failure import status_of
from procedures.errors import JournalError, PlanError, RunFailed
from rig import errors as rig


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (rig.DescriptionError, 2),
        (rig.RequestRefused, 2),
        (rig.RigBusy, 1),
        (rig.LinkLost, 1),
        (rig.DeviceSilent, 1),
        (rig.DeviceNonsense, 1),
        (rig.DeviceRefused, 1),
        (rig.DeviceFault, 1),
        (rig.WaitEnded, 4),
        (KeyboardInterrupt, 4),
        (ams.ObservationsError, 2),
        (ams.DesignError, 2),
        (ams.SetError, 2),
        (ams.ArchiveUnknown, 2),
        (ams.SolveError, 1),
        (ams.VectorsDisagree, 1),
        (ams.ArchiveError, 1),
        (ams.WriteFailed, 1),
        (PlanError, 2),
        (JournalError, 2),
        (RunFailed, 1),
        (OSError, 1),
        (ZeroDivisionError, 1),
    ],
)
def test_an_error_leaves_with_the_status_of_the_table(error: type[BaseException], status: int) -> None:
    assert status_of(error("said")) == status


def test_support_is_told_every_version_in_one_document(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "--version", "--json")
    assert outcome.status == 0
    assert outcome.document["calrig"] == version("calrig")
    assert {"numpy", "apsw", "pymodbus", "cyclopts"} <= outcome.document["libraries"].keys()
    assert None not in outcome.document["libraries"].values()
    assert outcome.document["extras"]["matplotlib"] == version("matplotlib")
