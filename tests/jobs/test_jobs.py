#!/usr/bin/env python3
"""Sweeps in independent jobs make the report that one process makes.

Each case runs a command as a whole, and its jobs by the lines that --list-jobs prints, and compares the
tables byte for byte, but for the times. Jobs are killed and run again; a report that lacks jobs says so;
results of other options or inputs are refused.

usage: test_jobs.py SOURCE THRUM [CASE ...]

SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

SECONDS = 300  # that any command may take
# columns that are times, or are made of them
TIMES = {"us_per_step", "cost_s_per_s", "force_us", "step_us", "linear_step_us", "nonlinear_us", "speedup", "front"}

MODELS = ["--models", "long.npz,thick.npz"]
FAST = ["--schemes", "newmark,energy"]
EXPERIMENTS = {
    "matrix": [*MODELS, *FAST, "--time", "0.1"],
    "long": ["--long", *MODELS, *FAST, "--steps", "24000", "--amplitudes", "0.02,0.05"],
    "sweep": ["--sweep", "--models", "long.npz", *FAST, "--time", "0.05"],
    "work and precision": ["--work-precision", "--models", "long.npz", *FAST, "--time", "0.05"],
    "extremes": ["--extremes", *FAST, "--subjects", "tet,snap,density", "--steps", "10"],
    "linear": ["--linear", "--models", "long.npz"],
}


class Work:
    """A folder with two small models, and the program."""

    def __init__(self, source, program, folder):
        self.scripts = pathlib.Path(source, "examples", "jobs")
        self.program, self.folder = program, pathlib.Path(folder)
        for name, mesh in ("long", "beam:6x1x1@1x0.1x0.1"), ("thick", "beam:4x2x2@1x0.3x0.2"):
            self.thrum("precompute", mesh, "--order", "1", "--fix", "x<0.001", "--modes", "3", "--rank", "5",
                       "-o", f"{name}.npz")

    def thrum(self, *arguments, code=0):
        return self.check([self.program, *arguments], code)

    def check(self, command, code=0, **more):
        ran = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=SECONDS, check=False, **more)
        assert ran.returncode == code, f"{command}: exit code {ran.returncode}, not {code}\n{ran.stdout}\n{ran.stderr}"
        return ran

    def lines(self, *command):
        found = self.thrum(*command, "--list-jobs").stdout.splitlines()
        assert found, command
        return found

    def line(self, text):
        """A line of --list-jobs, as a shell runs it."""
        self.check(text, shell=True)

    def tables(self, folder):
        """The tables of a folder, without their times."""
        found = {}
        for path in sorted((self.folder / folder).glob("*.csv")):
            with open(path, newline="", encoding="utf-8") as file:
                rows = list(csv.reader(file))
            timed = [n for n, name in enumerate(rows[0]) if name in TIMES]
            found[path.name] = [[text for n, text in enumerate(row) if n not in timed] for row in rows]
        assert found, folder
        return found

    def about(self, folder):
        path, = (self.folder / folder).glob("*.about.json")
        return json.loads(path.read_text(encoding="utf-8"))

    def page(self, folder):
        path, = (self.folder / folder).glob("*.html")
        return path.read_text(encoding="utf-8")


def jobs_make_the_tables_of_one_run(work):
    for name, options in EXPERIMENTS.items():
        folder = name.replace(" ", "_")
        work.thrum("experiments", *options, "-o", folder + "_whole", "-q")
        for line in work.lines("experiments", *options, "-o", folder, "-q"):
            work.line(line)
        collected = work.thrum("experiments", *options, "-o", folder, "--collect")
        assert "not whole" not in collected.stderr
        assert work.tables(folder) == work.tables(folder + "_whole"), name
        assert work.about(folder)["status"] == "done" and "Not whole" not in work.page(folder)


def killed_jobs_run_again(work):
    command = ["experiments", *EXPERIMENTS["matrix"], "--time", "3", "-q"]
    work.thrum(*command, "-o", "unkilled")
    lines, killed = work.lines(*command, "-o", "killed"), 0
    for n, line in enumerate(lines):
        job = subprocess.Popen("exec " + line, shell=True, cwd=work.folder, stdout=subprocess.DEVNULL)
        time.sleep(0.002 + 0.01 * n)
        job.kill()
        killed += job.wait() < 0

    # what is there under its name is whole
    assert killed > 0
    for path in (work.folder / "killed" / "jobs").glob("*.json"):
        json.loads(path.read_text(encoding="utf-8"))
    for line in lines:
        work.line(line)
    work.thrum(*command, "-o", "killed", "--collect")
    assert work.tables("killed") == work.tables("unkilled")


def a_report_that_lacks_jobs_says_so(work):
    command = ["experiments", *EXPERIMENTS["matrix"], "-o", "part", "-q"]
    nothing = work.thrum(*command, "--collect", code=1)
    assert "no result of any job" in nothing.stderr and not list((work.folder / "part").glob("*.csv"))
    lines = work.lines(*command)
    for line in lines[1:-1]:
        work.line(line)

    # the names are in the warning, beside the table, and on the page
    lacking = [line.split("# ")[1] for line in (lines[0], lines[-1])]
    collected = work.thrum(*command, "--collect", "--json", code=3)
    assert f"not whole: 2 of {len(lines)} jobs are missing: {', '.join(lacking)}" in collected.stderr
    for report in json.loads(collected.stdout), work.about("part"):
        assert report["status"] == "incomplete" and report["missing_jobs"] == lacking
    assert all(name in work.page("part") for name in lacking)

    # a job that is done is not run again
    result = work.folder / "part" / "jobs" / (lines[1].split("# ")[1] + ".json")
    before = result.stat().st_mtime_ns
    assert json.loads(work.thrum(*command, "--job", "2", "--json").stdout)["ran"] is False
    assert result.stat().st_mtime_ns == before


def results_of_another_sweep_are_refused(work):
    command = ["experiments", "-o", "other", "-q", *MODELS, "--schemes", "energy", "--time", "0.05"]
    work.thrum(*command, "--job", "1")
    for more in ["--time", "0.06"], ["--schemes", "newmark"], ["--dt", "0.002"]:
        for call in ["--job", "1"], ["--collect"]:
            refused = work.thrum(*command, *more, *call, code=1)
            assert "is of other options or inputs" in refused.stderr, refused.stderr

    # a model of the same name that is another one
    os.replace(work.folder / "long.npz", work.folder / "kept.npz")
    work.thrum("precompute", "kept.npz", "--modes", "3", "--rank", "4", "-o", "long.npz")
    assert "model is" in work.thrum(*command, "--collect", code=1).stderr
    os.replace(work.folder / "kept.npz", work.folder / "long.npz")

    # what is damaged is no result, be it a digit of a number or the hash itself
    result, = (work.folder / "other" / "jobs").glob("*.json")
    whole = result.read_text(encoding="utf-8")
    digit = whole.index('"result"') + re.search(r"\d", whole[whole.index('"result"'):]).start()
    for damaged in (whole[:-20], whole[:20], "", whole[:digit] + str((int(whole[digit]) + 1) % 10) + whole[digit + 1:],
                    whole.replace("hash", "hush")):
        result.write_text(damaged, encoding="utf-8")
        for call in ["--job", "1"], ["--collect"]:
            assert "not the result of a job" in work.thrum(*command, *call, code=1).stderr, damaged
    result.write_text(whole, encoding="utf-8")
    work.thrum(*command, "--collect", code=3)
    assert "there are 6 jobs" in work.thrum(*command, "--job", "7", code=1).stderr
    assert "one of them at a time" in work.thrum(*command, "--job", "1", "--collect", code=2).stderr


def models_of_one_file_name_have_results_of_their_own(work):
    (work.folder / "elsewhere").mkdir()
    shutil.copy(work.folder / "thick.npz", work.folder / "elsewhere" / "long.npz")
    command = ["experiments", "--models", "long.npz,elsewhere/long.npz", "--loads", "impulse", "--schemes", "energy",
               "--time", "0.05", "-q"]
    lines = work.lines(*command, "-o", "alike")
    assert [line.split("# ")[1] for line in lines] == ["matrix-long.npz-impulse", "matrix-long.npz-impulse-2"]
    for line in reversed(lines):
        work.line(line)
    work.thrum(*command, "-o", "alike", "--collect")
    work.thrum(*command, "-o", "alike_whole")
    assert work.tables("alike") == work.tables("alike_whole")


def published_answers_are_computed_by_jobs(work):
    """Of the problems three that take no time, twice: what the computer gives is the same."""
    chosen = ["torsion", "hardening", "tumble"]
    for folder in "first", "second":
        command = ["verify", "--refinements", "0", "-q", "-o", folder]
        names = [line.split("# ")[1] for line in work.lines(*command)]
        for name in chosen:
            work.thrum(*command, "--job", str(names.index(name) + 1))
        collected = work.thrum(*command, "--collect", "--json", code=3)
        report = json.loads(collected.stdout)
        assert report["missing_jobs"] == [name for name in names if name not in chosen]
        assert len({row["problem"] for row in report["rows"]}) == len(chosen)
    for name in "verification.csv", "tables.md":
        first, second = ((work.folder / folder / name).read_bytes() for folder in ("first", "second"))
        assert first == second
    assert first.startswith(b"Not whole")
    assert "refinements is 0 there and 1 here" in work.thrum(
        "verify", "--refinements", "1", "-o", "first", "--collect", code=1).stderr


def runs_of_a_training_are_jobs(work):
    """The model of a training whose runs are there has the bytes of one that made them itself."""
    command = ["precompute", "beam:4x1x1@1x0.1x0.1", "--fix", "x<0.001", "--modes", "3", "--rank", "8", "--reproducible",
               "-q", "--train", "square:0,0,-1@tip", "--train", "start:mode:1,0.02", "--test", "gravity:0,3,-9.81",
               "--train-time", "0.1"]
    work.thrum(*command, "-o", "whole.npz")
    lines = work.lines(*command, "--keep-runs", "runs")
    assert [line.split("# ")[1] for line in lines] == ["training-1", "training-2", "test-1"]

    # a part of a training makes no model
    for line in lines[1:]:
        work.line(line)
    refused = work.thrum(*command, "--keep-runs", "runs", "-o", "trained.npz", "--collect", code=1)
    assert "1 of 3 jobs are missing: training-1" in refused.stderr and not (work.folder / "trained.npz").exists()
    work.line(lines[0])
    work.thrum(*command, "--keep-runs", "runs", "-o", "trained.npz", "--collect")
    assert (work.folder / "trained.npz").read_bytes() == (work.folder / "whole.npz").read_bytes()

    # of other loads, without a run, without a folder
    command[command.index("square:0,0,-1@tip")] = "square:0,0,-2@tip"
    assert "is of other options" in work.thrum(*command, "--keep-runs", "runs", "--job", "1", code=1).stderr
    next((work.folder / "runs").glob("full-*.npy")).unlink()
    command[command.index("square:0,0,-2@tip")] = "square:0,0,-1@tip"
    assert "is gone" in work.thrum(*command, "--keep-runs", "runs", "-o", "trained.npz", "--collect", code=1).stderr
    assert "--keep-runs DIR" in work.thrum(*command, "--list-jobs", code=2).stderr


def settings_of_a_tradeoff_are_jobs(work):
    """The bases asked for, one that cannot be made, and those that the search goes on with."""
    command = ["tradeoff", "long.npz", "--load", "square:0,0,-1@tip", "--time", "0.1", "--full-dt", "0.005", "--dts",
               "0.005,0.01", "--tolerances", "1e-6", "--integrators", "energy,newmark", "--ranks", "0,6,200", "--rank-max",
               "30", "--test", "gravity:0,3,-9.81", "--error", "0.01%", "--cubature", "off", "-q"]
    work.thrum(*command, "-o", "trade_whole")
    lines = work.lines(*command, "-o", "trade")
    names = [line.split("# ")[1] for line in lines]
    assert names[0] == "own" and names[-2:] == ["search-trained-30", "test-1"]
    for line in lines[:-2]:
        work.line(line)

    # the search needs a basis that is not there; for a larger error it needs none, but the test
    lacking = work.thrum(*command, "-o", "trade", "--collect", "--json", code=3)
    assert json.loads(lacking.stdout)["missing_jobs"] == ["search-trained-30"]
    larger = work.thrum(*command, "-o", "trade", "--collect", "--error", "50%", "--json", code=3)
    assert json.loads(larger.stdout)["missing_jobs"] == ["test-1"]

    for line in lines[-2:]:
        work.line(line)
    collected = json.loads(work.thrum(*command, "-o", "trade", "--collect", "--json").stdout)
    assert collected["status"] == "done" and collected["tests"][0]["error"] > 0
    assert work.tables("trade") == work.tables("trade_whole")
    about, whole = work.about("trade"), work.about("trade_whole")
    assert about["full"]["error"] == whole["full"]["error"] and about["recommended_row"] == whole["recommended_row"]
    assert "is of other options" in work.thrum(*command, "-o", "trade", "--collect", "--time", "0.2", code=1).stderr


def points_of_a_law_are_jobs(work):
    """Another law than that of the model: points alone, of which the search goes on with more, as in one run."""
    command = ["tradeoff", "long.npz", "--load", "square:0,0,-1@tip", "--time", "0.1", "--full-dt", "0.005", "--dts", "0.01",
               "--tolerances", "1e-6", "--integrators", "energy", "--ranks", "0,6", "--rank-max", "20", "--law", "corotational",
               "--cubature-errors", "0.05,0.1", "--test", "none", "--error", "0.001%", "-q"]
    whole = json.loads(work.thrum(*command, "-o", "law_whole", "--json", code=3).stdout)
    assert [run["cubature"]["error_wanted"] for run in whole["runs"]] == [0.1, 0.05] * 3
    both = [line.split("# ")[1] for line in work.lines(*command, "-o", "none", "--law", "stvk", "--ranks", "0,30")]
    assert both[:5] == ["own", "modes-30", "modes-30-single", "modes-30-cubature-0.1", "modes-30-cubature-0.05"]
    lines = work.lines(*command, "-o", "law")
    assert [line.split("# ")[1].rsplit("-cubature-", 1)[1] for line in lines] == ["0.1", "0.05"] * 3
    for line in lines:
        work.line(line)
    collected = json.loads(work.thrum(*command, "-o", "law", "--collect", "--json", code=3).stdout)
    assert collected["status"] == "flagged" and collected["full"]["law"] == "corotational"
    assert work.tables("law") == work.tables("law_whole")
    assert "is of other options" in work.thrum(*command, "-o", "law", "--collect", "--law", "neo-hookean", code=1).stderr


def scripts_for_clusters_run_the_lines(work):
    """Slurm and a launcher of MPI say by variables which process it is."""
    command = ["experiments", *EXPERIMENTS["matrix"], "-q"]
    work.thrum(*command, "-o", "alone")
    for folder, script, variables in (
            ("array", "slurm_array.sh", [{"SLURM_ARRAY_TASK_ID": str(n)} for n in range(1, 7)]),
            ("mpirun", "share_jobs.sh", [{"OMPI_COMM_WORLD_RANK": str(n), "OMPI_COMM_WORLD_SIZE": "4"} for n in range(4)]),
            ("srun", "share_jobs.sh", [{"SLURM_PROCID": str(n), "SLURM_NTASKS": "2"} for n in range(2)])):
        lines = work.lines(*command, "-o", folder)
        (work.folder / "jobs.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        for variable in variables:
            work.check([work.scripts / script, "jobs.txt"], env={**os.environ, **variable})
        work.thrum(*command, "-o", folder, "--collect")
        assert work.tables(folder) == work.tables("alone")

    # started by hand they say what they are for
    assert "--array" in work.check([work.scripts / "slurm_array.sh", "jobs.txt"], code=2).stderr
    assert "start it by mpirun" in work.check([work.scripts / "share_jobs.sh", "jobs.txt"], code=2).stderr


CASES = {function.__name__: function for function in (
    jobs_make_the_tables_of_one_run, killed_jobs_run_again, a_report_that_lacks_jobs_says_so,
    results_of_another_sweep_are_refused, models_of_one_file_name_have_results_of_their_own,
    published_answers_are_computed_by_jobs, runs_of_a_training_are_jobs, settings_of_a_tradeoff_are_jobs,
    points_of_a_law_are_jobs,
    scripts_for_clusters_run_the_lines)}


def main(source, program, *names):
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # idle threads would wait for each other beside other tests
    with tempfile.TemporaryDirectory() as folder:
        work = Work(os.path.abspath(source), os.path.abspath(program), folder)
        for name in names or CASES:
            began = time.monotonic()
            CASES[name](work)
            print(f"{name}: {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
