"""How far the cables of an axis are wound, kept where a kill, a restart and a power cut find it again.

One small file an axis in the user's state folder, written whole and synced before an axis turns and when it rests. It
is named by the rig, the axis and its port: another machine has another memory. Twins in this process have none to
keep; they begin unwound with the process.
"""

import json
from dataclasses import asdict
from hashlib import blake2b
from pathlib import Path
from typing import Protocol

from platformdirs import user_state_path

from rig.abilities.abilities import WriteFile
from rig.cables.winding import Winding
from rig.description.device_settings import TWIN_PORT, AxisSettings
from rig.errors import DescriptionError

FORMAT = "calrig cable 1"


class CableMemory(Protocol):
    """Keeps the winding of one axis."""

    location: str
    """Where it is kept, for messages."""

    @property
    def is_writable(self) -> bool:
        """Whether its opener meant it to be written."""

    def read(self) -> Winding | None:
        """Return what was kept, None where nothing ever was.

        Raises: DescriptionError where it cannot be read.
        """

    def write(self, winding: Winding) -> None:
        """Keep how far the cables are wound. Raises: DescriptionError where it cannot be kept."""


class Unkept:
    """A :class:`CableMemory` that ends with its process."""

    location = "this process"
    is_writable = True

    def __init__(self) -> None:
        self._winding: Winding | None = None

    def read(self) -> Winding | None:
        return self._winding

    def write(self, winding: Winding) -> None:
        self._winding = winding


class KeptInFile:
    """A :class:`CableMemory` in one file."""

    def __init__(self, path: Path, write: WriteFile | None) -> None:
        self.location = str(path)
        self._path = path
        self._write = write

    @property
    def is_writable(self) -> bool:
        return self._write is not None

    def read(self) -> Winding | None:
        try:
            document = json.loads(self._path.read_text(encoding="utf-8"))
            if document.pop("format") != FORMAT:
                raise ValueError("is of another version")
            wound_deg, read_deg = float(document["wound_deg"]), float(document["read_deg"])
            return Winding(wound_deg, read_deg, bool(document["is_turning"]), bool(document["is_lost"]))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise DescriptionError(
                f"{self._path}: cannot be read: {error}; nothing moved; unwind the cables by hand, then remove the file"
            ) from None

    def write(self, winding: Winding) -> None:
        if self._write is None:
            raise DescriptionError(
                f"{self._path}: cannot be written: the rig was opened without a writer of files; nothing was turned;"
                " hand one to open_rig"
            )
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._write(self._path, json.dumps({"format": FORMAT, **asdict(winding)}).encode("utf-8"))
        except OSError as error:
            raise DescriptionError(
                f"{self._path}: cannot be written: {error.strerror}; how far the cables are wound must be kept before"
                " the axis turns; nothing was turned; free space or repair the folder"
            ) from error


def memory_of(
    rig: str, name: str, axis: AxisSettings, write: WriteFile | None, folder: Path | None = None
) -> CableMemory:
    """Return where the winding of an axis is kept; ``folder``: by default in the user's state folder.

    Without ``write`` it can only be looked at: the axis refuses to turn.
    """
    if axis.port == TWIN_PORT:
        return Unkept()
    if folder is None:
        folder = user_state_path("calrig") / "cables"
    identity = blake2b(f"{rig}|{name}|{axis.driver}|{axis.port}|{axis.axis}".encode(), digest_size=8).hexdigest()
    return KeptInFile(folder / f"{name}-{identity}.json", write)
