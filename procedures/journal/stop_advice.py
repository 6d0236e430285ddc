"""What a person should do, by the cause of a stop: the words on the page ``why.html`` and in ``docs/messages.md``."""

from collections.abc import Mapping

ADVICE: Mapping[str, str] = {
    "link": (
        "Check plug, cable, adapter and power of the device named above. The run tries again by itself, at least once "
        "a minute; when every device answers, it homes, measures the check set and goes on. Only stop or abort end "
        "that."
    ),
    "standstill": (
        "The run has ended, and not every axis could be seen to stand. Go and look at the machine: where something "
        "moves, press its stop button. Then mend the line or device named above (plug, cable, adapter, power) and "
        "calrig resume RUN --operator NAME --reason TEXT: it homes, measures the check set and goes on with the first "
        "missing dwell."
    ),
    "home": "An axis lost its home, as after a power cut of its controller. The run homes and goes on by itself.",
    "suspend": (
        "The computer slept. Forbid it (docs/service.md). The run opens its lines anew, homes and goes on by itself."
    ),
    "interlock": (
        "The value named above left its band. A hold goes on by itself when it is back; what was measured meanwhile is "
        "taken back and measured again. A trip: remove the cause, then calrig resume RUN --operator NAME --reason "
        "TEXT. Where the band itself is wrong: first correct the key that is named above in the rig file; resume with "
        "--accept-changes takes bands of [interlocks] over, everything else needs a new run."
    ),
    "disk": "Free space on the disk of the run. It goes on by itself when there is room.",
    "storage": (
        "The disk refused the journal; everything committed before is intact. Repair or free it, then calrig resume "
        "RUN; where the journal itself is damaged, calrig salvage RUN first."
    ),
    "moved": (
        "Somebody moved, renamed or removed the folder of the run while it went on. Put it back where it was, or find "
        "where it is now; then calrig resume it there. calrig ack RUN ends the alarm, by the name that the run had."
    ),
    "no run": (
        "The disk took no journal, so there is no run yet, and nothing moved. Make room or repair it, then begin the "
        "run again."
    ),
    "process died": (
        "The process of the run was killed, ran out of memory, or was frozen and then ended; its stop guard told every "
        "axis to stop. Find out what ended it and see that the axes stand, then calrig resume RUN."
    ),
    "link quality": "Look at cable, earth and adapter of the line named above, then calrig continue RUN.",
    "noise": "Look for vibration, a loose cable, a failing sensor or meter, then calrig continue RUN.",
    "suspect dwell": "See why the dwell was rejected, then calrig continue RUN: it is measured again.",
    "motion": (
        "Something moved an axis that should rest. See who or what, see that the package still sits as it did, then "
        "calrig resume RUN --operator NAME --reason TEXT; if it was moved, first calrig void RUN --from STEP "
        "--remounted."
    ),
    "supervision": (
        "An axis left the way that it was sent, or who would stop it is gone. See who or what moved it, whether the "
        "line or the stop guard was meddled with, and that nothing was wound up or hit; then calrig resume RUN "
        "--operator NAME --reason TEXT."
    ),
    "device": (
        "A device reports a fault: limit switch, stop button, coupling, drive. Clear it at the machine, then "
        "calrig resume RUN --operator NAME --reason TEXT; releasing a button alone starts nothing."
    ),
    "rig file": (
        "A device is set up otherwise than the rig file says; the key stands above in brackets. A resume before that "
        "is put right stops here again. Where the device is wrong: set it, then calrig resume RUN --operator NAME "
        "--reason TEXT. Where the file is wrong: correct that key, let calrig check and calrig prove pass, and begin a "
        "new run: this one keeps the file that it began with."
    ),
    "slip": (
        "The sensors say that an axis stands elsewhere than its read-back. The run homes, measures the check set and "
        "goes on; where homing does not help, the seam test trips. Look at coupling and encoder."
    ),
    "channels": (
        "Channels carry one another's readings: look at scanner, connectors and wiring, put them right, then calrig "
        "resume RUN --operator NAME --reason TEXT; the dwells in doubt were taken back and are measured again."
    ),
    "meter": (
        "The meter reads its short or its reference beyond the limit of the rig file; what was measured since its last "
        "good proof is taken back. Look at meter, scanner and reference; after a trip calrig resume RUN --operator "
        "NAME --reason TEXT, after a hold calrig continue RUN: it is read again at once. Where the limit itself is "
        "wrong: correct the key that is named above in the rig file and begin a new run."
    ),
    "process": "This process grew too far and ended the run in time: calrig resume RUN goes on; send its folder.",
    "identity": "Other devices answer than at the start: swapped cables or a replaced device. Put it right; resume.",
    "seam": (
        "The check set differs from the one before: look at what is named above. If the table turned, put it right "
        "first: dwells measured after a turn stand off the declared zero. If the package was moved, calrig void RUN "
        "--from STEP --remounted --operator NAME --reason TEXT; calrig resume RUN --operator NAME --reason TEXT "
        "accepts the step."
    ),
    "table": (
        "All sensors turned together: look at the table's coupling, its base and the common fixture. To measure the "
        "dwells in doubt again put it right, calrig stop RUN, then calrig void RUN --from STEP --operator NAME "
        "--reason TEXT (or calrig redo RUN --replication N --operator NAME --reason TEXT) and calrig resume RUN; "
        "calrig continue RUN keeps them, and the report says so. What is measured again on a table that has "
        "slipped and was not put right stands off its declared zero: such sets are not to be used."
    ),
    "mount": "Package, wiring and rig file contradict each other as told. Correct it; a changed file needs a new run.",
}
OTHERWISE = (
    "Read the cause above; calrig handover RUN shows the whole state, calrig resume RUN goes on where it can, "
    "after a trip with --operator NAME --reason TEXT."
)


def advice(cause: str) -> str:
    return ADVICE.get(cause, OTHERWISE)


def advice_once_stopped(cause: str) -> str:
    """Return the advice on a hold that a person stopped the run in: without the stop, and without a continue."""
    kept = advice(cause).replace("calrig stop RUN, then ", "then ")
    return kept.replace("calrig continue RUN", "calrig resume RUN")
