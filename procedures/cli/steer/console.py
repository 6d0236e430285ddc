"""``calrig console``: the pages for a browser, and the accounts of the people who may use them and sign."""

from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from procedures.accounts.people import Role
from procedures.cli.locations import archive_to_show, login_name, people_of_here, queues_of_here
from procedures.cli.options import RUNS, Archive, Json, RunsFolder, require_folder
from procedures.cli.output import note, print_json, say
from procedures.console.address import DEFAULT_LISTEN
from procedures.console.sessions import Sessions
from procedures.errors import ExitStatus, RequestError
from procedures.journal.status.run_list import RunList
from rig.clock import SystemClock

app = App(
    name="console",
    help="Runs, the night and the archive in a browser, until Ctrl-C; runs are steered there by who may.",
    group_commands="Commands",
)
people = App(name="people", help="Who may look, operate and move, and sign results: each with a secret of their own.")
app.command(people)


@app.default
def console(
    *,
    listen: Annotated[
        str,
        Parameter(help="HOST:PORT; another address than this machine's own needs TLS; port 0 takes a free one."),
    ] = DEFAULT_LISTEN,
    tls_cert: Annotated[Path | None, Parameter(help="The certificate (PEM), with those above it.")] = None,
    tls_key: Annotated[Path | None, Parameter(help="Its key (PEM), without a password.")] = None,
    name: Annotated[
        tuple[str, ...], Parameter(negative=(), help="Another name by which browsers reach it, as in the certificate.")
    ] = (),
    proxy: Annotated[
        str, Parameter(help="Address that browsers use, as https://rig.example, of a proxy on this machine.")
    ] = "",
    files: Annotated[
        Path, Parameter(help="Folder whose procedure and rig files can be added to a queue in the browser.")
    ] = Path(),
    out: RunsFolder = RUNS,
    archive: Archive = None,
) -> int:
    """Show runs, the night and the archive in a browser, until Ctrl-C; runs are steered there by who may.

    At this machine each link that it prints opens one browser, for twelve hours; people with an account enter by name
    and secret. Other machines reach it only with TLS, or through a proxy, and by accounts alone.
    """
    # Of an extra: accounts and the help of every option are there without it.
    from procedures.console.serve import bound, serve
    from procedures.console.shared import Console

    require_folder(out, "--out")
    require_folder(files, "--files")
    if (tls_cert is None) != (tls_key is None):
        raise RequestError("--tls-cert and --tls-key belong together; nothing was served; give both or none")
    clock, accounts = SystemClock(), people_of_here()
    tls = None if tls_cert is None or tls_key is None else (tls_cert, tls_key)
    listening = bound(listen, tls, name, proxy)
    if not listening.is_here and not accounts.read():
        raise RequestError(
            "console: other machines reach it, and nobody has an account; nothing was served; calrig console people "
            "add NAME --role operate"
        )
    if listening.is_here:
        note("calrig console: open the link; each works once and the next one is told then; Ctrl-C ends it")
    else:
        where = next(iter(sorted(listening.site.hosts)))
        note(f"calrig console: people with an account enter at {listening.site.scheme}://{where}/login; Ctrl-C ends it")
    sessions = Sessions(clock, accounts, login_name())
    shown = Console(
        RunList(out, clock, verifies=True),
        partial(archive_to_show, out, archive),
        clock,
        sessions,
        listening.site,
        queues_of_here(),
        files.resolve(),
    )
    serve(listening, shown, note)
    return ExitStatus.DONE


@people.command
def add(
    name: Annotated[str, Parameter(help="As it is to stand in journals and under results.")],
    /,
    *,
    role: Annotated[Role, Parameter(help="watch looks, operate steers as well, move begins motion as well.")] = "watch",
    renew: Annotated[bool, Parameter(negative=(), help="Give somebody who is there another role and secret.")] = False,
    json: Json = False,
) -> None:
    """Give a person an account; the secret is told here, once, and kept nowhere."""
    secret = people_of_here().add(name, role, datetime.now(UTC), renews=renew)
    if json:
        print_json({"name": " ".join(name.split()), "role": role, "secret": secret})
        return
    say(f"{' '.join(name.split())}: {role}; the secret, told this once: {secret}")


@people.command(name="list")
def list_(*, json: Json = False) -> None:
    """List the people with an account."""
    found = sorted(people_of_here().read().values(), key=lambda person: person.name)
    if json:
        print_json(
            {"people": [{"name": person.name, "role": person.role, "added_utc": person.added_utc} for person in found]}
        )
        return
    for person in found:
        say(f"{person.name:<24} {person.role:<8} since {person.added_utc[:10]}")
    if not found:
        say("nobody has an account")


@people.command
def remove(name: str, /) -> None:
    """Take an account away; whoever is in by it is out at once. What was signed stays signed."""
    people_of_here().remove(name)
    say(f"{name}: has no account any more")
