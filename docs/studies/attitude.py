"""The reports' figures of attitudes redrawn from the landed code: TP 6 to 20, CR 9, 10 and 20 to 23, SR 23 to 30.

Beside them stand 95 % intervals near singular attitudes.

    python docs/studies/attitude.py [--out FOLDER]

Writes ``attitude.md`` and its pictures in ``attitude/``; a minute. The words are those of
``attitude_study/page.template.md``: read them again where the numbers change.
"""

import argparse
from pathlib import Path

from attitude_study.motions import PICTURES as OF_MOTIONS
from attitude_study.page import facts
from attitude_study.singular import PICTURES as BESIDE_SINGULAR
from attitude_study.tp_figures import PICTURES as OF_TP
from tp_study.pictures import save

HERE = Path(__file__).parent
TEMPLATE = HERE / "attitude_study" / "page.template.md"


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--out", type=Path, default=HERE, help="folder for the page and its pictures")
    out = arguments.parse_args().out
    folder = out / "attitude"
    folder.mkdir(parents=True, exist_ok=True)
    for name, (height_in, draw) in {**OF_TP, **OF_MOTIONS, **BESIDE_SINGULAR}.items():
        save(folder / name, height_in, draw)
    page = out / "attitude.md"
    page.write_text(TEMPLATE.read_text("utf-8").format_map(facts()), encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
