#!/usr/bin/env python3
"""Line and branch coverage of a build with gcov, a row for each folder, and what is not covered.

A branch is one of the two ways that the compiler can go at a condition, each part of && and || on
its own. What a header or an .inl file brings into many functions counts once. A branch is covered when any program of the build has gone that way: tests, the program
that tests run, also with injected failures of allocations (tests/faults).

Branches that no test took are sorted by what stands in their line:

  memory    an allocation that fails; tests/faults makes every n-th fail in turn, in samples
  pass on   a status of a call passed on to the caller, THRUM_TRY and the like: the failure of a
            callee, whose own test is where it arises
  other     everything else: listed by file and function

usage: coverage.py BUILD [--list FILE] [--least FOLDER=PERCENT ...]

  BUILD    a folder configured with --coverage, in which tests have run
  --list   writes what is not covered, sorted by reason
  --least  fails when the branches of a folder, memory and pass on apart, are covered by less

SPDX-License-Identifier: Apache-2.0
"""
import argparse
import collections
import concurrent.futures
import gzip
import json
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDERS = ("core", "runtime", "contact", "scene", "platform", "io", "mesh", "precompute", "config", "driver",
           "validation", "bench", "app")
MEMORY = re.compile(r'alloc|memory|OUT_OF_MEMORY|== NULL|!= NULL|\bneed\(')
PASS_ON = re.compile(r'THRUM_TRY|THRUM_THEN|MUST\(|status|>= 0|< 0 *\)|\bmade\b|\bfine\b')


def data_of(path):
    """What gcov says of one object: [(source, function, line, [branch counts], line count)]."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["gcov", "--json-format", "--branch-probabilities", path], cwd=folder,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        rows = []
        for name in os.listdir(folder):
            with gzip.open(os.path.join(folder, name), "rt", encoding="utf-8") as file:
                said = json.load(file)
            for source in said["files"]:
                full = os.path.normpath(os.path.join(said["current_working_directory"],
                                                     source["file"]))
                where = os.path.relpath(full, ROOT)
                if where.split(os.sep)[0] in FOLDERS:
                    rows += [(where, line.get("function_name", ""), line["line_number"],
                              [b["count"] for b in line["branches"]], line["count"])
                             for line in source["lines"]]
    return rows


def collect(build):
    """The sums over all objects: {(source, function, line, number): count}, and of lines."""
    paths = [os.path.join(folder, name) for folder, _, names in os.walk(os.path.abspath(build)) for name in names
             if name.endswith(".gcda")]
    branches, lines = collections.Counter(), collections.Counter()
    parts = collections.defaultdict(list)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for rows in pool.map(data_of, paths):
            for source, function, line, counts, count in rows:
                lines[source, line] += count
                if source.endswith(".c"):
                    for number, taken in enumerate(counts):
                        branches[source, function, line, number] += taken
                elif counts:
                    parts[source, line].append(counts)

    # a part that is compiled many times, with other constants, has its branches in the source once
    for (source, line), lists in parts.items():
        period = min(len(counts) for counts in lists)
        for counts in lists:
            for number, taken in enumerate(counts):
                branches[source, "", line, number % period] += taken
    return branches, lines


def reason(text):
    if MEMORY.search(text):
        return "memory"
    return "pass on" if PASS_ON.search(text) else "other"


def share(part, all_of):
    return "%.1f %%" % (100 * part / all_of) if all_of else "-"


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("build")
    parser.add_argument("--list")
    parser.add_argument("--least", action="append", default=[])
    options = parser.parse_args()
    branches, lines = collect(options.build)
    if not branches:
        sys.exit("%s holds no counts: configure with --coverage and run the tests" % options.build)

    # what is not covered, with its reason
    texts, missed = {}, collections.defaultdict(list)
    for key, count in sorted(branches.items()):
        source, _, line, _ = key
        if source not in texts:
            with open(os.path.join(ROOT, source), encoding="utf-8") as file:
                texts[source] = [""] + file.read().splitlines()
        if count == 0:
            missed[reason(texts[source][line])].append(key)

    # a row each for the folders of the runtime, the others, and what is asked of them
    groups = collections.OrderedDict()
    for source in sorted(texts):
        top = source.split(os.sep)[0]
        groups.setdefault(top, set()).add(source)
        if top in ("core", "runtime", "precompute", "validation", "app"):
            groups.setdefault(os.path.dirname(source), set()).add(source)
    groups["all"] = set(texts)
    groups["all but core, runtime and contact"] = {s for s in texts if not s.startswith(("core/", "runtime/", "contact/"))}
    print("| folder | lines | branches | not taken: memory | pass on | other "
          "| branches, the first two apart |")
    print("|---|---|---|---|---|---|---|")
    shares = {}
    for name, sources in groups.items():
        own = [c for k, c in branches.items() if k[0] in sources]
        own_lines = [c for k, c in lines.items() if k[0] in sources]
        left = {r: sum(k[0] in sources for k in missed[r]) for r in ("memory", "pass on", "other")}
        taken = sum(c > 0 for c in own)
        shares[name] = 100 * taken / max(1, taken + left["other"])
        print("| %s | %s of %d | %s of %d | %d | %d | %d | %s |" % (
            name, share(sum(c > 0 for c in own_lines), len(own_lines)), len(own_lines),
            share(taken, len(own)), len(own), left["memory"], left["pass on"], left["other"],
            share(taken, taken + left["other"])))

    if options.list:
        with open(options.list, "w", encoding="utf-8") as file:
            for why in ("other", "pass on", "memory"):
                file.write("# %s\n" % why)
                # functions keep their names where lines move
                for source, line, function in sorted({(k[0], k[2], k[1]) for k in missed[why]}):
                    file.write("%s %s: %s\n" % (source, function, texts[source][line].strip()))
    wrong = [w for w in options.least if shares.get(w.split("=")[0], 0) < float(w.split("=")[1])]
    for want in wrong:
        print("less than asked: %s" % want, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
