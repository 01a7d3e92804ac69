#!/usr/bin/env python3
"""The structure of the sources, read from their includes and declarations.

Eight rules keep the tree readable:
  1. No cycle of includes between files or between folders.
  2. No private header is taken from above: each folder includes only folders below it, and what is
     private to the runtime, to contact or to the scene library stays there (core/base and runtime/material serve
     everyone).
  3. A header declares the functions of its own .c and of no other. A family of files shares the
     header whose name they begin with: msh_read.h declares msh_read.c and msh_read_nodes.c. A
     header in include/thrum is the face of a whole library: core/, runtime/ and contact/, scene/ for scene.h, response/ for
     response.h, or gradient/ for gradient.h.
  4. No two source files have the same name.
  5. The core stands alone: a file of core/ includes core/ and the public headers that core/ implements,
     and names no function and no table that is defined above it. What is above is reached through the
     two tables that each library has of its own, thrum_schemes and thrum_passes. The runtime names nothing of contact/
     either.
  6. No files call each other in a circle.
  7. A private header declares the functions of at most five files.
  8. A number of core/, runtime/, contact/ and scene/ that was tuned has a name: a literal is written exactly by
     sixteenths, as 0.5 and 12.0 are, or has the digits of a constant of mathematics, or stands in a
     #define (which docs/tuning.md lists) or in the defaults of a definition.

usage: test_structure.py SOURCE      checks the tree, prints each violation, exits with 1 if there is one
       test_structure.py --self-test SOURCE   plants a violation of each rule and demands that it is found

SPDX-License-Identifier: Apache-2.0
"""
import functools
import os
import re
import sys

# Top-level folders and what each may include besides itself; public headers are open to all.
LAYERS = {
    "include": set(),
    "core": set(),
    "runtime": {"core"},
    "contact": {"core", "runtime"},
    "scene": set(),
    "response": set(),
    "gradient": set(),
    "accelerator": set(),
    "platform": set(),
    "io": {"platform"},
    "mesh": {"platform", "io"},
    "precompute": {"platform", "io", "mesh"},
    "config": {"platform", "io"},
    "driver": {"platform", "io", "mesh", "precompute", "config"},
    "validation": {"platform", "io", "mesh", "precompute", "config", "driver"},
    "bench": {"platform", "io", "mesh", "precompute", "accelerator"},
    "app": {"platform", "io", "mesh", "precompute", "config", "driver", "validation", "bench"},
    "mpi": {"platform", "io", "mesh", "precompute", "config", "driver", "app"},
    "viewer": {"javascript"},
    "javascript": set(),
}
# The public headers whose functions core/ defines, or that have none.
CORE_HEADERS = {"api", "base_motion", "external_load", "kernel", "kernel_pass", "model", "polynomial", "state", "status",
                "step_equation", "version"}
# The tables by which the core reaches what is above it; core/alone.c has those of the core alone.
CORE_TABLES = {"thrum_schemes", "thrum_passes"}
SUFFIXES = (".c", ".h", ".inl")
OWNERS_MAX = 5
# a floating-point number, and a default of a definition, such as `.tolerance = 1e-4`
LITERAL = re.compile(r'(?<![\w.])((?:\d+\.\d*|\.\d+)(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.]*x)')
DEFAULT = re.compile(r'\.\w+ = -?[\d.]+(?:[eE][-+]?\d+)?')
DIGITS_OF_MATHEMATICS = 15
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]', re.M)
COMMENT = re.compile(r'/\*.*?\*/|//[^\n]*', re.S)
# GNU attributes, and the macros of ours that stand before a declaration
DECORATION = re.compile(r'__attribute__\s*\(\(.*?\)\)|\bTHRUM_API\b|extern\s+"C"\s*\{?')


def read_tree(root):
    """The sources under the known folders: {path relative to root: text}."""
    files = {}
    for top in LAYERS:
        for folder, names, found in os.walk(os.path.join(root, top)):
            names[:] = [n for n in names if n not in ("node_modules", "build", "results", "dist")]
            for name in found:
                if name.endswith(SUFFIXES):
                    path = os.path.join(folder, name)
                    with open(path, encoding="utf-8") as file:
                        files[os.path.relpath(path, root).replace(os.sep, "/")] = file.read()
    return files


def resolve(files, path, name):
    """The file that an #include of `name` in `path` means; None for what is not ours."""
    beside = os.path.normpath(os.path.join(os.path.dirname(path), name))
    for candidate in (beside, name, "include/" + name):
        if candidate in files:
            return candidate
    return None


def includes(files):
    """{path: set of the paths that it includes}."""
    return {path: {target for name in INCLUDE.findall(text)
                   if (target := resolve(files, path, name)) is not None}
            for path, text in files.items()}


def module_of(path):
    """A .c with its own headers is one node of the graph of files."""
    stem = path.rsplit(".", 1)[0]
    return stem[:-len("_private")] if stem.endswith("_private") else stem


def folder_of(path):
    return os.path.dirname(path)


def cycles(edges):
    """The strongly connected components of more than one node (Tarjan 1972), each sorted."""
    index, low, stack, on_stack, found = {}, {}, [], set(), []

    def visit(start):
        work = [(start, iter(sorted(edges.get(start, ()))))]
        index[start] = low[start] = len(index)
        stack.append(start)
        on_stack.add(start)
        while work:
            node, targets = work[-1]
            target = next(targets, None)
            if target is not None:
                if target not in index:
                    index[target] = low[target] = len(index)
                    stack.append(target)
                    on_stack.add(target)
                    work.append((target, iter(sorted(edges.get(target, ())))))
                elif target in on_stack:
                    low[node] = min(low[node], index[target])
                continue
            work.pop()
            if work:
                low[work[-1][0]] = min(low[work[-1][0]], low[node])
            if low[node] == index[node]:
                component = []
                while True:
                    member = stack.pop()
                    on_stack.discard(member)
                    component.append(member)
                    if member == node:
                        break
                if len(component) > 1:
                    found.append(sorted(component))

    for node in sorted(edges):
        if node not in index:
            visit(node)
    return found


def check_cycles(files):
    graph = includes(files)
    by_file, by_folder = {}, {}
    for path, targets in graph.items():
        for target in targets:
            # a public header is the face of a library, not the module that implements it
            if target.startswith("include/") or path.startswith("include/"):
                continue
            if module_of(path) != module_of(target):
                by_file.setdefault(module_of(path), set()).add(module_of(target))
            if folder_of(path) != folder_of(target):
                by_folder.setdefault(folder_of(path), set()).add(folder_of(target))
    for component in cycles(by_file):
        yield f"files include each other in a cycle: {', '.join(component)}"
    for component in cycles(by_folder):
        yield f"folders include each other in a cycle: {', '.join(component)}"


def check_layers(files):
    for path, targets in sorted(includes(files).items()):
        top = path.split("/")[0]
        for target in sorted(targets):
            below = target.split("/")[0]
            if below in (top, "include"):
                continue
            if folder_of(target) in ("core/base", "runtime/material"):
                continue
            if below not in LAYERS[top]:
                yield f"{path} includes {target}: {top}/ may not include {below}/"


@functools.lru_cache(maxsize=None)
def declarations(text):
    """(declared, defined): names of the functions with external linkage at the top level."""
    text = DECORATION.sub(" ", COMMENT.sub(" ", text))
    text = re.sub(r'^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', " ", text, flags=re.M)
    text = re.sub(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'', '""', text)
    declared, defined = set(), set()
    depth, start = 0, 0
    for match in re.finditer(r'[{};]', text):
        mark = match.group()
        if mark == "}":
            depth = max(0, depth - 1)
        elif depth == 0:
            head = text[start:match.start()].strip()
            name = re.search(r'(\w+)\s*\(', head)
            outside = "=" not in head and not re.search(r'\b(static|typedef|inline|INLINE)\b', head)
            if name and outside and re.match(r'[A-Za-z_][\w\s*]*$', head[:name.start()] or "!"):
                (defined if mark == "{" else declared).add(name.group(1))
        if mark == "{":
            depth += 1
        if depth == 0:
            start = match.end()
    return declared, defined


def check_headers(files):
    where = {}
    for path, text in files.items():
        if path.endswith(".c"):
            for name in declarations(text)[1]:
                where.setdefault(name, set()).add(path)
    for path, text in sorted(files.items()):
        if not path.endswith(".h"):
            continue
        for name in sorted(declarations(text)[0]):
            for source in sorted(where.get(name, ())):
                if path.startswith("include/"):
                    own = os.path.basename(path)[:-2]
                    home = (own,) if own in ("scene", "response", "gradient", "accelerator") else ("core", "runtime", "contact")
                    good = source.split("/")[0] in home
                else:
                    stem = module_of(source)
                    own = module_of(path)
                    good = stem == own or stem.startswith(own + "_")
                if not good:
                    yield f"{path} declares {name}, which {source} defines"


def check_names(files):
    named = {}
    for path in files:
        named.setdefault(os.path.basename(path), []).append(path)
    for name, paths in sorted(named.items()):
        if len(paths) > 1:
            yield f"{len(paths)} files are named {name}: {', '.join(sorted(paths))}"


@functools.lru_cache(maxsize=None)
def tables(text):
    """The names of objects with external linkage and a value that a source defines."""
    outside = r'^(?!static\b|typedef\b)\w[\w \t*]*?[\s*](\w+)\s*(?:\[[^]]*\]\s*)*='
    return set(re.findall(outside, COMMENT.sub(" ", text), re.M))


@functools.lru_cache(maxsize=None)
def words(text):
    """The identifiers of a source, without those of comments and strings."""
    return set(re.findall(r'\b[A-Za-z_]\w+', re.sub(r'"(?:\\.|[^"\\])*"', '""', COMMENT.sub(" ", text))))


def check_core(files):
    def is_core(path):
        return path.startswith("core/")

    # who defines what above the core
    above = {}
    for path, text in files.items():
        if path.endswith(".c") and not is_core(path):
            for name in (declarations(text)[1] | tables(text)) - CORE_TABLES:
                above[name] = path
    graph = includes(files)
    for path, text in sorted(files.items()):
        if not is_core(path):
            continue
        for target in sorted(graph[path]):
            public = target.startswith("include/thrum/")
            if not is_core(target) and not (public and os.path.basename(target)[:-2] in CORE_HEADERS):
                yield f"{path} includes {target}, which is above the core"
        for name in sorted(words(text) & above.keys()):
            yield f"{path} names {name} of {above[name]}, which is above the core"
    contact = {name for name, path in above.items() if path.startswith("contact/")}
    for path, text in sorted(files.items()):
        if path.startswith("runtime/"):
            for name in sorted(words(text) & contact):
                yield f"{path} names {name} of {above[name]}, which is above the runtime"


def definitions(files):
    """Where each function with external linkage is defined; one with several homes, of kernels and tables, has none."""
    where = {}
    for path, text in files.items():
        if path.endswith(".c"):
            for name in declarations(text)[1]:
                where.setdefault(name, set()).add(path)
    return {name: paths.pop() for name, paths in where.items() if len(paths) == 1}


def check_calls(files):
    where = definitions(files)
    edges = {}
    for path, text in files.items():
        if path.endswith(".c"):
            called = {where[name] for name in words(text) if name in where}
            edges[path] = called - {path}
    for members in cycles(edges):
        yield f"files call each other in a circle: {', '.join(sorted(members))}"


def check_owners(files):
    where = definitions(files)
    for path, text in sorted(files.items()):
        if path.endswith(".h") and not path.startswith("include/"):
            owners = {where[name] for name in declarations(text)[0] if name in where}
            if len(owners) > OWNERS_MAX:
                yield f"{path} declares the functions of {len(owners)} files: {', '.join(sorted(owners))}"


def blank(match):
    return "\n" * match.group().count("\n")


def check_literals(files):
    for path, text in sorted(files.items()):
        if path.split("/")[0] not in ("core", "runtime", "contact", "scene"):
            continue
        text = re.sub(r'"(?:\\.|[^"\\\n])*"', '""', COMMENT.sub(blank, text))
        text = re.sub(r'^[ \t]*#[ \t]*define\b(?:[^\n]*\\\n)*[^\n]*', blank, text, flags=re.M)
        for number, line in enumerate(text.split("\n"), 1):
            for literal in LITERAL.findall(DEFAULT.sub("", line)):
                digits = literal.split("e")[0].replace(".", "").lstrip("0")
                exact = "e" not in literal.lower() and (16 * float(literal)).is_integer()
                if not exact and len(digits) < DIGITS_OF_MATHEMATICS:
                    yield f"{path}:{number}: {literal} has no name"


CHECKS = (check_cycles, check_layers, check_headers, check_names, check_core, check_calls, check_owners, check_literals)


def violations(files):
    return [line for check in CHECKS for line in check(files)]


def self_test(files):
    """Each planted violation must be found by its check."""
    plants = (
        (check_cycles, {"io/planted_one.h": '#include "io/planted_two.h"\n',
                        "io/planted_two.h": '#include "io/planted_one.h"\n'}),
        (check_cycles, {"precompute/planted/low.h": '#include "precompute/planted_top/high.h"\n',
                        "precompute/planted_top/high.h": '#include "precompute/planted/other.h"\n',
                        "precompute/planted/other.h": "\n"}),
        (check_layers, {"mesh/planted.c": '#include "driver/planted.h"\n', "driver/planted.h": "\n"}),
        (check_layers, {"io/planted.c": '#include "core/step/planted.h"\n', "core/step/planted.h": "\n"}),
        (check_layers, {"runtime/guard/planted.c": '#include "contact/planted.h"\n', "contact/planted.h": "\n"}),
        (check_layers, {"scene/planted.c": '#include "contact/planted.h"\n', "contact/planted.h": "\n"}),
        (check_headers, {"io/planted_a.h": "int thrum_planted(int value);\n",
                         "io/planted_b.c": "int thrum_planted(int value) {\n  return value;\n}\n"}),
        (check_names, {"io/planted.h": "\n", "mesh/planted.h": "\n"}),
        (check_core, {"core/step/planted.c": '#include "runtime/guard/planted.h"\n',
                      "runtime/guard/planted.h": "\n"}),
        (check_core, {"core/step/planted.c": "#include <runtime/guard/planted.h>\n",
                      "runtime/guard/planted.h": "\n"}),
        (check_core, {"core/step/planted.c": "int f(void) {\n  return planted(1);\n}\n",
                      "platform/planted.c": "int planted(int value) {\n  return value;\n}\n"}),
        (check_core, {"core/step/planted.c": "extern int thrum_planted[2];\nint *f(void) {\n  return thrum_planted;\n}\n",
                      "runtime/guard/planted.c": "int thrum_planted[2] = {1, 2};\n"}),
        (check_core, {"core/step/planted.c": '#include "thrum/planted.h"\n', "include/thrum/planted.h": "\n"}),
        (check_core, {"core/step/planted.c": "int f(void) {\n  return thrum_planted(1);\n}\n",
                      "runtime/guard/planted.c": "int thrum_planted(int value) {\n  return value;\n}\n"}),
        (check_core, {"core/step/planted.c": "const int *f(void) {\n  return &thrum_planted;\n}\n",
                      "runtime/comparison/planted.c": "const int thrum_planted = 1;\n"}),
        (check_core, {"runtime/guard/planted.c": "int f(void) {\n  return thrum_planted(1);\n}\n",
                      "contact/planted.c": "int thrum_planted(int value) {\n  return value;\n}\n"}),
        (check_calls, {"io/planted_a.c": "int planted_a(void) {\n  return planted_b();\n}\n",
                       "io/planted_b.c": "int planted_b(void) {\n  return planted_a();\n}\n"}),
        (check_owners, {"io/planted.h": "".join(f"int planted_{n}(void);\n" for n in range(6)),
                        **{f"io/planted_{n}.c": f"int planted_{n}(void) {{\n  return {n};\n}}\n" for n in range(6)}}),
        (check_literals, {"runtime/guard/planted.c": "double f(double x) {\n  return 0.7 * x;\n}\n"}),
        (check_literals, {"scene/planted.c": "double f(double x) {\n  return x + 1e-12;\n}\n"}),
    )
    # what a check says of the tree, and what is read of a source, is found once
    said = functools.lru_cache(maxsize=None)(lambda check: set(check(files)))
    missed = 0
    for check, plant in plants:
        before = said(check)
        after = set(check({**files, **plant}))
        if not after - before:
            print(f"{check.__name__} does not see {', '.join(plant)}")
            missed += 1
    print(f"{len(plants) - missed} of {len(plants)} planted violations were found")
    return missed


def main(arguments):
    planted = arguments[:1] == ["--self-test"]
    roots = arguments[planted:]
    if len(roots) != 1:
        print("usage: test_structure.py [--self-test] SOURCE", file=sys.stderr)
        return 2
    files = read_tree(roots[0])
    if len(files) < 100:
        print(f"{roots[0]}: {len(files)} source files only; is it a checkout?", file=sys.stderr)
        return 2
    if planted:
        return 1 if self_test(files) else 0
    lines = violations(files)
    for line in lines:
        print(line)
    print(f"{len(files)} files, {len(lines)} violations")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
