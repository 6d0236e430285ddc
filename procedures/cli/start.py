"""Where the command begins: stops first (:mod:`procedures.cli.stop_at_once`), everything else later."""

import sys

from procedures.cli.standard_streams import open_closed_streams
from procedures.cli.stop_at_once import stop_at_once


def main() -> None:
    """Entry point of ``calrig``."""
    open_closed_streams()
    arguments = sys.argv[1:]
    status = stop_at_once(arguments)
    if status is None:
        from procedures.cli import main as command

        command.main(arguments)
    sys.exit(status)


if __name__ == "__main__":
    main()
