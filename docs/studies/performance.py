"""TP's figures 1 to 5 and 22 to 54 redrawn from the twin, with what agrees and what differs.

    python docs/studies/performance.py [--out FOLDER] [--reduced]

Writes ``performance.md`` and its pictures in ``performance/``; about a minute. ``--reduced`` only shows that it works.
The words are those of ``tp_study/page.template.md``: read them again where the numbers change.
"""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

from tp_study.evidence import FULL, REDUCED, gather
from tp_study.figures import pictures
from tp_study.page import write_page
from tp_study.pictures import save

HERE = Path(__file__).parent


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--out", type=Path, default=HERE, help="folder for the page and its pictures")
    arguments.add_argument("--reduced", action="store_true", help="two replications, few test runs")
    wanted = arguments.parse_args()
    with TemporaryDirectory() as scratch:
        evidence = gather(REDUCED if wanted.reduced else FULL, Path(scratch))
    folder = wanted.out / "performance"
    folder.mkdir(parents=True, exist_ok=True)
    for name, (height_in, draw) in pictures(evidence).items():
        save(folder / name, height_in, draw)
    write_page(wanted.out / "performance.md", evidence)
    print(wanted.out / "performance.md")


if __name__ == "__main__":
    main()
