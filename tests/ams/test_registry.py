"""Registrations: calrig's own and other people's in one way, and a sentence for each that contradicts."""

import importlib.metadata
from pathlib import Path

import pytest
from example_files import ROOT
from installed_examples import install

from ams import registry as of_ams
from ams.errors import SetError
from ams.exports.format import Format
from ams.exports.formats import FORMATS
from ams.registry import Registry


def test_both_packages_read_registrations_by_the_same_text() -> None:
    assert (ROOT / "ams" / "registry.py").read_bytes() == (ROOT / "rig" / "registry.py").read_bytes()


def test_a_foreign_name_stands_behind_those_of_calrig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = list(FORMATS)
    install("others", {"calrig.exports": {"aaa": "nowhere:FORMAT"}}, tmp_path, monkeypatch)
    assert list(FORMATS) == [*own, "aaa"]
    assert FORMATS.foreign() == {"aaa": "others"}


@pytest.mark.parametrize("name", ["csv", "json"])
def test_a_foreign_name_that_hides_a_built_in_is_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install("others", {"calrig.exports": {name: "mine:FORMAT"}}, tmp_path, monkeypatch)
    with pytest.raises(SetError, match=rf"two distributions register '{name}': .*mine:FORMAT.*uninstall one"):
        list(FORMATS)


@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ("no_such_module:FORMAT", r"'mine' of others \(no_such_module:FORMAT\): cannot be loaded: ModuleNotFoundError"),
        ("ams.exports.json_text:nothing", "cannot be loaded: AttributeError"),
        ("ams.exports.json_text:to_json", r"is registered wrongly: .*needed is a ams.exports.format.Format"),
        ("ams.exports.json_text:FORMAT", "with the name 'mine'"),
    ],
)
def test_what_cannot_be_used_is_named_with_where_it_comes_from(
    target: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install("others", {"calrig.exports": {"mine": target}}, tmp_path, monkeypatch)
    with pytest.raises(SetError, match=sentence):
        FORMATS["mine"]


def test_an_installation_without_calrigs_own_entry_points_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(of_ams, "_select", lambda _path: importlib.metadata.EntryPoints().select)
    with pytest.raises(SetError, match="its own entry points are missing; install calrig again"):
        FORMATS["json"]


def test_an_unknown_name_is_no_error_of_the_installation() -> None:
    assert "nobody" not in Registry("calrig.exports", Format, SetError)
    with pytest.raises(KeyError):
        FORMATS["nobody"]
