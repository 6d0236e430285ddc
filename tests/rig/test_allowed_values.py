"""A refusal of a value names what may stand there, in the words of the file and not of a validator."""

import re
from pathlib import Path

import pytest
from example_files import EXAMPLE_PROCEDURE, EXAMPLE_RIG, changed

from procedures.kinds.read import read_procedure
from rig.description.read import read_rig
from rig.errors import DescriptionError

KEY = re.compile(r"^(\w+) = ")
EVERY = [
    (file, number)
    for file in (EXAMPLE_RIG, EXAMPLE_PROCEDURE)
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1)
    if KEY.match(line)
]
REFUSED = [
    ("gravity_mps2 = 9.79826", "gravity_mps2 = 1.0", "rig.gravity_mps2: got 1.0, allowed 9.7 to 9.9"),
    ("gravity_mps2 = 9.79826", "gravity_mps2 = nan", "got nan, allowed a finite number, 9.7 to 9.9"),
    ("due = 2027-06-30", 'due = "soon"', "standards.table.due: got 'soon', allowed a day, such as 2026-03-01, without"),
    (
        'kind = "limit"',
        'kind = "rough"',
        "table.kind: got 'rough', allowed 'limit', 'standard' or 'expanded'",
    ),
    ("uncertainty_arcsec = 1.0", "uncertainty_arcsec = -1.0", "uncertainty_arcsec: got -1.0, allowed 0 or more"),
]


@pytest.mark.parametrize(("before", "after", "sentence"), REFUSED)
def test_what_is_allowed_is_named_with_both_ends(tmp_path: Path, before: str, after: str, sentence: str) -> None:
    path = changed(EXAMPLE_RIG, before, after, tmp_path / "rig.toml")
    with pytest.raises(DescriptionError) as refused:
        read_rig(path)
    assert sentence in str(refused.value)
    assert re.search(r"rig\.toml:\d+: ", str(refused.value))


@pytest.mark.parametrize(("file", "number"), EVERY)
def test_a_value_of_another_form_is_refused_in_the_words_of_the_file(tmp_path: Path, file: Path, number: int) -> None:
    lines = file.read_text(encoding="utf-8").splitlines()
    lines[number - 1] = f"{KEY.match(lines[number - 1])[1]} = [[]]"  # type: ignore[index]
    path = tmp_path / file.name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(DescriptionError) as refused:
        (read_rig if file == EXAMPLE_RIG else read_procedure)(path)
    said = str(refused.value)
    assert f"{path}:{number}: " in said
    assert "allowed" in said
    assert not re.search(r"should|valid |instance", said)
