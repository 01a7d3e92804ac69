#!/usr/bin/env python3
"""Blocks of code in the documentation are whole: shell, Python, JSON and JavaScript parse, C compiles, fences are closed.

Commands of the README, the tutorial and the how-tos are also run (test_page.sh), as is the Python of python/README.md.
usage: test_blocks.py SOURCE COMPILER [NODE]
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

# what the text around a fragment of C has made already; what the fragment declares itself hides a name of these
MADE = """
const thrum_model *model, const thrum_model *stepped, thrum_state *state, thrum_state_def *def, thrum_scene *scene,
thrum_contact *contact, thrum_contact_environment environment, const thrum_surface *surface, thrum_error error, void *memory,
thrum_accelerator *accelerator, thrum_crowd *crowd, double *p, size_t size, int64_t steps, int64_t count, int32_t vertex, int32_t number, float *buffer, double *q, double *x, double *u
"""
# a function around a fragment, and the one of examples/tutorial/pluck.c that the tutorial shows a part of
FRAGMENT = """
#include "thrum/accelerator.h"
#include "thrum/scene.h"
#include "thrum/thrum.h"
thrum_status print_row(const thrum_model *, thrum_state *, int32_t, thrum_error *);
thrum_status frame(%s);
thrum_status frame(%s) {
  {
#line 1
%s
  }
  return THRUM_OK;
}
"""


def whole(text):
    """A block of C as a file that compiles: a program as it is, a fragment inside a function."""
    if re.search(r"\bmain\(", text):
        return text
    # `error` is one, or a pointer to the caller's
    made = re.sub(r"thrum_error error", "thrum_error *error", MADE) if "&error" not in text else MADE
    return FRAGMENT % (made, made, re.sub(r"^ *\.\.\.$", "", text, flags=re.M))


def compile_c(source, compiler, text):
    """What the compiler says of a block of C; None where it is right."""
    done = subprocess.run([compiler, "-std=c11", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-Wno-unused",
                           "-Wno-unused-parameter",
                           f"-I{source}/include", "-x", "c", "-"],
                          input=whole(text), text=True, capture_output=True)
    return done.stderr.strip() or None if done.returncode else None


def fault(language, text, source, compiler, node):
    """What is wrong with a block; None where it parses or is in no language that is looked at."""
    try:
        if language == "c":
            return compile_c(source, compiler, text)
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
    source, compiler, node = os.path.abspath(sys.argv[1]), sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else ""
    wrong, count = [], 0
    for page in sorted(pages(source)):
        text = open(page, encoding="utf-8").read()
        name = os.path.relpath(page, source)
        if len(re.findall(r"^ *```", text, flags=re.M)) % 2:
            wrong.append(f"{name}: a block of code is not closed")
        for found in FENCE.finditer(text):
            count += 1
            said = fault(found.group(2), found.group(3), source, compiler, node)
            if said:
                wrong.append(f"{name}:{text[:found.start()].count(chr(10)) + 1}: {found.group(2)}: {said}")
    for line in wrong:
        print(line)
    print(f"{count} blocks, {len(wrong)} faults")
    return 1 if wrong or count < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
