"""The guide, as it stands: its tests are run, its examples too."""

import os
import re
import shutil
from pathlib import Path

import pytest
import yaml

GUIDE = Path(__file__).parent.parent.parent / "docs" / "guide" / "python.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.M | re.S)
PROGRAM = os.environ.get("ARCLINE_SERVER_PROGRAM") or shutil.which("arcline-server")


def test_the_tests_of_the_guide(pytester):
    tests = {block.splitlines()[0][2:]: block for block in BLOCKS if block.startswith("# test_")}
    assert set(tests) == {"test_cell.py", "test_project.py", "test_client.py"}
    shutil.copy(GUIDE.parent.parent.parent / "tests" / "config" / "Cell.L5X", pytester.path)
    for name, text in tests.items():
        if name == "test_client.py" and PROGRAM is None:
            continue
        (pytester.path / name).write_text(text)
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", "-W", "error::pytest.PytestUnknownMarkWarning")
    result.assert_outcomes(passed=13 + (PROGRAM is not None))


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


def test_the_ci_example_of_the_guide_is_a_workflow():
    """The file is YAML, and each of its commands names existing files and options."""
    (block,) = re.findall(r"^```yaml\n(.*?)^```", GUIDE.read_text(), re.M | re.S)
    job = yaml.safe_load(block)["jobs"]["motion"]
    assert job["runs-on"].startswith("ubuntu")
    steps = job["steps"]
    assert all(("run" in step) != ("uses" in step) for step in steps)
    (cache,) = [step["with"] for step in steps if step.get("uses", "").startswith("actions/cache")]
    assert cache["path"].split() == ["~/.cargo", "arcline/target"] and "Cargo.lock" in cache["key"]
    (upload,) = [step for step in steps if "upload-artifact" in step.get("uses", "")]
    assert upload["if"] == "failure()"
    commands = [step["run"] for step in steps if "run" in step]
    root = GUIDE.parent.parent.parent
    for command in commands:
        for path in re.findall(r"\./?arcline/(\S+)|arcline/(\S+)", command):
            assert (root / "".join(path)).is_dir(), command
    tests = commands[-1].split()
    assert tests[0] == "pytest" and tests[tests.index("--arcline-trace") + 1] == upload["with"]["path"]
