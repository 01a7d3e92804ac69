#!/usr/bin/env python3
"""Every function that a public header declares is called by a fuzz target.

usage: test_called.py SOURCE            names the functions that no target calls
       test_called.py --planted SOURCE  adds a function to a header and demands that it is found

SPDX-License-Identifier: Apache-2.0
"""
import glob
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "api"))
import test_exports  # noqa: E402

# a driver of OpenCL takes half a second to compile for each model: tests/accelerator gives these bad arguments
APART = {"accelerator.h"}
PLANTED = "THRUM_API int thrum_planted(void);\n"


def called(root):
    """The functions that the targets call, comments and texts apart."""
    found = set()
    for path in glob.glob(os.path.join(root, "tests", "fuzz", "*.[ch]")):
        with open(path, encoding="utf-8") as file:
            text = re.sub(r'"(?:\\.|[^"\\])*"', '""', test_exports.COMMENT.sub("", file.read()))
        found |= set(re.findall(r"\b(thrum_\w+)\s*\(", text))

    # what a header calls within a function of its own
    for text in test_exports.read_headers(root).values():
        for name, body in re.findall(r"static inline \w+ (thrum_\w+)\(\w*\) \{(.*?)\n\}", text, re.DOTALL):
            if name in found:
                found |= set(re.findall(r"\b(thrum_\w+)\s*\(", body))
    return found


def uncalled(headers, functions):
    """The functions of the headers that are not among those called."""
    declared, problems = set(), []
    for name, text in headers.items():
        declared |= test_exports.declared(name, text, problems)
    return sorted(declared - functions)


def main():
    planted = sys.argv[1] == "--planted"
    root = sys.argv[2 if planted else 1]
    headers = {name: text for name, text in test_exports.read_headers(root).items() if name not in APART}
    if planted:
        headers["planted.h"] = PLANTED
    missing = uncalled(headers, called(root))
    if planted:
        sys.exit(0 if "thrum_planted" in missing else "a function that nothing calls is not found")
    if missing:
        sys.exit("no target of tests/fuzz calls: " + ", ".join(missing))
    print(f"{len(uncalled(headers, set()))} functions of the headers, each called by a fuzz target")


if __name__ == "__main__":
    main()
