"""A small file of what the journal cannot take: kept beside it, or elsewhere, until a resume journals it."""

import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ams.errors import WriteFailed
from ams.whole_file import write_whole
from procedures.journal.sidecar.second_folder import make_beside

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True)
class KeptBeside:
    """One such file: its name in a folder, and what it calls its form."""

    file: str
    form: str

    def keep(self, run_dir: Path, second_folder: Path | None, document: Mapping[str, object]) -> bool:
        """Write it where a disk takes it, the run's own first; False where none does."""
        content = json.dumps({"format": self.form, **document}, ensure_ascii=False).encode("utf-8")
        for folder in _folders(run_dir, second_folder):
            with suppress(WriteFailed, OSError):
                make_beside(folder, run_dir)
                write_whole(folder / self.file, content)
                return True
        return False

    def read(self, run_dir: Path, second_folder: Path | None, parse: Callable[[Any], Value]) -> Value | None:
        """Return what ``parse`` makes of it; None where nothing is kept that can be read."""
        for folder in _folders(run_dir, second_folder):
            with suppress(OSError, ValueError, KeyError, TypeError):
                document = json.loads((folder / self.file).read_text(encoding="utf-8"))
                if document["format"] == self.form:
                    return parse(document)
        return None

    def forget(self, run_dir: Path, second_folder: Path | None) -> None:
        """Remove it: it stands in the journal now."""
        for folder in _folders(run_dir, second_folder):
            with suppress(OSError):
                (folder / self.file).unlink()


def _folders(run_dir: Path, second_folder: Path | None) -> list[Path]:
    return [run_dir] if second_folder is None else [run_dir, second_folder / run_dir.name]
