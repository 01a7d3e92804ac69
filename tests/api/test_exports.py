#!/usr/bin/env python3
"""A shared library exports the functions of its public headers, and nothing else.

The symbols file of the Debian package names the same functions: that package does not build otherwise.

usage: test_exports.py SOURCE LIBTHRUM LIBTHRUM_SCENE LIBTHRUM_RESPONSE LIBTHRUM_GRADIENT LIBTHRUM_ACCELERATOR   compares the libraries with their headers
       test_exports.py --planted SOURCE LIBTHRUM LIBTHRUM_SCENE LIBTHRUM_RESPONSE LIBTHRUM_GRADIENT LIBTHRUM_ACCELERATOR
                       plants a difference of each kind and demands that it is found

The scene library has scene.h, that of responses response.h, that of gradients gradient.h, that of accelerators
accelerator.h, the runtime the other headers of include/thrum. Every function that
they declare must carry THRUM_API, but for those defined in the header itself.

SPDX-License-Identifier: Apache-2.0
"""
import os
import re
import subprocess
import sys

SYMBOLS = "debian/libthrum0.2.symbols"
LIBRARIES = ("thrum", "thrum_scene", "thrum_response", "thrum_gradient", "thrum_accelerator")
OWN_HEADERS = {"scene.h": "thrum_scene", "response.h": "thrum_response", "gradient.h": "thrum_gradient",
               "accelerator.h": "thrum_accelerator"}
COMMENT = re.compile(r'/\*.*?\*/|//[^\n]*', re.S)
DIRECTIVE = re.compile(r'^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', re.M)
ATTRIBUTE = re.compile(r'__attribute__\s*\(\(.*?\)\)\s*', re.S)
# a function's type, name and parameters, up to the end of the declaration or the body
FUNCTION = re.compile(r'^([A-Za-z_][\w \n*]*?)\b(\w+)\s*\(([^;{]*)\)\s*([;{])', re.M)


def read_headers(root):
    """{name of the header: text}."""
    folder = os.path.join(root, "include", "thrum")
    headers = {}
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            headers[name] = file.read()
    return headers


def exported(library):
    """The symbols that a shared library defines for others."""
    listed = subprocess.run(["nm", "-D", "--defined-only", library], check=True, text=True,
                            capture_output=True).stdout
    return {line.split()[2] for line in listed.splitlines() if len(line.split()) == 3}


def declared(name, text, problems):
    """The functions that a header declares; notes those without THRUM_API."""
    text = ATTRIBUTE.sub("", DIRECTIVE.sub("", COMMENT.sub("", text)))
    found = set()
    for match in FUNCTION.finditer(text):
        kind, function, end = match.group(1), match.group(2), match.group(4)
        if kind.startswith("typedef") or end == "{":
            continue
        found.add(function)
        if "THRUM_API" not in kind.split():
            problems.append(f"{name} declares {function} without THRUM_API")
    return found


def compare(headers, symbols):
    """What differs between the headers and the symbols of the libraries."""
    problems = []
    functions = {library: set() for library in LIBRARIES}
    for name, text in headers.items():
        library = OWN_HEADERS.get(name, "thrum")
        functions[library] |= declared(name, text, problems)
    for library, names in functions.items():
        problems += [f"lib{library} does not export {n}" for n in sorted(names - symbols[library])]
        problems += [f"lib{library} exports {n}, which no public header declares"
                     for n in sorted(symbols[library] - names)]
        if not names:
            problems.append(f"no public header declares a function of lib{library}")
    return problems


def packaged(root):
    """The symbols of the libraries as Debian's symbols file has them."""
    found, library = {name: set() for name in LIBRARIES}, None
    with open(os.path.join(root, SYMBOLS), encoding="utf-8") as file:
        for line in file:
            head = re.match(r"lib(\w+)\.so", line)
            library = head.group(1) if head else library
            name = re.match(r" (\w+)@", line)
            if name:
                found[library].add(name.group(1))
    return found


def compare_packaged(symbols, listed):
    """What differs between the libraries and the symbols file."""
    return [line for library, names in symbols.items() for line in
            [f"{SYMBOLS} lacks {n} of lib{library}" for n in sorted(names - listed[library])] +
            [f"{SYMBOLS} has {n}, which lib{library} does not export" for n in sorted(listed[library] - names)]]


def planted(headers, symbols):
    """Plants each kind of difference in what agrees; returns those that are not found."""
    missed = []

    def expect(what, problem, headers, symbols):
        if problem not in compare(headers, symbols):
            missed.append(what)

    more = dict(symbols, thrum=symbols["thrum"] | {"thrum_planted"})
    expect("a symbol without a declaration",
           "libthrum exports thrum_planted, which no public header declares", headers, more)
    less = dict(symbols, thrum=symbols["thrum"] - {"thrum_step"})
    expect("a declaration without a symbol", "libthrum does not export thrum_step", headers, less)
    bare = dict(headers)
    bare["version.h"] = bare["version.h"].replace("THRUM_API const", "const")
    expect("a declaration without THRUM_API", "version.h declares thrum_version without THRUM_API",
           bare, symbols)
    fewer = dict(symbols, thrum_scene=symbols["thrum_scene"] - {"thrum_scene_step"})
    expect("a missing symbol of the scene library",
           "libthrum_scene does not export thrum_scene_step", headers, fewer)
    if compare_packaged(more, symbols) != [f"{SYMBOLS} lacks thrum_planted of libthrum"]:
        missed.append("a symbol that Debian's file lacks")
    if compare_packaged(fewer, symbols) != [f"{SYMBOLS} has thrum_scene_step, which libthrum_scene does not export"]:
        missed.append("a symbol that Debian's file has and the library has not")
    return missed


def main(arguments):
    plant = arguments[:1] == ["--planted"]
    if len(arguments) != 1 + len(LIBRARIES) + plant:
        sys.exit(__doc__)
    root, *paths = arguments[plant:]
    headers = read_headers(root)
    symbols = {library: exported(path) for library, path in zip(LIBRARIES, paths)}
    problems = compare(headers, symbols) + compare_packaged(symbols, packaged(root))
    if plant and not problems:
        problems = [f"not found: {what}" for what in planted(headers, symbols)]
    for problem in problems:
        print(problem)
    print(f"{sum(map(len, symbols.values()))} symbols, {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
