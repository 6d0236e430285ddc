from datetime import date

from report_journal import EXAMPLE_RIG

from procedures.report.sections.equipment import declared_sections, device_rows, standard_rows
from rig.description.read import read_rig
from rig.description.rig_file import Job, Level, LevelReading, RigDescription, Standard


def _rig(**changes: object) -> RigDescription:
    return read_rig(EXAMPLE_RIG).model_copy(update=changes)


def test_sections_that_were_left_empty_are_not_shown() -> None:
    assert declared_sections(_rig()) == {}


def test_what_was_declared_keeps_its_keys_and_so_its_units() -> None:
    level = Level(instrument="spirit", before=LevelReading(about_pitch_arcsec=1.5, about_roll_arcsec=-2.0))
    sections = declared_sections(_rig(job=Job(number="J-7"), level=level))
    assert sections["job"] == {"number": "J-7"}
    assert sections["level of the base"]["before.about_roll_arcsec"] == "-2.0"


def test_a_standard_says_what_kind_of_uncertainty_it_states() -> None:
    due = date(2027, 6, 30)
    standards = {
        "table": Standard(serial="1", certificate="a", due=due, uncertainty_arcsec=1.0),
        "meter": Standard(serial="2", certificate="b", due=due, kind="expanded", k=2.0, uncertainty_v=8e-6),
        "bare": Standard(serial="3", certificate="c", due=due),
    }
    texts = [row.uncertainty for row in standard_rows(_rig(standards=standards))]
    assert texts == ["±1 ″ (limit)", "±8e-06 V (expanded, k = 2)", "none stated"]


def test_every_device_stands_with_what_it_answered() -> None:
    rows = {row.name: row for row in device_rows(_rig(), {"axes.pitch": "TABLE,7", "dmm": "HP3458A"})}
    assert rows["axes.pitch"].identity == "TABLE,7"
    assert rows["axes.pitch"].standard == "table"
    assert rows["readouts.dmm"].identity == "HP3458A"
    assert rows["environment.air"].identity == ""


def test_the_level_stands_among_the_devices_with_its_instrument_and_standard() -> None:
    assert "level" not in {row.name for row in device_rows(_rig(), {})}
    rows = {row.name: row for row in device_rows(_rig(level=Level(instrument="Talyvel 6", standard="level")), {})}
    assert (rows["level"].identity, rows["level"].standard) == ("Talyvel 6", "level")
