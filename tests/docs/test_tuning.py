#!/usr/bin/env python3
"""docs/tuning.md lists every numeric #define of core/, runtime/ and contact/, with its file and its value.

usage: tests/docs/test_tuning.py [ROOT]    exit 1 with the differences

A row of a table there begins with | `NAME` | `VALUE` | `FILE` |, FILE with its folders. The test fails for a
constant without a row, for a row without a constant, and for a row with another value than the code. The scripts
that put constants out of effect, and their results, name constants that there are.
SPDX-License-Identifier: Apache-2.0
"""
import csv
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
DEFINE = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)[ \t]+(.+)$", re.MULTILINE)
COMMENT = re.compile(r"/\*.*?(\*/|$)|//.*$")
# numbers, names and operators alone, with a digit that is not part of a name
NUMBER = re.compile(r"(?<![A-Za-z_])\d")
EXPRESSION = re.compile(r"[\w\s+\-*/%()<>.]+")
ROW = re.compile(r"^\| `(\w+)` \| `([^`]+)` \| `([^`]+)` \|", re.MULTILINE)


def constants():
    """(file, name) -> value of every numeric #define."""
    found = {}
    for path in sorted(path for folder in ("core", "runtime", "contact") for path in (ROOT / folder).rglob("*")):
        if path.suffix not in (".c", ".h", ".inl"):
            continue
        text = path.read_text(encoding="utf-8").replace("\\\n", " ")
        for name, value in DEFINE.findall(text):
            value = " ".join(COMMENT.sub("", value).split())
            if NUMBER.search(value) and EXPRESSION.fullmatch(value):
                found[path.relative_to(ROOT).as_posix(), name] = value
    return found


def rows():
    """(file, name) -> value of every row, and the rows that stand there twice."""
    found, twice = {}, []
    for name, value, file in ROW.findall((ROOT / "docs" / "tuning.md").read_text(encoding="utf-8")):
        if (file, name) in found:
            twice.append((file, name))
        found[file, name] = value
    return found, twice


def differences(code, page, twice):
    for key in sorted(code.keys() - page.keys()):
        yield f"{key[0]}: {key[1]} has no row in docs/tuning.md"
    for key in sorted(page.keys() - code.keys()):
        yield f"docs/tuning.md: {key[1]} is not a numeric #define of {key[0]}"
    for key in sorted(code.keys() & page.keys()):
        if code[key] != page[key]:
            yield f"docs/tuning.md: {key[1]} of {key[0]} is {code[key]}, not {page[key]}"
    for key in twice:
        yield f"docs/tuning.md: {key[1]} of {key[0]} has two rows"


def tried(code):
    """The constants of validation/without_*constants.py and of their results that the code has not."""
    known = {(pathlib.PurePath(file).name, name) for file, name in code}
    for script in sorted((ROOT / "validation").glob("without_*constants.py")):
        listed = re.findall(r'"([\w/]+\.[ch])", \{(.*?)\}', script.read_text(encoding="utf-8"), re.DOTALL)
        names = [(script.name, file, name) for file, text in listed for name in re.findall(r'"(\w+)":', text)]
        with open(ROOT / "validation" / "results" / f"{script.stem}.csv", encoding="utf-8") as table:
            names += [(f"{script.stem}.csv", row["file"], row["constant"]) for row in csv.DictReader(table)]
        for where, file, name in names:
            if (pathlib.PurePath(file).name, name) not in known:
                yield f"validation, {where}: {name} is not a numeric #define of {file}"


def main():
    code = constants()
    page, twice = rows()
    wrong = list(differences(code, page, twice)) + list(tried(code))
    print("\n".join(wrong) if wrong else f"{len(code)} constants, all in docs/tuning.md")
    return 1 if wrong or not code else 0


sys.exit(main())
