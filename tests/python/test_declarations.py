"""The declarations of the package are those of the compiler: sizes and places of every field, every function and
every status. SPDX-License-Identifier: Apache-2.0

usage: test_declarations.py HEADERS CC
"""
import os
import re
import subprocess
import sys
import tempfile

import thrum
from thrum._native import ffi, lib


def structs():
    """Names of the structs whose fields are declared."""
    found = []
    for name in ffi.list_types()[0]:
        kind = ffi.typeof(name)
        if kind.kind == "struct" and kind.fields is not None:
            found.append(name)
    return found


def compiler_says(headers, compiler, names):
    """{"struct.field": (offset, size)} and {"struct": (0, size)} from a program that the C compiler made."""
    lines = ['#include <stddef.h>', '#include <stdio.h>', '#include "thrum/scene.h"', '#include "thrum/response.h"',
             '#include "thrum/gradient.h"', "int main(void) {"]
    for name in names:
        lines.append(f'  printf("{name} 0 %zu\\n", sizeof({name}));')
        for field, _ in ffi.typeof(name).fields:
            lines.append(f'  printf("{name}.{field} %zu %zu\\n", offsetof({name}, {field}), '
                         f'sizeof((({name} *)0)->{field}));')
    lines.append("  return 0;\n}")
    with tempfile.TemporaryDirectory() as folder:
        source, binary = os.path.join(folder, "layout.c"), os.path.join(folder, "layout")
        with open(source, "w", encoding="ascii") as file:
            file.write("\n".join(lines))
        subprocess.run([compiler, "-std=c11", "-I", headers, source, "-o", binary], check=True)
        text = subprocess.run([binary], check=True, capture_output=True, text=True).stdout
    return {words[0]: (int(words[1]), int(words[2])) for words in map(str.split, text.splitlines())}


def package_says(names):
    said = {}
    for name in names:
        said[name] = (0, ffi.sizeof(name))
        for field, kind in ffi.typeof(name).fields:
            said[f"{name}.{field}"] = (kind.offset, ffi.sizeof(kind.type))
    return said


def main():
    headers, compiler = sys.argv[1:3]
    names = structs()
    assert len(names) > 20, names
    truth, said = compiler_says(headers, compiler, names), package_says(names)
    wrong = [f"{name}: {said[name]} here, {truth[name]} in C" for name in truth if said[name] != truth[name]]
    assert not wrong, "\n".join(wrong)

    # every function that a header declares with THRUM_API can be called; accelerators are a library of their own
    for name in sorted(set(os.listdir(os.path.join(headers, "thrum"))) - {"accelerator.h"}):
        with open(os.path.join(headers, "thrum", name), encoding="utf-8") as file:
            text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
        for function in re.findall(r"THRUM_API\s[^;(]*?\b(thrum_\w+)\s*\(", text):
            assert callable(getattr(lib, function)), function

    # statuses and names of choices are those of the headers
    statuses = {name[len("THRUM_"):]: value for value, name in ffi.typeof("thrum_status").elements.items()}
    assert statuses == {status.name: status.value for status in thrum.Status}, statuses
    print(f"{len(names)} structs, {len(truth) - len(names)} fields")


if __name__ == "__main__":
    main()
