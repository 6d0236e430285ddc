"""What the system withholds from the account of the console, in words; another account's run is the usual reason."""


def withheld_sentence(error: OSError) -> str:
    """Return why nothing was shown or done."""
    what = f"{error.filename or 'a file of it'}: {error.strerror or error}"
    if isinstance(error, PermissionError):
        return f"{what}: it belongs to another account of this machine; nothing was done; ask who has it"
    return f"{what}; nothing was done"
