#!/usr/bin/env python3
"""Takes the declarations of libthrum from its headers and writes them as a module for cffi.

usage: declarations.py HEADERS CC OUTPUT.py KEYWORDS.py

HEADERS is the folder that holds thrum/scene.h and those of the other libraries, CC a C compiler whose preprocessor is used, and
OUTPUT.py the module to write; KEYWORDS.py gets the keywords of bodies, obstacles, solids, links, loads and contact by the rows of
thrum/fields.h, for checkers of types. The first module holds data alone: who installs the package needs no
compiler. SPDX-License-Identifier: Apache-2.0
"""

import os
import re
import subprocess
import sys
import tempfile

import cffi

# headers that bring all others with them
LIBRARIES = ("scene", "response", "gradient")
# a macro that is a number of its own, such as THRUM_RANK_MAX
NUMBER_MACRO = re.compile(r"^#define (THRUM_\w+) (-?(?:0x[0-9a-fA-F]+|\d+))(?=\s)", re.MULTILINE)


def preprocess(headers: str, compiler: str) -> str:
    """The declarations of the public headers alone, without those of the C library."""
    included = [word for library in LIBRARIES for word in ("-include", f"thrum/{library}.h")]
    text = subprocess.run(
        [compiler, "-E", "-std=c11", "-I", headers, *included, "-x", "c", os.devnull],
        check=True, capture_output=True, text=True).stdout

    # lines behind a marker `# 12 "path"` come from that file
    kept = []
    ours = False
    for line in text.splitlines():
        marker = re.match(r'# \d+ "([^"]*)"', line)
        if marker:
            ours = os.path.basename(os.path.dirname(marker.group(1))) == "thrum"
        elif ours:
            kept.append(line)
    return "\n".join(kept)


def plain(text: str) -> str:
    """C that cffi reads: without attributes, bodies of functions and expressions over types."""
    text = re.sub(r"__attribute__\s*\(\((?:[^()]|\([^()]*\))*\)\)", "", text)
    text = re.sub(r"static inline [^{;]*\{[^{}]*\}", "", text)
    return re.sub(r"\n\s*\n+", "\n", text)


def numbers(headers: str) -> str:
    """The macros that are whole numbers, as constants."""
    lines = []
    folder = os.path.join(headers, "thrum")
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            lines += [f"#define {macro} {value}" for macro, value in NUMBER_MACRO.findall(file.read())]
    return "\n".join(lines)


# what takes keywords, the rows of its fields, and the keywords that have parameters of their own
RECORDS = [("Body", "BODY", ["touch"]), ("Obstacle", "OBSTACLE", []), ("Solid", "SOLID", []), ("Link", "LINK", ["kind"]),
           ("Pairs", "PAIRS", []), ("Wind", "WIND", ["velocity"]),
           ("Load", "LOAD", ["kind", "vector", "vertices", "field", "reduced", "parts", "moments", "resultant"])]
# rows of a record that lies in another, and rows whose name Python has for itself
INNER = {"LOAD": " THRUM_COURSE_FIELDS(ROW)"}
NAMES = {"from": "start"}
TYPES = {"NUMBER": "float", "COUNT": "int", "WHOLE": "int", "FLAG": "bool", "OBSTACLE_SHAPE": "str", "SOLID_SHAPE": "str",
         "LINK_KIND": "str", "LOAD_SHAPE": "str"}


def options(headers: str, compiler: str) -> str:
    """The rows of thrum/fields.h as dictionaries of keywords."""
    row = "#define ROW(where, kind, name, unit, value, otherwise, range, about) " \
        "<|kind|name|unit|THRUM_WORDS(kind, value, otherwise)|about|>"
    records = " ".join(f"{{{name} THRUM_{rows}_FIELDS(ROW){INNER.get(rows, '')}}}" for name, rows, _ in RECORDS)
    text = subprocess.run([compiler, "-E", "-P", "-std=c11", "-I", headers, "-x", "c", "-"], check=True, text=True,
                          input=f'#include "thrum/fields.h"\n{row}\n{records}\n', capture_output=True).stdout

    # a literal of C may come in pieces
    def literal(pieces: str) -> str:
        return "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', pieces)).replace('\\"', "'")

    lines = ["from __future__ import annotations", "", "from typing import Any, TypedDict"]
    for (name, _, own), body in zip(RECORDS, re.findall(r"\{(?:Body|Obstacle|Solid|Link|Pairs|Wind|Load) (.*?\|>)\s*\}", text, re.DOTALL)):
        lines += ["", "", f"class {name}Options(TypedDict, total=False):"]
        for kind, member, unit, words, about in re.findall(r"<\|(.*?)\|(.*?)\|(.*?)\|(.*?)\|(.*?)\|>", body, re.DOTALL):
            if member not in own:
                told = literal(about) + (f" [{literal(unit)}]" if literal(unit) else "")
                without = literal(words)
                lines += [f"    # {told}" + (f"; default {without}" if without else ""),
                          f"    {NAMES.get(member, member)}: {TYPES.get(kind, 'Any')}"]
    return "\n".join(lines) + "\n"


def main() -> int:
    if len(sys.argv) != 5:
        sys.stderr.write(__doc__ or "")
        return 2
    headers, compiler, output, keywords = sys.argv[1:]

    ffi = cffi.FFI()
    ffi.cdef(numbers(headers) + "\n" + plain(preprocess(headers, compiler)))
    name = os.path.splitext(os.path.basename(output))[0]
    ffi.set_source(name, None)

    # written beside and renamed: a build that is interrupted leaves no half module
    with tempfile.TemporaryDirectory(dir=os.path.dirname(os.path.abspath(output))) as work:
        made = os.path.join(work, name + ".py")
        ffi.emit_python_code(made)
        with open(made, encoding="utf-8") as file:
            text = file.read()
        with open(made, "w", encoding="utf-8") as file:
            file.write("# Generated by declarations.py from the headers.\n# mypy: ignore-errors\n" + text)
        os.replace(made, output)
        with open(made, "w", encoding="utf-8") as file:
            file.write('"""Keywords by the rows of thrum/fields.h, generated by declarations.py."""\n\n' + options(headers, compiler))
        os.replace(made, keywords)
    return 0


if __name__ == "__main__":
    sys.exit(main())
