#!/usr/bin/env python3
"""Mutation: small faults are put into the sources one at a time, and the nearest tests must notice. One
that no test notices has survived: it is a line that a test is missing for, or a change that makes no
difference.

  sign        a + b -> a - b, a += b -> a -= b, -a -> +a, a * b -> a / b
  index       x[i] -> x[i + 1], x[i - 1]
  comparison  < and <=, > and >= exchanged, == and != exchanged, && and || exchanged
  constant    0 -> 1, 1 -> 0, another number doubled

The sources are core, runtime, contact, scene and precompute. Left out are macros, since tuned constants
are no truths (docs/tuning.md has what each does), the text of messages, and kernels of processors that
this machine is not. A mutant whose object code is that of the original is not counted, nor one that does
not compile.

Each mutant costs one compilation with -O1, and a link and a run of the tests up to the first that fails:
those of the same name first, those that noticed another fault of the file, then short ones of the same
folder, then all other short ones, then the rest. A test that takes three times the processor time it
takes without a fault has noticed too. It never writes to the sources.

A row of mutants.tsv has the place, the kind, the replacement, the outcome, the test that noticed
or the reason, and the line. A person may turn `survived` into `equivalent` and give the reason why
no test can notice: such a mutant is not tried again, and is not counted. mutants.tsv beside this
script is such a list; its mutants are found again by the text of their lines when sources change.

usage: mutate.py BUILD OUT [--count N] [--each N] [--seed N] [--only TEXT ...] [--list FILE | --again]
                 [--seconds S] [--jobs N] [--near S]

  BUILD      a release build with tests (its objects and libraries are used)
  OUT        folder for the results: mutants.tsv with a row each, to which a later call adds
  --count    how many mutants are drawn at most, evenly over all that there are (default 300)
  --each     so many of each file at most instead
  --seed     of the draw (default 1)
  --only     only files whose path contains one of these
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
# whose tests are run, and what of a source may be mutated
TESTS = ("core/*/test_*.c", "runtime/*/test_*.c", "contact/test_*.c", "scene/test_*.c", "precompute/test_*.c")
SOURCES = ("core/*/*.c", "runtime/*/*.c", "runtime/*/*.inl", "contact/*.c", "scene/*.c", "precompute/*.c",
           "precompute/*/*.c")
OBJECTS = re.compile(r"/thrum(_objects|_contact|_scene_objects|_precompute)\.dir/")
# measured in processor time without a fault; longer tests say little more for what they cost
LONGEST_TEST = 15.0
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
        if declared.search(line) and "=" not in line and "(" not in line or code.startswith(" = {", m.end()):
            continue
        for change in (" + 1", " - 1"):
            found.append(("index", m.start(), m.end(), "[%s%s]" % (m.group(1), change)))

    for m in re.finditer(r'(?<![\w.\]])(\d+\.\d*(?:e[-+]?\d+)?|\d+)(?![\w.])', code):
        line = code[code.rfind("\n", 0, m.start()) + 1:m.start()]
        if line.rstrip().endswith("[") and (declared.search(line) or code.startswith("] = {", m.end())):
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
    """How sources are compiled and tests are linked: a mutant's object stands before the libraries, which are those of the
    build, so that theirs is left out."""

    def __init__(self, build, work):
        self.build = os.path.abspath(build)
        self.work = os.path.abspath(work)
        os.makedirs(self.work, exist_ok=True)
        self.commands, self.links, self.where, self.noticed, self.symbols = {}, {}, {}, {}, {}
        self.passed = set()
        self.lock = threading.Lock()
        with open(os.path.join(self.build, "compile_commands.json"), encoding="utf-8") as file:
            rows = json.load(file)
        for row in rows:
            path = os.path.relpath(row["file"], ROOT)
            if OBJECTS.search(row["command"]):
                self.commands[path] = self.compiler(shlex.split(row["command"]))

    @staticmethod
    def compiler(words):
        """The command without its launcher, output and warnings, at -O1."""
        words = words[next(i for i, w in enumerate(words) if re.search(r'(gcc|clang|cc)$', w)):]
        kept = [w for w in words if not w.startswith(("-W", "-O", "-g")) and "FORTIFY" not in w]
        for flag in ("-o", "-c"):
            at = kept.index(flag)
            del kept[at:at + 2]
        return kept + ["-O1", "-w"]

    def compile(self, path, source, output):
        return run(self.commands[path] + ["-iquote", os.path.dirname(os.path.join(ROOT, path)),
                                          "-c", source, "-o", output])

    def unchanged(self, path):
        """The object of a source without a fault, newer than it."""
        output = os.path.join(self.work, path.replace("/", "_") + ".o")
        source = os.path.join(ROOT, path)
        if not os.path.exists(output) or os.path.getmtime(output) < os.path.getmtime(source):
            done = self.compile(path, source, output)
            if done.returncode != 0:
                sys.exit("%s does not compile:\n%s" % (path, done.stdout))
        return output

    def users(self, part):
        """The sources that include a part, on this machine's processor."""
        if part.endswith(".c"):
            return [part]
        if not hasattr(self, "parts"):
            self.parts = {}
            for path in self.commands:
                listed = run(self.commands[path] + ["-MM", os.path.join(ROOT, path)]).stdout
                for word in listed.replace("\\\n", " ").split():
                    self.parts.setdefault(os.path.relpath(word, ROOT), []).append(path)
        return [c for c in self.parts.get(part, []) if not any(k in c for k in FOREIGN_KERNELS)]

    def concerns(self, name, objects):
        """Whether a test of the build has any function of these objects in it."""
        for path in [os.path.join(self.build, "tests", name)] + objects:
            if path not in self.symbols:
                rows = [line.split() for line in run(["nm", "--defined-only", path]).stdout.splitlines()]
                # what is hidden in a library is local in a program
                kinds = "TW" if path.endswith(".o") else "TWt"
                self.symbols[path] = {row[2] for row in rows if len(row) == 3 and row[1] in kinds}
        return any(self.symbols[os.path.join(self.build, "tests", name)] & self.symbols[o] for o in objects)

    def prepare(self):
        """Finds the tests, and measures those that an earlier call did not; {test: processor seconds}."""
        kept = os.path.join(self.work, "seconds.json")
        seconds = {}
        if os.path.exists(kept):
            with open(kept, encoding="utf-8") as file:
                seconds = json.load(file)
        for source in sum((glob.glob(os.path.join(ROOT, "tests", p)) for p in TESTS), []):
            name = os.path.basename(source)[:-2]
            self.where[name] = os.path.relpath(source, os.path.join(ROOT, "tests")).split("/")[0]
            if name not in seconds:
                ok, seconds[name] = self.test(os.path.join(self.build, "tests", name), self.work, 600)
                if not ok:
                    print("left out, as it fails without a fault: %s" % name, flush=True)
                    seconds[name] = 2 * LONGEST_TEST
                self.passed.add(name)
                with open(kept, "w", encoding="utf-8") as file:
                    json.dump(seconds, file)
        return {name: seconds[name] for name in self.where if seconds[name] <= LONGEST_TEST}

    def passes(self, name):
        """Whether a test passes without a fault; each is tried once."""
        if name not in self.passed and not self.test(os.path.join(self.build, "tests", name), self.work, 600)[0]:
            return False
        self.passed.add(name)
        return True

    def link(self, name, objects, folder):
        """Links a test of the build with these objects in place of the libraries'."""
        if name not in self.links:
            lines = run(["ninja", "-C", self.build, "-t", "commands", name]).stdout.splitlines()
            line = next(line for line in reversed(lines) if " -o tests/%s " % name in line)
            self.links[name] = line.replace(" && :", "").replace(": && ", "")
        output = os.path.join(folder, name)
        inserted = "%s -o %s " % (" ".join(map(shlex.quote, objects)), shlex.quote(output))
        done = run(self.links[name].replace("-o tests/%s " % name, inserted), shell=True, cwd=self.build)
        if done.returncode != 0:
            sys.exit("%s does not link:\n%s" % (name, done.stdout))
        return output

    @staticmethod
    def test(program, folder, limit):
        """Whether a test passes, run in a new folder inside of `folder`, and its processor seconds."""
        def limits():
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
        before = time.monotonic()
        scratch = os.path.join(folder, "scratch")
        shutil.rmtree(scratch, ignore_errors=True)
        os.makedirs(scratch)
        environment = dict(os.environ, TMPDIR=scratch, OPENBLAS_NUM_THREADS="1")
        with subprocess.Popen([program], cwd=scratch, env=environment, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL, preexec_fn=limits) as process:
            # one that sleeps for ever uses no processor time
            timer = threading.Timer(20 * limit + 60, process.kill)
            timer.start()
            _, code, usage = os.wait4(process.pid, 0)
            timer.cancel()
            process.returncode = code
        return code == 0, usage.ru_utime + usage.ru_stime if code == 0 else time.monotonic() - before


def order(bench, seconds, path, units):
    """The tests that have something of a mutant's sources in them: those with its name, of its folder, the rest."""
    folder = path.split("/")[0]
    stem = os.path.splitext(os.path.basename(path))[0]
    def rank(name):
        same_word, same_folder = stem.split("_")[0] in name, bench.where[name] == folder
        # a test of a tenth of a second is soon run whatever it is about
        near = 0 if (stem in name or (path, name) in bench.noticed) and seconds[name] < 2 \
            else 1 if seconds[name] < 0.2 else 2 if (same_word or same_folder) and seconds[name] < 2 \
            else 3 if seconds[name] < 1 else 4 if same_word or same_folder or stem in name else 5
        return (near, (seconds[name] + 0.1) / (1 + bench.noticed.get((path, name), 0)))
    objects = [bench.unchanged(unit) for unit in units]
    return sorted((name for name in seconds if bench.concerns(name, objects)), key=rank)


def try_mutant(bench, seconds, mutant, slot, near, first):
    """What came of a mutant: (outcome, test that noticed); the test `first` before all others."""
    path, _, start, end, new, text = mutant
    folder = os.path.join(bench.work, "slot%d" % slot)
    os.makedirs(folder, exist_ok=True)
    changed = text[:start] + new + text[end:]

    # a part that kernels include is compiled with those that this machine runs
    objects, same, units = [], True, bench.users(path)
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
        same = same and code_of(output) == code_of(bench.unchanged(unit))
        objects.append(output)
    if same:
        return "same-code", ""
    spent = 0.0
    names = sorted(order(bench, seconds, path, units), key=lambda name: name != first)
    for name in names:
        spent += seconds[name]
        if spent > near and name != names[0]:
            break
        program = bench.link(name, objects, folder)
        passed, _ = bench.test(program, folder, 3 * seconds[name] + 2)
        os.unlink(program)
        if not passed and bench.passes(name):
            bench.noticed[path, name] = bench.noticed.get((path, name), 0) + 1
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
    """All mutants, (path, kind, start, end, replacement, text), and those of the draw."""
    everything = []
    for full in sorted(sum((glob.glob(os.path.join(ROOT, p)) for p in SOURCES), [])):
        path = os.path.relpath(full, ROOT)
        if any(k in path for k in FOREIGN_KERNELS) or not any(part in path for part in options.only):
            continue
        with open(full, encoding="utf-8") as file:
            text = file.read()
        for kind, start, end, new in sites(text):
            everything.append((path, kind, start, end, new, text))
    random.Random(options.seed).shuffle(everything)
    if options.each is None:
        return everything, everything[:options.count]
    drawn, left = [], {}
    for mutant in everything:
        left[mutant[0]] = left.get(mutant[0], options.each) - 1
        if left[mutant[0]] >= 0:
            drawn.append(mutant)
    return everything, drawn


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
    """The tables of the record."""
    print("%d mutants are possible, %d were tried" % (total, len(rows)))
    kinds = ("sign", "index", "comparison", "constant")
    outcomes = ("killed", "survived", "equivalent", "same-code", "no-compile")
    print("| | killed | survived | share killed | equivalent | same code | do not compile |")
    print("|---|---|---|---|---|---|---|")
    files = sorted({r[0].split(":")[0] for r in rows})
    parts = [(k, [r for r in rows if r[1] == k]) for k in kinds] + [("all", rows)]
    parts += [(f, [r for r in rows if r[0].startswith(f + ":")]) for f in files]
    for name, part in parts:
        count = {o: sum(r[3] == o for r in part) for o in outcomes}
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
    parser.add_argument("--each", type=int)
    parser.add_argument("--only", nargs="+", default=[""])
    parser.add_argument("--list")
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--seconds", type=float, default=1e9)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--near", type=float, default=1e9)
    return parser.parse_args()


def choose(options, rows, everything, drawn):
    """Which mutants are tried, each with the test that is to be first, and all rows by key."""
    listed = read_rows(options.list) if options.list else rows
    known = {} if options.again else {"\t".join(r[:3]): r for r in rows}
    if not options.list and not options.again:
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
    everything, drawn = draw(options)
    rows = read_rows(record) if os.path.exists(record) else []
    mutants, rows = choose(options, rows, everything, drawn)

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
