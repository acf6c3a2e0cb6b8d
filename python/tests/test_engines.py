"""The examples of batches, run by their engines with two workers: the same case has the same hash on each, and a worker that is lost costs its chunk only."""

import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import arcline

ROOT = Path(__file__).parent.parent.parent
EXAMPLES = ROOT / "examples" / "batches"
PROGRAM = os.environ.get("ARCLINE_SERVER_PROGRAM") or shutil.which("arcline-server")
COUNT = 300
CHUNK = 50

PART = "MAM(X, M1, Absolute, Move1.Speed, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\n"


@pytest.fixture
def batch(tmp_path):
    """A program, the file of its cases, and the hashes of these."""
    program = tmp_path / "part.st"
    program.write_text(PART)
    fault = [{"axis": "X", "fault": "overcurrent", "at": [0.01, 0.1]}]
    cases = [{"id": n, "set": {"Move1.Speed": n % 17 + 1.5}, "faults": fault if n % 3 == 0 else []} for n in range(COUNT)]
    (tmp_path / "cases.jsonl").write_text("".join(json.dumps(case) + "\n" for case in cases))
    hashes = [result["hash"] for result in arcline.simulate_many(cases, program)]
    assert len(set(hashes)) > 50
    return program, tmp_path / "cases.jsonl", hashes


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def hashes_of(text):
    results = [json.loads(line) for line in text.splitlines()]
    assert [result["case"] for result in results] == list(range(COUNT))
    return [result["hash"] for result in results]


def needs(program):
    if shutil.which(program) is None:
        assert os.environ.get("CI") != "true", f"{program} is missing"
        pytest.skip(f"{program} is missing")


def environment(**more):
    path = f"{Path(PROGRAM).parent}:{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "CHUNK": str(CHUNK), "JOBS": "2", **more}


def test_the_hash_is_that_of_the_trace(batch, monkeypatch, capsys):
    """The recipe of the page, over the trace of a case with a fault."""
    program, cases, hashes = batch
    folder = cases.parent
    (case,) = [json.loads(cases.read_text().splitlines()[0])]
    (result,) = arcline.simulate_many([case], program, trace=folder / "trace.csv".replace(".", "{case}."))
    (folder / "trace0.csv").rename(folder / "trace.csv")
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs" / "BATCHES.md").read_text(), re.M | re.S)
    (recipe,) = [block for block in blocks if "hashlib" in block]
    monkeypatch.chdir(folder)
    exec(recipe, {})
    assert capsys.readouterr().out.strip() == result["hash"] == hashes[0]
    (example,) = [block for block in blocks if "simulate_many" in block]
    exec(example, {})
    assert capsys.readouterr().out.startswith("finished 5.0 ")


@pytest.mark.skipif(PROGRAM is None, reason="needs arcline-server")
def test_gnu_parallel(batch):
    needs("parallel")
    program, cases, hashes = batch
    # Blank lines have no number, and so change no seed.
    lines = cases.read_text().splitlines(keepends=True)
    cases.write_text("".join(f"\n{line} \t\n" if number % 7 == 0 else line for number, line in enumerate(lines)))
    run = subprocess.run([EXAMPLES / "parallel.sh", program, cases], env=environment(), capture_output=True, text=True, check=True)
    assert hashes_of(run.stdout) == hashes


@pytest.mark.skipif(PROGRAM is None, reason="needs arcline-server")
def test_slurm_and_kubernetes(batch):
    """Their tasks, started by hand with the variable that says which one it is; one is lost and started again."""
    program, cases, hashes = batch
    folder = cases.parent
    manifest = (EXAMPLES / "kubernetes_job.yaml").read_text()
    script = re.search(r"- \|\n((?: {14}.*\n)+)", manifest).group(1)
    starts = {
        "slurm": (["sh", EXAMPLES / "slurm_array.sh", program, cases, folder], "SLURM_ARRAY_TASK_ID"),
        "kubernetes": (["/bin/sh", "-euc", script], "JOB_COMPLETION_INDEX"),
    }
    for engine, (command, variable) in starts.items():
        for task in range(COUNT // CHUNK):
            subprocess.run(command, env=environment(FOLDER=str(folder), **{variable: str(task)}), check=True)
        files = sorted(folder.glob("results-*.jsonl"))
        assert len(files) == COUNT // CHUNK, engine
        torn = files[2].read_bytes()
        files[2].write_bytes(torn[: len(torn) // 2])
        subprocess.run(command, env=environment(FOLDER=str(folder), **{variable: "2"}), check=True)
        assert hashes_of("".join(file.read_text() for file in files)) == hashes, engine
        for file in files:
            file.unlink()


def test_dask(batch):
    program, cases, hashes = batch
    results = cases.parent / "results.jsonl"
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(EXAMPLES)!r}); import with_dask; with_dask.main(*sys.argv[1:], size={CHUNK})"]
    subprocess.run([*command, program, cases, results], check=True, timeout=120)
    assert hashes_of(results.read_text()) == hashes


def test_dask_loses_a_worker(batch, tmp_path):
    from dask.distributed import Client, LocalCluster

    program, cases, hashes = batch
    parts = list(arcline.chunks(map(json.loads, cases.read_text().splitlines()), CHUNK))
    log = tmp_path / "log"
    log.mkdir()
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        futures = client.map(dies_once, parts, program=str(program), log=str(log), retries=3)
        results = [result for future in futures for result in future.result()]
    assert [result["hash"] for result in results] == hashes
    lost_only_its_chunks(log)


def test_ray(batch):
    program, cases, hashes = batch
    results = cases.parent / "results.jsonl"
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(EXAMPLES)!r}); import with_ray; with_ray.main(*sys.argv[1:], size={CHUNK})"]
    subprocess.run([*command, program, cases, results], check=True, timeout=180, env={**os.environ, "RAY_USAGE_STATS_ENABLED": "0"})
    assert hashes_of(results.read_text()) == hashes


def test_ray_loses_a_worker(batch, tmp_path):
    import ray

    program, cases, hashes = batch
    parts = list(arcline.chunks(map(json.loads, cases.read_text().splitlines()), CHUNK))
    log = tmp_path / "log"
    log.mkdir()
    folder = str(Path(__file__).parent)

    @ray.remote(num_cpus=1, max_retries=3)
    def run(part):
        sys.path.insert(0, folder)
        from test_engines import dies_once

        return dies_once(part, str(program), str(log))

    ray.init(num_cpus=2, include_dashboard=False)
    try:
        results = [result for part in ray.get([run.remote(part) for part in parts]) for result in part]
    finally:
        ray.shutdown()
    assert [result["hash"] for result in results] == hashes
    # Ray starts the task again, not those that the lost worker had done.
    assert {first: len(list(log.glob(f"{first}-*"))) for first, _ in parts} == {first: 1 + (first == 2 * CHUNK) for first, _ in parts}


@pytest.mark.skipif(PROGRAM is None, reason="needs arcline-server")
def test_gnu_parallel_loses_a_process(batch, tmp_path):
    """The process of the third chunk is killed when half its results are out; its chunk alone is run again."""
    needs("parallel")
    program, cases, hashes = batch
    log, bin = tmp_path / "log", tmp_path / "bin"
    log.mkdir()
    bin.mkdir()
    wrapper = bin / "arcline-server"
    wrapper.write_text(
        f"""#!/bin/sh
for word; do [ "$last" = --first ] && first=$word; last=$word; done
begun=$(ls {log} | grep -c "^$first-")
touch {log}/$first-$begun
if [ $first = {2 * CHUNK} ] && [ $begun = 0 ]; then
    {PROGRAM} "$@" | head -n {CHUNK // 2}
    kill -9 $$
fi
exec {PROGRAM} "$@"
"""
    )
    wrapper.chmod(0o755)
    there = environment()
    run = subprocess.run(
        [EXAMPLES / "parallel.sh", program, cases], env={**there, "PATH": f"{bin}:{there['PATH']}"}, capture_output=True, text=True, check=True
    )
    assert hashes_of(run.stdout) == hashes
    begun = {first: len(list(log.glob(f"{first}-*"))) for first in range(0, COUNT, CHUNK)}
    assert begun == {first: 1 + (first == 2 * CHUNK) for first in begun}


def dies_once(part, program, log):
    """Runs a chunk; the worker that begins the third one first is lost half-way through it."""
    first, cases = part
    begun = Path(log) / f"{first}-{len(list(Path(log).glob(f'{first}-*')))}"
    begun.touch()
    if first == 2 * CHUNK and begun.name.endswith("-0"):
        assert len(arcline.simulate_many(cases[: CHUNK // 2], program, first=first)) == CHUNK // 2
        os.kill(os.getpid(), signal.SIGKILL)
    return arcline.simulate_many(cases, program, first=first)


def lost_only_its_chunks(log):
    """The chunk of the lost worker was begun twice, and so may be those that it had done; the other worker's are not."""
    begun = {first: len(list(log.glob(f"{first}-*"))) for first in range(0, COUNT, CHUNK)}
    assert begun[2 * CHUNK] == 2
    assert sum(begun.values()) < 2 * len(begun), begun


def test_the_fault_campaign(tmp_path):
    pytest.importorskip("matplotlib")
    import pyarrow.parquet

    results = example("fault_campaign").main(tmp_path)
    table = pyarrow.parquet.read_table(tmp_path / "results.parquet")
    assert table.num_rows == len(results) == 2 * 3 * 52
    assert table["hash"].to_pylist() == [result["hash"] for result in results]
    assert {result["end"] for result in results} <= {"finished", "failed"}
    raised = [result for result in results if result.get("faults")]
    assert len(raised) > len(results) / 2
    assert (tmp_path / "campaign.png").stat().st_size > 10_000
