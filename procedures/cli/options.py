"""The options that several commands have: each is defined once, so that it has one name and one meaning everywhere."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from procedures.errors import RequestError

RUNS = Path("runs")
_A_RUN = "A run folder, its journal, its name under ./runs, or a folder that holds exactly one run"

Flag = Annotated[bool, Parameter(negative=())]
Json = Annotated[bool, Parameter(negative=(), help="Print one JSON document on standard output, and nothing else.")]
NamedRun = Annotated[str, Parameter(help=f"{_A_RUN}.")]
AnyRun = Annotated[str | None, Parameter(help=f"{_A_RUN}; by default the run that is alive, else the latest.")]
OnlyRun = Annotated[str | None, Parameter(help=f"{_A_RUN}; by default the only one that it can be done to.")]
RunsFolder = Annotated[Path, Parameter(alias="--runs", help="The folder of runs; --runs means it in every command.")]
Rig = Annotated[Path, Parameter(help="The rig file.")]
PilotRun = Annotated[
    str | None,
    Parameter(help=f"{_A_RUN}: its noise, lack of fit and drift are expected again; by default what is declared."),
]
Operator = Annotated[str | None, Parameter(help="Who does it, for the record; by default the login name.")]
NamedOperator = Annotated[str, Parameter(help="Who decides it, for the record.")]
Reason = Annotated[str | None, Parameter(help="Why, for the record.")]
NeededReason = Annotated[str, Parameter(help="Why, for the record.")]
SecretFile = Annotated[
    Path | None,
    Parameter(
        help="File whose first line is the secret of who signs (- is standard input); else the terminal asks.",
        allow_leading_hyphen=True,
    ),
]
Archive = Annotated[
    str | None,
    Parameter(
        help="URL of the archive, such as sqlite:///archive.sqlite; by default CALRIG_ARCHIVE, else the user's own."
    ),
]
Alerts = Annotated[
    Path | None,
    Parameter(
        help="File that says who is told of a hold, a trip and the end; by default alerts.toml in the user's "
        "configuration."
    ),
]
Detach = Annotated[
    bool,
    Parameter(negative=(), help="Give the shell back when the run has begun; calrig attach shows it again."),
]
AllowNetworkFolder = Annotated[
    bool,
    Parameter(negative=(), help="Keep the journal on a network or synchronised folder, against all advice."),
]


def require_folder_of(file: Path | None, option: str) -> None:
    """Refuse a file to write whose folder is not there; no command makes folders on the way. Raises: RequestError."""
    if file is not None and not file.parent.is_dir():
        raise RequestError(
            f"{option} {file}: there is no folder {file.parent}; nothing was written; make the folder or give another "
            "name"
        )


def require_folder(folder: Path, option: str) -> None:
    """Refuse a folder to write to that is not there. Raises: RequestError."""
    if not folder.is_dir():
        raise RequestError(
            f"{option} {folder}: is no folder that is there; nothing was written; make the folder or give another"
        )
