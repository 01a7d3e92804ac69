#!/usr/bin/env python3
"""Static analysis of everything but the tests, by cppcheck and by gcc -fanalyzer.

Each finding has an answer in answered.txt beside this script, or fails: a line

  TOOL FILE IDENTIFIER: why it is none, or is left

where IDENTIFIER is that of the tool (uninitvar, -Wanalyzer-malloc-leak) and FILE the path in the
tree. An answer that no finding needs any more fails too. clang-tidy, which ./run test runs with
.clang-tidy, has its answers there.

usage: analyze.py BUILD [cppcheck|gcc]

  BUILD  a release build folder by gcc, for its compile_commands.json

SPDX-License-Identifier: Apache-2.0
"""
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
FOLDERS = ("core", "runtime", "contact", "scene", "platform", "io", "mesh", "precompute", "config", "driver",
           "validation", "bench", "app", "examples", "mpi")
# sources that a build by gcc does not compile: those of the pages, which are WebAssembly, what the
# relocatable tarball adds, and thrum-mpi in a build without it
BESIDE = ("javascript", "viewer", "packaging", "mpi")
MPI_PACKAGES = ("slepc", "petsc", "mpi-c")
# gcc 12 takes a loop over three axes to end after the first, and finds the others unset; what is
# unset in truth -Wmaybe-uninitialized says, as an error, in each build. Attributes of WebAssembly
# are none of this processor's
OFF = ("-Wno-analyzer-use-of-uninitialized-value", "-Wno-attributes")
# a file that takes longer has too many paths; it is named
SECONDS = 600


def commands_of(build):
    """{source in the tree: (arguments of the compiler, folder)} without tests."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        rows = json.load(file)
    found = {}
    for row in rows:
        path = os.path.relpath(row["file"], ROOT)
        if path.split(os.sep)[0] in FOLDERS:
            words = shlex.split(row["command"])
            start = next(i for i, w in enumerate(words) if re.search(r"(gcc|cc)$", w))
            found.setdefault(path, (words[start:], row["directory"]))
    gone = [path for path in found if not os.path.exists(os.path.join(ROOT, path))]
    if gone:
        sys.exit("%s: %s is there no more: configure and build it anew" % (build, gone[0]))
    add_beside(found)
    return found


def add_beside(found):
    """Adds the sources of BESIDE that the build has no command for, with plain ones of gcc."""
    flags = ["-I" + ROOT, "-I" + os.path.join(ROOT, "include"), "-std=c11",
             "-D_POSIX_C_SOURCE=200809L"]
    mpi = subprocess.run(["pkg-config", "--cflags", *MPI_PACKAGES], capture_output=True, text=True,
                         check=False)

    # what git tracks, so that nothing of a build folder is met
    tracked = subprocess.run(["git", "-C", ROOT, "ls-files", "*.c"], capture_output=True,
                             text=True, check=True).stdout.split()
    for path in tracked:
        folder = path.split("/")[0]
        if folder not in BESIDE or path in found:
            continue
        if folder == "mpi" and mpi.returncode != 0:
            print("%s is left out: its libraries are not installed" % path)
            continue
        more = shlex.split(mpi.stdout) if folder == "mpi" else []
        found[path] = (["gcc", *flags, *more, "-o", os.devnull, "-c", os.path.join(ROOT, path)],
                       ROOT)


def by_cppcheck(commands):
    """Findings of cppcheck: {(file, identifier): message}."""
    # it need not know the headers of libraries, nor those that a build writes, such as a model as
    # an array: for one of these it takes longer than for all sources together
    own = {"-I" + ROOT, "-I" + os.path.join(ROOT, "include")}
    commands = {p: ([x for x in w if not x.startswith("-I") or x in own], d)
                for p, (w, d) in commands.items()}
    with tempfile.TemporaryDirectory() as folder:
        project = os.path.join(folder, "commands.json")
        with open(project, "w", encoding="utf-8") as file:
            json.dump([{"file": os.path.join(ROOT, p), "directory": d,
                        "arguments": w, "command": shlex.join(w)}
                       for p, (w, d) in commands.items()], file)
        said = subprocess.run(
            ["cppcheck", "--project=" + project, "--enable=warning,performance,portability",
             "--quiet", "--std=c11", "-j", str(os.cpu_count()), "--inline-suppr",
             "--template={file}\t{line}\t{id}\t{message}", "--suppress=missingIncludeSystem"],
            stderr=subprocess.PIPE, text=True, cwd=ROOT, check=False).stderr
    found = {}
    for line in said.splitlines():
        # such as a source that is there no more: what is not read has no findings
        if line.startswith("cppcheck: error"):
            sys.exit(line + "\nconfigure and build %s anew" % sys.argv[1])
        parts = line.split("\t")
        if len(parts) == 4:
            path = os.path.relpath(os.path.join(ROOT, parts[0]), ROOT)
            found[path, parts[2]] = "%s:%s: %s" % (path, parts[1], parts[3])
    return found


def analyse(path, words, folder):
    """What gcc -fanalyzer says of one source."""
    words = list(words)
    at = words.index("-o")
    del words[at:at + 2]
    words = [w for w in words if not w.startswith(("-O", "-W"))]
    # but where the function itself is defined
    if path != "core/base/status.c":
        words += ["-I" + os.path.join(ROOT, "include"), "-include",
                  os.path.join(HERE, "error_set.h")]
    command = words + ["-O1", "-fanalyzer", *OFF, "-o", os.devnull, "-fdiagnostics-path-format=none"]
    try:
        return subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, timeout=SECONDS,
                              check=False).stderr
    except subprocess.TimeoutExpired:
        return "%s:1:1: warning: not analysed in %d s [-Wanalyzer-too-complex]" % (
            os.path.join(ROOT, path), SECONDS)


def by_gcc(commands):
    """Findings of gcc: {(file, identifier): message}."""
    found = {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for said in pool.map(lambda c: analyse(c[0], *c[1]), commands.items()):
            for m in re.finditer(r"^(/[^:\n]+):(\d+):\d+: warning: (.*) \[(-W[\w-]+)\]$", said,
                                 re.M):
                path = os.path.relpath(m.group(1), ROOT)
                found[path, m.group(4)] = "%s:%s: %s" % (path, m.group(2), m.group(3))
    return found


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    commands = commands_of(sys.argv[1])
    answers = {}
    with open(os.path.join(HERE, "answered.txt"), encoding="utf-8") as file:
        for line in file:
            m = re.match(r"(cppcheck|gcc) (\S+) (\S+): (.+)", line)
            if m:
                answers[m.groups()[:3]] = m.group(4)
    wrong = 0
    for tool, run in (("cppcheck", by_cppcheck), ("gcc", by_gcc)):
        if len(sys.argv) == 3 and sys.argv[2] != tool:
            continue
        found = {(tool,) + key: text for key, text in run(commands).items()}
        for key, text in sorted(found.items()):
            if key not in answers:
                print("%s: %s [%s]" % (tool, text, key[2]))
                wrong += 1
        for key in sorted(k for k in answers if k[0] == tool and k not in found):
            print("%s: the answer to %s in %s is needed no more" % (tool, key[2], key[1]))
            wrong += 1
        print("%s: %d sources, %d findings, %d answered" % (
            tool, len(commands), len(found), sum(k in answers for k in found)))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
