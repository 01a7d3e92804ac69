#!/usr/bin/env python3
"""Every file and every name that docs/notation.md gives to a symbol exists in the code.

usage: tests/docs/test_notation.py [ROOT]    exit 1 with what does not exist

Names are the words in backticks of a table's column "in the code"; files those of its last column. A header
`thrum/x.h` is one of include/. SPDX-License-Identifier: Apache-2.0
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
FOLDERS = ("include", "core", "runtime", "contact", "mesh", "precompute", "scene", "validation", "viewer/src")
SUFFIXES = (".c", ".h", ".inl", ".js")


def code_words():
    """Every identifier of the code."""
    found = set()
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in SUFFIXES:
                found.update(re.findall(r"\w+", path.read_text(encoding="utf-8")))
    return found


def exists(file):
    return any(path.is_file() for path in (ROOT / file, ROOT / "include" / file))


def wrong():
    words = code_words()
    page = (ROOT / "docs" / "notation.md").read_text(encoding="utf-8").split("\n")
    for number, line in enumerate(page, 1):
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if len(cells) < 4 or cells[0] in ("symbol", "---"):
            continue
        for name in re.findall(r"`([^`]+)`", cells[1]):
            if name not in words:
                yield f"docs/notation.md:{number}: {name} is no name of the code"
        for file in re.findall(r"`([^`]+)`", cells[-1]):
            if not exists(file):
                yield f"docs/notation.md:{number}: there is no file {file}"


def main():
    found = list(wrong())
    print("\n".join(found) if found else "docs/notation.md agrees with the code")
    return 1 if found else 0


sys.exit(main())
