"""Rules of the sources: no unsafe code, and stubs that are those of the module."""

import re
import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parent.parent


def test_the_sources_have_no_unsafe_code():
    for file in (FOLDER / "src").glob("*.rs"):
        for number, line in enumerate(file.read_text().splitlines(), 1):
            code = line.split("//")[0]
            assert not re.search(r"\bunsafe\b", code), f"{file.name}:{number}"


def test_the_stubs_are_those_of_the_module():
    ran = subprocess.run([sys.executable, "-m", "mypy.stubtest", "arcline", "--ignore-disjoint-bases"], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_the_python_half_is_typed():
    files = [str(file) for file in (FOLDER / "module" / "arcline").glob("*.py")]
    config = str(FOLDER / "pyproject.toml")
    ran = subprocess.run([sys.executable, "-m", "mypy", "--config-file", config, *files], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
