#!/usr/bin/env python3
"""Mutation of the runtime: small faults are put into its sources one at a time, and the tests of the
runtime and of scenes must notice. One that no test notices has survived: it is a line that a test is
missing for, or a change that makes no difference.

  sign        a + b -> a - b, a += b -> a -= b, -a -> +a, a * b -> a / b
  index       x[i] -> x[i + 1], x[i - 1]
  comparison  < and <=, > and >= exchanged, == and != exchanged, && and || exchanged
  constant    0 -> 1, 1 -> 0, another number doubled

Left out are macros, since tuned constants are no truths (docs/tuning.md has what each does), the
text of messages, and kernels of processors that this machine is not. A mutant whose object code is
that of the original is not counted, nor one that does not compile.

Each mutant costs one compilation with -O1, one link of a shared library, and the tests up to the
first that fails: those of the same name first, then short ones of the same folder, then all other short ones,
then the rest. A test that takes three times the processor time it takes without a fault
has noticed too. It never writes to the sources.

A row of mutants.tsv has the place, the kind, the replacement, the outcome, the test that noticed
or the reason, and the line. A person may turn `survived` into `equivalent` and give the reason why
no test can notice: such a mutant is not tried again, and is not counted. mutants.tsv beside this
script is such a list; its mutants are found again by the text of their lines when sources change.

usage: mutate.py BUILD OUT [--count N] [--seed N] [--only TEXT] [--list FILE | --again]
                 [--seconds S] [--jobs N] [--near S]

  BUILD      a release build with tests (its objects of the tests are used)
  OUT        folder for the results: mutants.tsv with a row each, to which a later call adds
  --count    how many mutants are drawn at most, evenly over all that there are (default 300)
  --seed     of the draw (default 1)
  --only     only files whose path contains this
  --list     draws nothing: tries the mutants of FILE that are not equivalent, each with the test
             that noticed it first
  --again    draws nothing: tries those of mutants.tsv that survived once more
  --seconds  starts no mutant after so much time
  --jobs     mutants at a time (default 1)
  --near     only the nearest tests, of so many processor seconds together, without a fault; what
             survives these is tried again by --again without it

SPDX-License-Identifier: Apache-2.0
"""
import argparse
import concurrent.futures
import glob
import hashlib
import json
import os
import random
import re
import resource
import shlex
import shutil
import subprocess
import sys
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# of the runtime, of scenes, and those of other libraries whose subject lies in core/base
TESTS = ("core/*/test_*.c", "runtime/*/test_*.c", "contact/test_*.c", "scene/test_*.c", "precompute/test_quadratic_*.c")
# measured in processor time without a fault; longer tests say little more for what they cost
LONGEST_TEST = 15.0
# this test counts the library's allocations by wrapping symbols that a shared library keeps
NOT_SHARED = {"test_allocation"}
FOREIGN_KERNELS = ("neon", "wasm")
UNTRIED = "not-tried"

# what is no code: comments, strings, preprocessor lines
NO_CODE = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|'
                     r'^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', re.S | re.M)
COMPARISONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||",
               "||": "&&"}
OPERAND = r'[\w\)\]]'


def blank_no_code(text):
    """The text with everything that is no code replaced by spaces of the same length."""
    return NO_CODE.sub(lambda m: re.sub(r'[^\n]', ' ', m.group()), text)


def sites(text):
    """All mutations of a source: (kind, start, end, replacement)."""
    code = blank_no_code(text)
    found = []
    # clang-format sets binary operators in spaces, and unary ones beside their operand
    for m in re.finditer(r'(?<=%s) ([-+*]) (?=\S)' % OPERAND, code):
        other = {"+": " - ", "-": " + ", "*": " / "}[m.group(1)]
        found.append(("sign", m.start(), m.end(), other))
    for m in re.finditer(r' ([-+])= ', code):
        found.append(("sign", m.start(), m.end(), " -= " if m.group(1) == "+" else " += "))
    for m in re.finditer(r'(?<=[(,=?:] )-(?=[\w(])|(?<=\()-(?=[\w(])|(?<=return )-(?=[\w(])', code):
        found.append(("sign", m.start(), m.end(), "+"))
    for m in re.finditer(r' (<=|>=|==|!=|<|>|&&|\|\|) ', code):
        found.append(("comparison", m.start(), m.end(), " %s " % COMPARISONS[m.group(1)]))

    # an index that is read or written, not the length of an array that is declared
    declared = re.compile(r'\b(?:double|float|int|int32_t|int64_t|char|size_t|bool|uint8_t|'
                          r'uint32_t|uint64_t)\s[^;{}()=]*$')
    for m in re.finditer(r'(?<=%s)\[([^\[\]\n]+)\]' % OPERAND, code):
        line = code[code.rfind("\n", 0, m.start()) + 1:m.start()]
        if declared.search(line) and "=" not in line and "(" not in line:
            continue
        for change in (" + 1", " - 1"):
            found.append(("index", m.start(), m.end(), "[%s%s]" % (m.group(1), change)))

    for m in re.finditer(r'(?<![\w.\]])(\d+\.\d*(?:e[-+]?\d+)?|\d+)(?![\w.])', code):
        line = code[code.rfind("\n", 0, m.start()) + 1:m.start()]
        if declared.search(line) and line.rstrip().endswith("["):
            continue
        value, number = m.group(1), float(m.group(1))
        real = "." in value or "e" in value
        new = ("1.0" if real else "1") if number == 0 else ("0.0" if real else "0") if number == 1 \
            else "(2%s * %s)" % (".0" if real else "", value)
        found.append(("constant", m.start(), m.end(), new))
    return [s for s in found if in_function(code, s[1])]


def in_function(code, at):
    """Whether a position is inside braces that begin at the start of a line, as functions do."""
    before = code.rfind("\n}", 0, at)
    return re.search(r'\)\s*\{\s*\n', code[before + 1:at]) is not None


def run(command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace", **options)


class Bench:
    """The objects of the library without a fault, and tests that are linked to a shared one."""

    def __init__(self, build, work):
        self.build = os.path.abspath(build)
        self.work = os.path.abspath(work)
        os.makedirs(self.work, exist_ok=True)
        self.commands, self.objects, self.deps = {}, {}, {}
        self.passed = set()
        self.lock = threading.Lock()
        with open(os.path.join(self.build, "compile_commands.json"), encoding="utf-8") as file:
            rows = json.load(file)
        for row in rows:
            path = os.path.relpath(row["file"], ROOT)
            if path.startswith(("core/", "runtime/", "contact/")) and re.search("thrum_(objects|contact).dir", row["command"]):
                self.commands[path] = self.compiler(shlex.split(row["command"]))

    @staticmethod
    def compiler(words):
        """The command without its launcher, output and warnings, for a shared library at -O1."""
        words = words[next(i for i, w in enumerate(words) if re.search(r'(gcc|clang|cc)$', w)):]
        kept = [w for w in words if not w.startswith(("-W", "-O", "-g", "-fvisibility"))]
        for flag in ("-o", "-c"):
            at = kept.index(flag)
            del kept[at:at + 2]
        return kept + ["-O1", "-w", "-fno-semantic-interposition"]

    def compile(self, path, source, output):
        return run(self.commands[path] + ["-iquote", os.path.dirname(os.path.join(ROOT, path)),
                                          "-c", source, "-o", output])

    def link(self, objects, output):
        return run(["gcc", "-shared", "-Wl,-soname,libthrum_mutant.so", "-o", output] + objects +
                   ["-lm"])

    def prepare(self):
        """Objects, the library, and the tests; returns {test: processor seconds}.

        Objects that an earlier call made of the same sources are taken from the folder, and times
        that it measured are kept."""
        kept = os.path.join(self.work, "prepared.json")
        state = hashlib.sha256()
        for path in sorted(glob.glob(os.path.join(ROOT, "core/*/*")) +
                           glob.glob(os.path.join(ROOT, "runtime/*/*")) +
                           glob.glob(os.path.join(ROOT, "contact/*"))):
            with open(path, "rb") as file:
                state.update(file.read())
        found = {}
        if os.path.exists(kept):
            with open(kept, encoding="utf-8") as file:
                found = json.load(file)
        if found.get("state") == state.hexdigest():
            self.objects, self.deps = found["objects"], found["deps"]
        else:
            self.make_objects()
        seconds = self.make_tests(found.get("seconds", {}))
        with open(kept, "w", encoding="utf-8") as file:
            json.dump({"state": state.hexdigest(), "objects": self.objects, "deps": self.deps,
                       "seconds": seconds}, file)
        return {name: spent for name, spent in seconds.items() if spent <= LONGEST_TEST}

    def make_objects(self):
        """Compiles the library without a fault, and notes which parts each source includes."""
        for path in sorted(self.commands):
            output = os.path.join(self.work, path.replace("/", "_") + ".o")
            done = self.compile(path, os.path.join(ROOT, path), output)
            if done.returncode != 0:
                sys.exit("%s does not compile:\n%s" % (path, done.stdout))
            self.objects[path] = output
            listed = run(self.commands[path] + ["-MM", os.path.join(ROOT, path)]).stdout
            self.deps[path] = [os.path.relpath(w, ROOT) for w in listed.replace("\\\n", " ").split()
                               if w.endswith(".inl")]
        self.link(list(self.objects.values()), os.path.join(self.work, "libthrum_mutant.so"))

    def make_tests(self, known):
        """Links all tests that are new, and measures those that are not `known`; {test: seconds}."""
        seconds, self.where = {}, {}
        for source in sum((glob.glob(os.path.join(ROOT, "tests", p)) for p in TESTS), []):
            name = os.path.basename(source)[:-2]
            if name in NOT_SHARED:
                continue
            self.where[name] = os.path.relpath(os.path.dirname(source), os.path.join(ROOT, "tests"))
            built = os.path.getmtime(os.path.join(self.build, "tests", name))
            linked = os.path.join(self.work, name)
            if not os.path.exists(linked) or os.path.getmtime(linked) < built:
                self.link_test(name)
            if name in known:
                seconds[name] = known[name]
            else:
                ok, seconds[name] = self.test(name, self.work, 600)
                if not ok:
                    sys.exit("%s fails without a fault" % name)
                self.passed.add(name)
        return seconds

    def must_pass(self, name):
        """Ends the program where a test fails without a fault; each is tried once."""
        if name not in self.passed and not self.test(name, self.work, 600)[0]:
            sys.exit("%s fails without a fault" % name)
        self.passed.add(name)

    def link_test(self, name):
        """Links a test of the build to the shared library."""
        library = os.path.join(self.work, "libthrum_mutant.so")
        lines = run(["ninja", "-C", self.build, "-t", "commands", name]).stdout.splitlines()
        link = next(line for line in reversed(lines) if " -o tests/%s " % name in line)
        link = link.replace(" && :", "").replace(": && ", "")
        link = link.replace("-o tests/%s " % name, "-o %s/%s " % (self.work, name))
        link = re.sub(r'\blibthrum\.a\b', library, link)
        done = run(link, shell=True, cwd=self.build)
        if done.returncode != 0:
            sys.exit("%s does not link:\n%s" % (name, done.stdout))

    def test(self, name, folder, limit):
        """Whether a test passes with the library of that folder, and its processor seconds."""
        def limits():
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
        before = time.monotonic()
        environment = dict(os.environ, LD_LIBRARY_PATH=folder)
        scratch = os.path.join(folder, "scratch")
        shutil.rmtree(scratch, ignore_errors=True)
        os.makedirs(scratch)
        environment["TMPDIR"] = scratch
        process = subprocess.Popen([os.path.join(self.work, name)], cwd=scratch, env=environment,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   stdin=subprocess.DEVNULL, preexec_fn=limits)
        # one that sleeps for ever uses no processor time
        timer = threading.Timer(20 * limit + 60, process.kill)
        timer.start()
        _, code, usage = os.wait4(process.pid, 0)
        timer.cancel()
        process.returncode = code
        return code == 0, usage.ru_utime + usage.ru_stime if code == 0 else time.monotonic() - before


def order(bench, seconds, path):
    """The tests for a mutant of a source: those with its name, of its folder, the rest."""
    folder = os.path.dirname(path)
    stem = os.path.splitext(os.path.basename(path))[0]
    def rank(name):
        same_word, same_folder = stem.split("_")[0] in name, bench.where[name] == folder
        # a test of a second is soon run whatever it is about
        near = 0 if stem in name else 1 if (same_word or same_folder) and seconds[name] < 2 \
            else 2 if seconds[name] < 1 else 3 if same_word or same_folder else 4
        return (near, seconds[name])
    return sorted(seconds, key=rank)


def try_mutant(bench, seconds, mutant, slot, near, first):
    """What came of a mutant: (outcome, test that noticed); the test `first` before all others."""
    path, _, start, end, new, text = mutant
    folder = os.path.join(bench.work, "slot%d" % slot)
    os.makedirs(folder, exist_ok=True)
    changed = text[:start] + new + text[end:]

    # a part that kernels include is compiled with those that this machine runs
    units = [path] if path.endswith(".c") else \
        [c for c, parts in bench.deps.items() if path in parts and
         not any(k in c for k in FOREIGN_KERNELS)]
    objects, same = dict(bench.objects), True
    for unit in units:
        source = os.path.join(folder, os.path.basename(unit))
        if unit == path:
            body = changed
        else:
            with open(os.path.join(ROOT, unit), encoding="utf-8") as file:
                body = file.read()
            inserted = os.path.join(folder, os.path.basename(path))
            with open(inserted, "w", encoding="utf-8") as file:
                file.write(changed)
            body = body.replace('"%s"' % path, '"%s"' % inserted)
            body, nested = replace_nested(body, path, inserted, folder)
            same = same and not nested
        with open(source, "w", encoding="utf-8") as file:
            file.write(body)
        output = source + ".o"
        if bench.compile(unit, source, output).returncode != 0:
            return "no-compile", ""
        with open(output, "rb") as a, open(bench.objects[unit], "rb") as b:
            same = same and code_of(output) == code_of(bench.objects[unit])
        objects[unit] = output
    if same:
        return "same-code", ""
    bench.link(list(objects.values()), os.path.join(folder, "libthrum_mutant.so"))
    spent = 0.0
    names = sorted(order(bench, seconds, path), key=lambda name: name != first)
    for name in names:
        spent += seconds[name]
        if spent > near and name != names[0]:
            break
        passed, _ = bench.test(name, folder, 3 * seconds[name] + 2)
        if not passed:
            bench.must_pass(name)
            return "killed", name
    return "survived", ""


def replace_nested(body, path, inserted, folder):
    """Copies included parts that include the changed one themselves, so that all see the change."""
    nested = False
    for part in re.findall(r'#include "((?:core|runtime)/[^"]+\.inl)"', body):
        with open(os.path.join(ROOT, part), encoding="utf-8") as file:
            inner = file.read()
        if '"%s"' % path in inner:
            copy = os.path.join(folder, "nested_" + os.path.basename(part))
            with open(copy, "w", encoding="utf-8") as file:
                file.write(inner.replace('"%s"' % path, '"%s"' % inserted))
            body = body.replace('"%s"' % part, '"%s"' % copy)
    return body, nested


def code_of(path):
    """Instructions and constants of an object, without what names its source."""
    out = run(["objdump", "-s", "-r", "-j", ".text", "-j", ".rodata", "-j", ".rodata.cst8", "-j",
               ".rodata.cst16", "-j", ".rodata.cst32", "-j", ".rodata.cst4", path]).stdout
    return out.split("\n", 3)[-1]


def draw(options):
    """The mutants that are tried: (path, kind, start, end, replacement, text)."""
    everything = []
    paths = sorted(glob.glob(os.path.join(ROOT, "core/*/*.c")) +
                   glob.glob(os.path.join(ROOT, "runtime/*/*.c")) +
                   glob.glob(os.path.join(ROOT, "contact/*.c")) +
                   glob.glob(os.path.join(ROOT, "runtime/*/*.inl")))
    for full in paths:
        path = os.path.relpath(full, ROOT)
        if any(k in path for k in FOREIGN_KERNELS) or options.only not in path:
            continue
        with open(full, encoding="utf-8") as file:
            text = file.read()
        for kind, start, end, new in sites(text):
            everything.append((path, kind, start, end, new, text))
    random.Random(options.seed).shuffle(everything)
    return everything


def key_of(mutant):
    path, kind, start, _, new, text = mutant
    line = text.count("\n", 0, start) + 1
    column = start - text.rfind("\n", 0, start)
    return "%s:%d:%d\t%s\t%s" % (path, line, column, kind, new.strip())


def source_line(mutant):
    text, start = mutant[5], mutant[2]
    begin = text.rfind("\n", 0, start) + 1
    return text[begin:text.find("\n", start)].strip()


def find_again(rows, mutants):
    """The mutants of these rows: {row's number: mutant}. Where the same line stands in a file more
    than once, the nearest to the row's place is meant."""
    at = {}
    for mutant in mutants:
        place, kind, new = key_of(mutant).split("\t")
        path, line, column = place.split(":")
        at.setdefault((path, column, kind, new, source_line(mutant)), []).append(
            (int(line), mutant))
    found = {}
    for number, (place, kind, new, _, _, text) in enumerate(rows):
        path, line, column = place.split(":")
        places = at.get((path, column, kind, new, text))
        if places is None:
            print("%s is there no more: %s" % (place, text))
        else:
            found[number] = min(places, key=lambda p, line=line: abs(p[0] - int(line)))[1]
    return found


def read_rows(path):
    with open(path, encoding="utf-8") as file:
        return [line.rstrip("\n").split("\t") for line in file]


def write_rows(path, rows):
    with open(path, "w", encoding="utf-8") as file:
        file.writelines("\t".join(r) + "\n" for r in rows)


def summary(rows, total):
    """The table of the record."""
    print("%d mutants are possible, %d were tried" % (total, len(rows)))
    kinds = ("sign", "index", "comparison", "constant")
    print("| | killed | survived | share killed | equivalent | same code | do not compile |")
    print("|---|---|---|---|---|---|---|")
    for name, part in [(k, [r for r in rows if r[1] == k]) for k in kinds] + [("all", rows)]:
        count = {o: sum(r[3] == o for r in part)
                 for o in ("killed", "survived", "equivalent", "same-code", "no-compile")}
        tried = count["killed"] + count["survived"]
        print("| %s | %d | %d | %s | %d | %d | %d |" % (
            name, count["killed"], count["survived"],
            "%.1f %%" % (100 * count["killed"] / tried) if tried else "-", count["equivalent"],
            count["same-code"], count["no-compile"]))


def read_options():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("build")
    parser.add_argument("out")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--list")
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--seconds", type=float, default=1e9)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--near", type=float, default=1e9)
    return parser.parse_args()


def choose(options, rows, everything):
    """Which mutants are tried, each with the test that is to be first, and all rows by key."""
    listed = read_rows(options.list) if options.list else rows
    known = {} if options.again else {"\t".join(r[:3]): r for r in rows}
    if not options.list and not options.again:
        drawn = everything[:options.count]
        return [(m, "") for m in drawn if key_of(m) not in known], known

    # rows move with their lines; one of a list says nothing yet
    chosen = []
    for number, mutant in find_again(listed, everything).items():
        row, key = list(listed[number]), key_of(mutant)
        if known.get(key, ["", "", "", UNTRIED])[3] != UNTRIED:
            continue
        if row[3] == "survived" or options.list and row[3] != "equivalent":
            chosen.append((mutant, row[4]))
            row[3] = row[3] if options.again else UNTRIED
        known[key] = key.split("\t") + row[3:]
    return chosen, known


def main():
    options = read_options()
    os.makedirs(options.out, exist_ok=True)
    record = os.path.join(options.out, "mutants.tsv")

    # those of an earlier call are not tried again, or are all that is
    everything = draw(options)
    rows = read_rows(record) if os.path.exists(record) else []
    mutants, rows = choose(options, rows, everything)

    bench = Bench(options.build, os.path.join(options.out, "work"))
    seconds = bench.prepare()
    print("%d tests, %.0f s of processor time; %d mutants" % (len(seconds), sum(seconds.values()),
                                                              len(mutants)), flush=True)
    end = time.monotonic() + options.seconds
    free = list(range(options.jobs))

    def one(chosen):
        if time.monotonic() > end:
            return
        mutant, first = chosen
        with bench.lock:
            slot = free.pop()
        outcome, test = try_mutant(bench, seconds, mutant, slot, options.near, first)
        row = key_of(mutant).split("\t") + [outcome, test, source_line(mutant)]
        with bench.lock:
            free.append(slot)
            rows[key_of(mutant)] = row
            write_rows(record, rows.values())
        if outcome == "survived":
            print("\t".join(row), flush=True)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(one, mutants))
    summary(list(rows.values()), len(everything))
    return 0


if __name__ == "__main__":
    sys.exit(main())
