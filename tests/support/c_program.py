"""A header compiled into a program by the C compiler of this machine, and what the program prints."""

import shutil
import subprocess
from pathlib import Path

import pytest

COMPILER = shutil.which("cc")
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-trigraphs")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler `cc` on this machine")


def printed(folder: Path, headers: dict[str, bytes], main: str) -> list[list[float]]:
    """Lines of numbers that ``main`` prints."""
    for name, content in headers.items():
        (folder / name).write_bytes(content)
    includes = "".join(f'#include "{name}"\n' for name in headers)
    source = folder / "main.c"
    source.write_text(f"#include <stdio.h>\n{includes}int main(void)\n{{\n{main}\nreturn 0;\n}}\n")
    program = folder / "program"
    command = [str(COMPILER), *FLAGS, "-o", str(program), str(source), "-lm"]
    compiled = subprocess.run(command, capture_output=True, text=True, check=False)
    assert compiled.returncode == 0, compiled.stderr
    done = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    return [[float(number) for number in line.split()] for line in done.splitlines()]
