"""Laws of the fault file: strict, every mistake with its place, nothing that does not fit the rig."""

import sys
from pathlib import Path

import pytest
from installed_examples import install
from table_bench import example_rig, rig_file

from rig.assembly.faulty_lines import drivers_of
from rig.description.fault_plan import MAY_HAVE, NEEDS, FaultPlan, FaultRule, read_faults
from rig.description.read import read_rig
from rig.errors import DescriptionError

VALUES = {
    "delay_s": 1.5,
    "keep": 3,
    "byte": -1,
    "bit": 7,
    "text": "x",
    "code": 6,
    "away_s": 2.0,
    "other": "axes.roll",
    "for_s": 3.0,
    "slip_deg": 0.05,
    "seen": True,
    "lag_s": 0.2,
}


def _read(folder: Path, text: str) -> FaultPlan:
    path = folder / "faults.toml"
    path.write_text(text, encoding="utf-8")
    return read_faults(path, drivers_of(example_rig()))


def test_a_whole_file_is_read(tmp_path: Path) -> None:
    plan = _read(
        tmp_path,
        """seed = 3
[fault.late]
line = "axes.pitch"
kind = "delay"
nth = [2, 5]
delay_s = 1.5
[fault.noise]
line = "*"
kind = "flip-bit"
probability = 0.01
most = 3
[fault.unplugged]
line = "readouts.dmm"
kind = "rename"
at_s = 12.0
away_s = 4.0
""",
    )
    assert plan.seed == 3
    assert list(plan.of_line(["axes.pitch", "axes.roll"])) == ["late", "noise"]
    assert list(plan.of_line(["readouts.dmm"])) == ["noise", "unplugged"]
    assert plan.fault["late"].nth == (2, 5)


@pytest.mark.parametrize("kind", FaultRule.model_fields["kind"].annotation.__args__)
def test_every_kind_has_what_it_needs_and_nothing_else(kind: str) -> None:
    own = {name: VALUES[name] for name in (*NEEDS.get(kind, ()), *MAY_HAVE.get(kind, ()))}
    FaultRule(line="axes.pitch", kind=kind, nth=(1,), **own)
    for name in NEEDS.get(kind, ()):
        with pytest.raises(ValueError, match=f"{kind} needs {name}"):
            FaultRule(line="axes.pitch", kind=kind, nth=(1,), **{key: own[key] for key in own if key != name})
    strange = next(name for name in VALUES if name not in own)
    with pytest.raises(ValueError, match=f"{kind} has no {strange}"):
        FaultRule(line="axes.pitch", kind=kind, nth=(1,), **own, **{strange: VALUES[strange]})


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ('line = "axes.yaw"\nkind = "drop"\nnth = 1', r"faults.toml:2: fault.it.line: got 'axes.yaw', allowed axes"),
        ('line = "axes.pitch"\nkind = "lost"\nnth = 1', r"faults.toml:3: fault.it.kind: got 'lost'"),
        ('line = "axes.pitch"\nkind = "drop"', r"faults.toml:1: fault.it: .* one of nth, every, .*got none"),
        ('line = "axes.pitch"\nkind = "drop"\nnth = 1\nevery = 2', r"got nth and every"),
        ('line = "axes.pitch"\nkind = "drop"\nnth = 0', r"faults.toml:4: fault.it.nth"),
        ('line = "axes.pitch"\nkind = "drop"\nprobability = 1.5', r"faults.toml:4: fault.it.probability"),
        ('line = "axes.pitch"\nkind = "delay"\nnth = 1\ndelay = 2', r"faults.toml:5: fault.it.delay: .*write delay_s"),
        ('line = "*"\nkind = "slip"\nnth = 1\nslip_deg = 1.0', r"slip happens on one line; name it"),
        ('line = "readouts.dmm"\nkind = "stall"\nnth = 1\nfor_s = 1.0', r"faults.toml:2: fault.it.line: .*to an axis"),
        ('line = "axes.pitch"\nkind = "exception"\nnth = 1\ncode = 2', r"which indexing-table does not talk"),
        ('line = "axes.pitch"\nkind = "echo"\nnth = 1\non = "question"', r"echo happens to a reply"),
        ('line = "axes.pitch"\nkind = "flip-bit"\nnth = 1\nbit = 2', r"byte and bit together"),
        ('line = "axes.pitch"\nkind = "swap"\nnth = 1\nother = "axes.yaw"', r"toml:5: fault.it.other: got 'axes.yaw'"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_with_its_place(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(DescriptionError, match=complaint):
        _read(tmp_path, f"[fault.it]\n{text}\n")


def test_a_file_without_faults_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"faults.toml:1: fault: is missing"):
        _read(tmp_path, "seed = 1\n")


def test_a_wrong_kind_hides_no_wrong_line(tmp_path: Path) -> None:
    text = '[fault.it]\nline = "axes.yaw"\nkind = "lost"\nnth = 1\n[fault.that]\nline = "axes.pitch"\nkind = "swap"\n'
    with pytest.raises(DescriptionError) as refused:
        _read(tmp_path, f'{text}other = "axes.tilt"\nnth = 1\n')
    found = [line.removeprefix(str(tmp_path)) for line in str(refused.value).splitlines()]
    assert [line.partition(", allowed")[0] for line in found[1:]] == [
        "/faults.toml:2: fault.it.line: got 'axes.yaw'",
        "/faults.toml:8: fault.that.other: got 'axes.tilt'",
    ]
    assert found[0].startswith("/faults.toml:3: fault.it.kind: got 'lost'")


CHAMBER_OF_OTHERS = """from dataclasses import replace
from typing import Literal
from rig.drivers.watlow_f4 import DRIVER as F4
class Settings(F4.environment.settings):
    driver: Literal["foreign-f4"]
ENVIRONMENT = replace(F4.environment, settings=Settings)
DRIVER = replace(F4, name="foreign-f4", environment=ENVIRONMENT, speaks_modbus={speaks_modbus})
"""


@pytest.mark.parametrize("speaks_modbus", [True, False])
def test_a_driver_says_itself_whether_it_speaks_modbus(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, speaks_modbus: bool
) -> None:
    """One of another distribution: no list of calrig knows its name."""
    (tmp_path / "foreign_f4.py").write_text(CHAMBER_OF_OTHERS.format(speaks_modbus=speaks_modbus), encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "foreign_f4", raising=False)
    install("foreign", {"calrig.drivers": {"foreign-f4": "foreign_f4:DRIVER"}}, tmp_path / "site", monkeypatch)
    drivers = drivers_of(read_rig(rig_file(tmp_path, ('driver = "watlow-f4"', 'driver = "foreign-f4"'))))
    path = tmp_path / "faults.toml"
    path.write_text('[fault.it]\nline = "environment.air"\nkind = "exception"\nnth = 1\ncode = 6\n', encoding="utf-8")
    if speaks_modbus:
        assert read_faults(path, drivers).fault["it"].code == 6
    else:
        with pytest.raises(DescriptionError, match=r"toml:3: fault.it.kind: .*which foreign-f4 does not talk"):
            read_faults(path, drivers)
