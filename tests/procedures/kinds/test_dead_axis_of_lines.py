"""Law of the pages of straight lines: a twin's axis that senses nothing is told, in its own unit, and has a page."""

from pathlib import Path

from motion_runs import motion_run

from procedures.report.assemble import assemble_view

DEAD = {r"(y = .*at_zero = 1\.697307, per_unit = )1\.003009": r"\g<1>0.0"}


def test_a_twins_dead_axis_has_a_page_without_gain_and_offset_in_what_is_sensed(tmp_path: Path) -> None:
    run = motion_run(tmp_path, "servo-mechanism", "magnetometer", {"replications = .*": "replications = 2"}, DEAD)
    solved = run.solved()
    view = assemble_view(solved.record, solved.sensors)
    assert view.verdict.trust == "unusable"
    (sensor,) = view.sensors
    assert sensor.section is not None
    parameters = sensor.section.tables[0]
    truths = {row[1]: row[-2] for row in _rows_of("y", parameters.rows)}
    assert [name for name in truths if name.startswith("gain")]
    assert {truths[name] for name in truths if name.startswith(("gain", "offset"))} == {"—"}
    every = (finding for axis in sensor.findings for finding in axis.findings)
    (found,) = [finding for finding in every if finding.kind == "axis-undetermined"]
    assert "µT/µT" in found.text
    assert "V/g" not in found.text


def _rows_of(axis: str, rows: tuple[tuple[str, ...], ...]) -> list[tuple[str, ...]]:
    """Return the rows of an axis, whose name stands in the first of them alone."""
    starts = [index for index, row in enumerate(rows) if row[0]]
    first = next(index for index in starts if rows[index][0] == axis)
    end = next((index for index in starts if index > first), len(rows))
    return list(rows[first:end])
