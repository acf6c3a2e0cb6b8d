"""The guide, as it stands: its tests are run, its examples too."""

import os
import re
import shutil
from pathlib import Path

import pytest

GUIDE = Path(__file__).parent.parent.parent / "docs" / "guide" / "python.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.M | re.S)
PROGRAM = os.environ.get("ARCLINE_SERVER_PROGRAM") or shutil.which("arcline-server")


def test_the_tests_of_the_guide(pytester):
    tests = {block.splitlines()[0][2:]: block for block in BLOCKS if block.startswith("# test_")}
    assert set(tests) == {"test_cell.py", "test_client.py"}
    for name, text in tests.items():
        if name == "test_client.py" and PROGRAM is None:
            continue
        (pytester.path / name).write_text(text)
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", "-W", "error::pytest.PytestUnknownMarkWarning")
    result.assert_outcomes(passed=4 + (PROGRAM is not None))


def test_the_example_of_the_guide():
    (example,) = [block for block in BLOCKS if not block.startswith("# test_")]
    names = {}
    exec(example, names)
    assert names["x"].shape == (256,) and 0.0 < names["x"].min() <= names["x"].max()


@pytest.mark.parametrize("page", ["python/README.md", "README.md"])
def test_the_examples_of_the_readmes(page):
    import arcline

    text = (GUIDE.parent.parent.parent / page).read_text()
    (block,) = [block for block in re.findall(r"^```python\n(.*?)^```", text, re.M | re.S) if "m.program(" in block]
    names = {"arcline": arcline}
    exec(block.replace('"machine.toml"', ""), names)
    assert list(names.get("xyz")[-1]) == [100.0, 50.0, 25.0] and names["m"].time == 1.0
