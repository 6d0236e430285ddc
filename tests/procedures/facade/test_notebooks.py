"""The notebooks of the examples run from their first cell to their last, and show what they promise."""

import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).parents[3]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


def test_there_are_three_and_none_carries_results_along() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["a-run", "fit-and-angles", "twins"]
    for path in NOTEBOOKS:
        cells = nbformat.read(path, as_version=4).cells
        assert [cell for cell in cells if cell.get("outputs")] == []


@pytest.mark.thorough
@pytest.mark.filterwarnings("default")  # of Jupyter's own
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_its_last_cell_shows_something(path: Path, tmp_path: Path) -> None:
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    notebook = nbformat.read(path, as_version=4)
    folder = {"metadata": {"path": str(tmp_path / "examples" / "notebooks")}}
    NotebookClient(notebook, timeout=100, resources=folder).execute()
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    kinds = {kind for output in code[-1].outputs for kind in output.get("data", {})}
    assert kinds & {"text/html", "image/svg+xml", "image/png"}, code[-1].outputs
