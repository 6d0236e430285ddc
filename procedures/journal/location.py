"""Where a run may live: a local folder that nobody synchronises.

SQLite's write-ahead log needs shared memory and locks that network file systems do not give, and a synchroniser that
copies or replaces a file behind the engine's back tears journal and log apart.
"""

import platform
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from procedures.errors import RequestError
from procedures.journal.storage import JOURNAL_FILE

NETWORK = frozenset(
    (
        "nfs",
        "nfs4",
        "cifs",
        "smb",
        "smb2",
        "smb3",
        "smbfs",
        "afs",
        "ncpfs",
        "ceph",
        "glusterfs",
        "lustre",
        "beegfs",
        "davfs",
        "fuse.davfs",
        "fuse.davfs2",
        "fuse.sshfs",
        "fuse.rclone",
        "fuse.s3fs",
        "fuse.gcsfuse",
        "fuse.glusterfs",
        "fuse.mergerfs",
        "fuse.smbnetfs",
        "fuse.google-drive-ocamlfuse",
        "vboxsf",
        "vmhgfs",
        "fuse.vmhgfs-fuse",
        "drvfs",
    )
)
"""File system types as the kernel names them."""
SYNCED = re.compile(
    r"^(dropbox|onedrive|google ?drive|icloud ?drive|nextcloud|owncloud|box sync|seafile|cloudstorage)\b", re.I
)
MARKERS = (".stfolder", ".dropbox", ".dropbox.cache", ".nextcloudsync.log", ".owncloudsync.log", ".seafile-data")
"""What synchronisers leave in the folders that they keep."""
MOUNTS = Path("/proc/self/mountinfo")


def require_local(folder: Path, mounts: Path = MOUNTS) -> None:
    """``folder`` need not exist yet. Raises: RequestError for a network or synchronised folder."""
    folder = folder.resolve()
    kind = file_system(folder, mounts)
    if kind in NETWORK:
        raise RequestError(
            f"{folder}: lies on a network file system ({kind}), where a journal can be torn; nothing was written; "
            "give a local --out and copy the finished run, or insist with --allow-network-folder"
        )
    keeper = next(_synchronisers(folder), None)
    if keeper is not None:
        raise RequestError(
            f"{folder}: {keeper} is kept by a synchroniser, which can tear a journal; nothing was written; give a "
            "folder outside it and copy the finished run, or insist with --allow-network-folder"
        )


def location_of(run_dir: Path) -> dict[str, object]:
    """Return where the journal of a run lies, as it is kept in it: a copy lies elsewhere and is another file."""
    found = (run_dir / JOURNAL_FILE).stat()
    return {"path": str(run_dir.resolve()), "inode": found.st_ino, "host": platform.node()}


def is_copy(run_dir: Path, before: Mapping[str, object]) -> bool:
    """Return whether this is another folder than the one that was written to last, and not the same that was moved.

    Where the other place holds no journal any more, the run was brought here whole. One folder by two names (a bind
    mount) is one run; two folders are two, also where they share the file: what copies by hard links (``cp -al``, a
    backup) shares the journal and not the log beside it.
    """
    now = location_of(run_dir)
    other = Path(str(before.get("path")))
    if now["path"] == before.get("path"):
        return now["inode"] != before.get("inode")
    if now["inode"] != before.get("inode") and now["host"] != before.get("host"):
        return True
    return (other / JOURNAL_FILE).exists() and not other.samefile(run_dir)


def file_system(folder: Path, mounts: Path = MOUNTS) -> str:
    """Type of the file system that holds ``folder``; empty where the system does not tell."""
    try:
        lines = mounts.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    held: tuple[int, str] = (-1, "")
    for line in lines:
        before, _, after = line.partition(" - ")
        point = Path(_unescaped(before.split(" ")[4]))
        if folder.is_relative_to(point) and len(point.parts) >= held[0]:
            held = (len(point.parts), after.split(" ")[0])
    return held[1]


def _synchronisers(folder: Path) -> Iterator[Path]:
    for parent in (folder, *folder.parents):
        if SYNCED.match(parent.name) or any((parent / marker).exists() for marker in MARKERS):
            yield parent


def _unescaped(point: str) -> str:
    r"""Return a mount point with the blanks that the kernel writes as ``\040``."""
    return re.sub(r"\\(\d{3})", lambda found: chr(int(found[1], 8)), point)
