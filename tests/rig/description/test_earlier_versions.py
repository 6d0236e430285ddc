"""Laws of stored descriptions: what earlier versions wrote into journals is read for ever, and nothing else is."""

import json

import pytest
from table_bench import example_rig

from rig.description.read import rig_from_json
from rig.errors import DescriptionError


def test_a_key_that_was_dropped_does_not_close_an_old_journal() -> None:
    rig = example_rig()
    document = json.loads(rig.model_dump_json())
    document["readouts"]["dmm"]["settle_nplc"] = 1.0  # written by every version up to 0.1
    assert rig_from_json(json.dumps(document)).model_dump() == rig.model_dump()


def test_a_table_of_before_keeps_the_independent_teeth_that_it_was_solved_with() -> None:
    document = json.loads(example_rig().model_dump_json())
    for axis in document["axes"].values():
        del axis["index_errors"]
    assert {axis.index_errors for axis in rig_from_json(json.dumps(document)).axes.values()} == {"independent"}
    assert rig_from_json(example_rig().model_dump_json()).axes["pitch"].index_errors == "unknown"


def test_a_count_that_was_stored_with_seconds_is_read() -> None:
    count = {"driver": "csv-imu", "port": "twin", "rate_hz": 50.0, "columns": ["n", "ax"]}
    stream = count | {"count": {"column": "n"}, "channels": {"ax": {"preset": "SCA3000"}}}
    document = json.loads(example_rig().model_dump_json()) | {"streams": {"board": stream}}
    now = rig_from_json(json.dumps(document)).model_dump()
    stream["count"] = {"column": "n", "wraps_at": None, "unit_s": 1.0}  # as every version up to 0.1 wrote it
    assert rig_from_json(json.dumps(document)).model_dump() == now


def test_a_correction_file_that_was_stored_and_never_opened_is_read() -> None:
    rig = example_rig()
    document = json.loads(rig.model_dump_json())
    document["standards"]["table"]["correction_file"] = "errors.csv"  # null in every run of versions up to 0.1
    assert rig_from_json(json.dumps(document)).model_dump() == rig.model_dump()


@pytest.mark.parametrize("text", ["", "[]", "3", '{"rig": 1}', '{"readouts": {"dmm": 1}}', '{"readouts": []}'])
def test_what_is_no_description_is_refused(text: str) -> None:
    with pytest.raises(DescriptionError, match="use the calrig that wrote it"):
        rig_from_json(text)


def test_a_key_that_nobody_ever_wrote_is_refused() -> None:
    document = json.loads(example_rig().model_dump_json())
    document["readouts"]["dmm"]["nplc_settle"] = 1.0
    with pytest.raises(DescriptionError, match="nplc_settle"):
        rig_from_json(json.dumps(document))
