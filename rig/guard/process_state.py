"""What the system says of another process, for a guard and its engine to see each other frozen."""


def state_of(pid: int) -> str:
    """Return the letter of a process' state where the system tells it; T is stopped."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            return file.read().rpartition(b")")[2].split()[0].decode()
    except (OSError, IndexError):
        return "?"
