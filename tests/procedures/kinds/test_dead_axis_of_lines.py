"""Laws of the pages of straight lines: a twin's axis that senses nothing is told, in its own unit, and has a page; so
is one whose numbers are in another unit than its channel says.
"""

from pathlib import Path

from motion_runs import motion_run

from procedures.report.assemble import assemble_view

DEAD_AND_IN_MILLIGAUSS = {
    r"(y = .*at_zero = 1\.697307, per_unit = )1\.003009": r"\g<1>0.0",
    r"(z = .*at_zero = 3\.243229, per_unit = )0\.999985": r"\g<1>9.99985",
}


def test_an_axis_that_senses_nothing_or_in_another_unit_is_told_and_has_a_page(tmp_path: Path) -> None:
    few = {"replications = .*": "replications = 2"}
    run = motion_run(tmp_path, "servo-mechanism", "magnetometer", few, DEAD_AND_IN_MILLIGAUSS)
    solved = run.solved()
    view = assemble_view(solved.record, solved.sensors)
    assert view.verdict.trust == "unusable"
    (sensor,) = view.sensors
    assert sensor.section is not None
    parameters = sensor.section.tables[0]
    truths = {row[1]: row[-2] for row in _rows_of("y", parameters.rows)}
    assert [name for name in truths if name.startswith("gain")]
    assert {truths[name] for name in truths if name.startswith(("gain", "offset"))} == {"—"}
    every = {finding.kind: finding for axis in sensor.findings for finding in axis.findings}
    found = every["axis-undetermined"]
    assert "µT/µT" in found.text
    assert "V/g" not in found.text
    assert "the numbers look like mG" in every["axis-contradicted"].text


def _rows_of(axis: str, rows: tuple[tuple[str, ...], ...]) -> list[tuple[str, ...]]:
    """Return the rows of an axis, whose name stands in the first of them alone."""
    starts = [index for index, row in enumerate(rows) if row[0]]
    first = next(index for index in starts if rows[index][0] == axis)
    end = next((index for index in starts if index > first), len(rows))
    return list(rows[first:end])
