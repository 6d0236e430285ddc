"""``calrig prove``: first contact with real devices, beside what their twins would say."""

import json as json_text
import sys
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

from procedures.cli.locations import shared_archive_url
from procedures.cli.options import Flag, Json, Rig, require_folder_of
from procedures.cli.output import note, print_json, say
from procedures.errors import ExitStatus, RequestError
from procedures.lease.keeper import leased
from rig.assembly.prove import document_of
from rig.assembly.prove import prove as ask_all
from rig.assembly.questions import LARGEST_MOVE_DEG
from rig.description.read import read_rig


def prove(
    *, rig: Rig, motion: str | None = None, out: Path | None = None, yes: Flag = False, json: Json = False
) -> ExitStatus:
    """Ask every device of a rig all that moves and heats nothing, and tell where its twin would say otherwise.

    Meters are reset and read, streams run for a second. The status is 1 where something differs. A device whose
    identity the rig file states is not compared with the twin's in that.

    Parameters
    ----------
    motion
        An axis that is moved too, within 5 degrees: there and back, a stop on the way, its limits. It must be homed;
        it asks before it moves.
    out
        A zip file for what was said, byte by byte, with the rig file: to be sent, and to become a test.
    yes
        Move without asking.
    """
    require_folder_of(out, "--out")
    description = read_rig(rig)
    if motion is not None:
        _require_leave(motion, tuple(description.axes), yes=yes)
    with TemporaryDirectory(prefix="calrig-prove-") as kept:
        folder = Path(kept)
        with leased(shared_archive_url(), "prove", note) as lease:
            proofs = ask_all(description, folder, rig_file=rig, motion=motion, claim=lease.claim)
        document = document_of(proofs)
        if out is not None:
            with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as bundle:
                bundle.writestr("proof.json", json_text.dumps(document, ensure_ascii=False, indent=1))
                bundle.write(rig, "rig.toml")
                for transcript in sorted(folder.glob("*/*.jsonl")):
                    bundle.write(transcript, str(transcript.relative_to(folder)))
    if json:
        print_json(document)
    else:
        for proof in proofs:
            found = "asked and recorded; its driver has no twin to compare with" if proof.is_alone else "as its twin"
            say(f"{proof.key}: {proof.answers.compared['identity'] if proof.differences else found}")
            for difference in proof.differences:
                say(f"{proof.key}: {difference.field}: device says {difference.device}, twin says {difference.twin}")
        say(f"differences: {document['differences']}{'' if out is None else f'; bundle: {out}'}")
    return ExitStatus.FAILED if document["differences"] else ExitStatus.DONE


def _require_leave(motion: str, axes: tuple[str, ...], *, yes: bool) -> None:
    """Refuse a motion unless the axis is there and somebody lets it move. Raises: RequestError."""
    if motion not in axes:
        raise RequestError(f"--motion: no axis {motion!r} (allowed: {', '.join(axes)}); nothing was opened")
    if yes:
        return
    if not sys.stdin.isatty():
        raise RequestError("--motion: nobody can be asked here; nothing was opened; give --yes where nobody is near")
    note(f"{motion} will move by up to {LARGEST_MOVE_DEG:g}°: is everybody clear? Type its name to go on:")
    if input().strip() != motion:
        raise RequestError("--motion: not confirmed; nothing was opened")
