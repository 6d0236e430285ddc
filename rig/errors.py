"""The rig's errors, named by who must act.

A message reads: *device: what failed: got value and unit, allowed range and unit (file: key); what happened
to the hardware; what to do*. Every error of this package derives from :class:`RigError`, so a caller that
must reach the safe state catches one name.
"""


class RigError(Exception):
    """Any error of the rig: the base, never raised itself."""


class DescriptionError(RigError):
    """A file is wrong: which file, line and key, what was found, what is allowed. The author of the file acts."""


class RequestRefused(RigError):
    """The impossible was asked for (outside limits, not homed, off the increment). Nothing moved. The caller acts."""


class RigBusy(RigError):
    """Another process owns the rig or the port. Nothing was opened. The person at the bench acts."""


class LinkClosed(RigError):
    """We closed the link ourselves; using it again is a defect of ours."""


class LinkLost(RigError):
    """The port broke (unplugged, reset, refused): the cable or the adapter needs a look."""


class DeviceSilent(RigError):
    """No complete reply by the deadline: the device, its power or its address needs a look."""


class DeviceNonsense(RigError):
    """A reply that cannot be an answer to the question: noise, wrong baud rate, another device."""


class LineNotQuiet(DeviceNonsense):
    """A line in doubt on which something talks on and on: nothing was asked, and asking again would wait as long."""


class DeviceRefused(RigError):
    """The device understood and said no: its own error text is in the message."""


class NoSuchRegister(DeviceRefused):
    """A device has no such register, and says so: the one refusal that tells what it is, not what it is doing."""


class NoStop(DeviceRefused):
    """A machine has no stop: a move that began ends at its target. Nothing was sent."""


class FileContradicted(DeviceRefused):
    """A device is set up otherwise than the rig file says; the message names table and key in brackets.

    Whoever wrote the file acts, or whoever owns the device: trying again helps neither.
    """


class DeviceFault(RigError):
    """The device reports a fault of its own, or did not do what it acknowledged (not seated, not arrived)."""


class ChamberFault(DeviceFault):
    """A chamber is not at work as it was told, or somebody set it otherwise. Where its air is heading is told.

    Axes rest, and a person goes to the chamber.
    """


class MotionBreach(DeviceFault):
    """An axis did what it was not told: left its way, turned the wrong way or too fast, or moved unasked.

    It was stopped, and no attempt is repeated. A person looks.
    """


class GuardLost(DeviceFault):
    """The process that would stop the axes if this one died is gone, or nobody would find it.

    The axes were stopped; a person looks.
    """


class WaitEnded(RigError):
    """A stop was asked for during a wait; the driver left its device quiet before passing this on."""

    def __init__(self, what: str, by: str = "") -> None:
        super().__init__(f"{what}, asked for by {by}" if by else what)
        self.what = what
        self.by = by
        """Who or what asked for it; empty where nobody is known."""
