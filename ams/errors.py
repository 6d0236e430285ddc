"""Errors of the mathematics, named by who must act. No device and no clock is known here."""


class AmsError(Exception):
    """Any error of this package: the base, never raised itself."""


class ObservationsError(AmsError):
    """The observations are wrong (file, row and column, what was found, what is allowed)."""


class DesignError(AmsError):
    """The design cannot determine the model: which parameters, which points are missing."""


class SolveError(AmsError):
    """The solver did not reach an answer it would vouch for; the message says why."""


class SetError(AmsError):
    """A coefficient set or export is damaged, of a newer version, or of another kind than it says."""


class SetWithdrawn(SetError):
    """A set that a person withdrew, by name and with a reason; nothing was computed or written with it."""


class SetNotUsable(UserWarning):
    """A set in use whose calibration says of itself that it is not usable: a warning, the set does what it is asked."""


class VectorsDisagree(AmsError):
    """An intact set whose test vectors are not reproduced by its own coefficients."""


class ArchiveError(AmsError):
    """The archive cannot be reached, read or written; nothing was half published."""


class OutsideValidity(AmsError):
    """A set is asked for an attitude or temperature it was not calibrated for, or lacks an input it needs."""


class ArchiveUnknown(ArchiveError):
    """What was asked for is no archive, or not in it: the URL or the name is wrong."""


class ArchiveAbsent(ArchiveUnknown):
    """There is no file yet at the archive's URL; whoever writes first makes it."""


class ArchiveDamaged(ArchiveError):
    """The archive's file or a row of it is not as it was written; nothing more is written to it."""


class ArchiveForbids(ArchiveError):
    """What was asked for is not allowed now: the order of signatures, the four eyes, a number that is taken."""


class WriteFailed(AmsError):
    """The file system refused a file; what was there before is as it was."""
