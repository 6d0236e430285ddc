"""Where the last words of a run lie whose own folder takes nothing, or is not there any more."""

from pathlib import Path

from platformdirs import user_state_path


def second_folder() -> Path:
    """Return the folder that holds them, each run's by its name."""
    return user_state_path("calrig") / "emergency"


def make_beside(folder: Path, run_dir: Path) -> None:
    """Make a folder for what is said of a run. Its own is never made anew: it was moved away, and is elsewhere.

    Raises: OSError where it cannot be made.
    """
    if folder != run_dir:
        folder.mkdir(parents=True, exist_ok=True)
