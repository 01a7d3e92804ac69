#!/usr/bin/env python3
"""Runs all fuzz targets in turn for a given time, and says how many inputs each took and what of the readers they reached.

usage: fuzz_long.py SOURCE BUILD CLANG --seconds N [--targets PATTERN ...] [--plain] [--max-len N] [--resume]
                    [--record FILE]

The targets are built with sanitizers (build.sh) in BUILD/fuzz, and take turns of --turn seconds. The inputs that reached
something new stay in BUILD/fuzz/NAME.found, so that a later run goes on from there. An input that crashes a target is left in
BUILD/fuzz, and the run goes on. At the end a second build counts the lines that all the inputs that were kept reach. Exits
with 1 where there is a finding.

With --plain the targets have no sanitizers, lie in BUILD/fuzz_plain, and take three to ten times as many inputs: crashes, hangs,
and what the targets themselves check are still findings. Run the inputs that it keeps with sanitizers afterwards: --resume
without --plain takes both folders.
SPDX-License-Identifier: Apache-2.0
"""
import argparse
import collections
import json
import os
import pathlib
import platform
import re
import resource
import shutil
import subprocess
import sys
import time

# the readers, whose lines are counted one by one
READERS = ("mesh/formats/mesh_read", "mesh/formats/surface_read", "io/json_read", "io/npy_file", "io/npz", "core/base/npy",
           "core/base/seal", "core/model/archive", "core/model/zip", "core/model/model_layout",
           "runtime/readout/embedding", "core/step/state_snapshot", "scene/scene_snapshot", "driver/scene/scene_spec",
           "driver/spec/load_spec", "driver/spec/start_spec", "driver/spec/base_motion_spec", "precompute/vega_reduced", "mesh/mesh_fix")

# memory that was given back is kept apart for a while, but not so much of it that each input takes new pages
ASAN_OPTIONS = "quarantine_size_mb=8:malloc_context_size=10"


def build(source, folder, clang, pattern, how):
    made = subprocess.run([source / "tests/fuzz/build.sh", source, folder, clang, pattern, how], check=True,
                          stdout=subprocess.PIPE, text=True)
    return made.stdout.split()


def corpora(source, found, name):
    """The folders of a target's inputs that there are, of which the first takes new ones."""
    plain = found.parent / "fuzz_plain"
    folders = [found / f"{name}.found", source / "tests/fuzz/corpus" / name.removeprefix("fuzz_")]
    folders += [plain / f"{name}.found"] if plain != found else []
    return [str(folder) for folder in folders if folder.exists()]


def turn(source, folder, name, seconds, longest):
    """One target for so many seconds: its executions, and whether it stopped at a finding."""
    (folder / f"{name}.found").mkdir(exist_ok=True)
    done = subprocess.run([folder / name, f"-max_total_time={seconds}", f"-max_len={longest}", "-timeout=60", "-rss_limit_mb=2048",
                           "-reload=0",
                           f"-artifact_prefix={folder}/{name}-", "-print_final_stats=1", "-verbosity=0",
                           *corpora(source, folder, name)], capture_output=True, check=False,
                          env=dict(os.environ, ASAN_OPTIONS=ASAN_OPTIONS))
    text = done.stderr.decode(errors="replace")
    number = re.search(r"number_of_executed_units: *(\d+)", text)
    if done.returncode != 0:
        (folder / f"{name}.log").write_text(text)
    return int(number[1]) if number else 0, done.returncode != 0


def covered_lines(source, folder, clang, names, found):
    """Lines of each reader that the inputs which were kept reach, and how many there are; None without llvm's programs."""
    tools = [shutil.which(tool) or shutil.which(f"{tool}-14") for tool in ("llvm-profdata", "llvm-cov")]
    if None in tools:
        return None
    build(source, folder, clang, "fuzz_*", "covered")
    profiles = []
    for name in names:
        profiles.append(str(folder / f"{name}.profraw"))
        subprocess.run([folder / name, "-runs=0", "-verbosity=0", *corpora(source, found, name)], check=False,
                       stderr=subprocess.DEVNULL, env=dict(os.environ, LLVM_PROFILE_FILE=profiles[-1]))
    # a target that failed has left nothing
    profiles = [path for path in profiles if os.path.exists(path) and os.path.getsize(path) > 0]
    subprocess.run([tools[0], "merge", "-sparse", *profiles, "-o", folder / "all.profdata"], check=True)
    objects = [part for name in names for part in ("-object", str(folder / name))]
    told = subprocess.run([tools[1], "export", "-summary-only", f"-instr-profile={folder / 'all.profdata'}", *objects[1:]],
                          check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    files = {}
    for file in json.loads(told.stdout)["data"][0]["files"]:
        name = os.path.relpath(file["filename"], source)
        lines = file["summary"]["lines"]
        if name.startswith(READERS) and lines["count"] > 0:
            files[name] = (lines["covered"], lines["count"])
    return files


def processor_time():
    """What the programs that have ended took [s]; a machine with other work makes other times mean little."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def report(executions, times, findings, lines):
    """The record as text."""
    total, hours = sum(executions.values()), sum(times.values()) / 3600
    text = [f"{total:,} executions of {len(executions)} targets in {hours:.2f} h of processor time, {sum(findings.values())} findings, "
            f"on {platform.machine()}, {os.cpu_count()} processors", "",
            "| target | executions | processor seconds | findings |", "|---|---|---|---|"]
    text += [f"| {name} | {executions[name]:,} | {times[name]:.0f} | {findings[name]} |" for name in sorted(executions)]
    if lines:
        covered, count = (sum(part[n] for part in lines.values()) for n in (0, 1))
        text += ["", f"Lines of the readers that the inputs reach: {covered} of {count}, {100 * covered / count:.1f} %.", "",
                 "| reader | lines reached | lines | % |", "|---|---|---|---|"]
        text += [f"| {name} | {a} | {b} | {100 * a / b:.1f} |" for name, (a, b) in sorted(lines.items())]
    return "\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("clang")
    parser.add_argument("--seconds", type=float, default=3600)
    parser.add_argument("--turn", type=int, default=20)
    parser.add_argument("--targets", nargs="+", default=["fuzz_*"])
    parser.add_argument("--plain", action="store_true", help="without sanitizers, in BUILD/fuzz_plain")
    parser.add_argument("--max-len", type=int, default=8192, help="longest input [bytes]")
    parser.add_argument("--resume", action="store_true", help="count on from an earlier run in the same folder")
    parser.add_argument("--record", type=pathlib.Path)
    wanted = parser.parse_args()
    source, folder = wanted.source.resolve(), wanted.build.resolve() / ("fuzz_plain" if wanted.plain else "fuzz")
    executions, times, findings = collections.Counter(), collections.Counter(), collections.Counter()
    counts = folder / "counts.json"
    if wanted.resume and counts.exists():
        for counter, kept in zip((executions, times, findings), json.loads(counts.read_text())):
            counter.update(kept)
    names = [name for pattern in wanted.targets
             for name in build(source, folder, wanted.clang, pattern, "plain" if wanted.plain else "sanitized")]
    began = time.time()

    # the turns; a record is there at any time, in case the run is stopped
    while time.time() - began < wanted.seconds:
        for name in names:
            left = wanted.seconds - (time.time() - began)
            if left < 1:
                break
            start = processor_time()
            count, stopped = turn(source, folder, name, int(min(wanted.turn, left)) or 1, wanted.max_len)
            executions[name] += count
            times[name] += processor_time() - start
            findings[name] += stopped
            if stopped:
                print(f"{name}: a finding, see {folder}/{name}.log", flush=True)
            counts.write_text(json.dumps([executions, times, findings]))
            if wanted.record:
                wanted.record.write_text(report(executions, times, findings, None))

    lines = covered_lines(source, wanted.build.resolve() / "fuzz_covered", wanted.clang, names, folder)
    text = report(executions, times, findings, lines)
    if lines is None:
        text += "\nllvm-profdata and llvm-cov are not installed, so no lines were counted.\n"
    if wanted.record:
        wanted.record.write_text(text)
    print(text, end="")
    sys.exit(1 if sum(findings.values()) else 0)


if __name__ == "__main__":
    main()
