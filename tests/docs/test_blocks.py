#!/usr/bin/env python3
"""Blocks of code in the documentation are whole: shell, Python, JSON and JavaScript parse, fences are closed.

Commands of the README, the tutorial and the how-tos are also run (test_page.sh), as is the Python of python/README.md.
usage: test_blocks.py SOURCE [NODE]
SPDX-License-Identifier: Apache-2.0
"""
import ast
import json
import os
import re
import subprocess
import sys
import tempfile

from test_links import pages

FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.M | re.S)


def fault(language, text, node):
    """What is wrong with a block; None where it parses or is in no language that is looked at."""
    try:
        if language == "python":
            ast.parse(text)
        elif language == "json":
            json.loads(text)
        elif language == "sh":
            done = subprocess.run(["sh", "-n"], input=text, text=True, capture_output=True)
            return done.stderr.strip() or None
        elif language == "js" and node:
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "block.mjs")
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
                done = subprocess.run([node, "--check", path], text=True, capture_output=True)
                return done.stderr.strip() or None
    except (SyntaxError, ValueError) as error:
        return str(error)
    return None


def main():
    source, node = os.path.abspath(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else ""
    wrong, count = [], 0
    for page in sorted(pages(source)):
        text = open(page, encoding="utf-8").read()
        name = os.path.relpath(page, source)
        if len(re.findall(r"^ *```", text, flags=re.M)) % 2:
            wrong.append(f"{name}: a block of code is not closed")
        for found in FENCE.finditer(text):
            count += 1
            said = fault(found.group(2), found.group(3), node)
            if said:
                wrong.append(f"{name}:{text[:found.start()].count(chr(10)) + 1}: {found.group(2)}: {said}")
    for line in wrong:
        print(line)
    print(f"{count} blocks, {len(wrong)} faults")
    return 1 if wrong or count < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
