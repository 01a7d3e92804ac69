#!/usr/bin/env python3
"""Links of the documentation lead to files that exist and to headings that these have.

So do names of source files in backquotes, such as `core/step/step.c`. Every page of docs/ must also be
reachable from docs/index.md, in one step or through a page that it links to.
usage: test_links.py SOURCE
SPDX-License-Identifier: Apache-2.0
"""
import os
import re
import sys

LINK = re.compile(r"\]\(([^)\s]+)\)")
NAMED = re.compile(r"`([a-z_]+/[\w/.-]+\.(?:c|h|inl|py|sh|mjs|js|md|txt|csv|json))`")
FOLDERS = {"app", "bench", "cmake", "config", "contact", "core", "docs", "driver", "examples", "include", "io", "mesh", "models", "mpi", "platform",
           "precompute", "runtime", "scene", "tests", "validation", "viewer"}


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S))


def anchors(path):
    """The anchors of a page's headings, as GitHub and GitLab make them."""
    found = set()
    for heading in re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", open(path).read(), flags=re.M | re.S), flags=re.M):
        heading = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        words = re.sub(r"[^\w\- ]", "", heading.lower())
        found.add(words.replace(" ", "-"))
    return found


def pages(source):
    for folder, folders, files in os.walk(source):
        folders[:] = [f for f in folders if f not in ("node_modules", "build", "out") and not f.startswith(".")]
        for name in files:
            if name.endswith(".md"):
                yield os.path.join(folder, name)


def main():
    source = os.path.abspath(sys.argv[1])
    wrong, links = [], {}
    for page in sorted(pages(source)):
        links[page] = set()
        text = open(page).read()
        for name in NAMED.findall(text):
            if name.split("/")[0] in FOLDERS and not os.path.exists(os.path.join(source, name)):
                wrong.append(f"{os.path.relpath(page, source)}: `{name}` is missing")
        for link in LINK.findall(without_code(text)):
            if re.match(r"[a-z]+:", link):
                continue
            target, _, anchor = link.partition("#")
            path = os.path.normpath(os.path.join(os.path.dirname(page), target)) if target else page
            links[page].add(path)
            if not os.path.exists(path):
                wrong.append(f"{os.path.relpath(page, source)}: {link} is missing")
            elif anchor and path.endswith(".md") and anchor not in anchors(path):
                wrong.append(f"{os.path.relpath(page, source)}: {link}: no such heading")

    # what the index leads to
    docs = os.path.join(source, "docs")
    reached, todo = set(), [os.path.join(docs, "index.md")]
    while todo:
        page = todo.pop()
        if page not in reached:
            reached.add(page)
            todo.extend(p for p in links.get(page, ()) if p.endswith(".md") and p.startswith(docs))
    for page in links:
        # the generated reference is linked from the pages that it belongs to
        generated = os.path.join(docs, "reference") + os.sep
        if page.startswith(docs + os.sep) and not page.startswith(generated) and page not in reached:
            wrong.append(f"{os.path.relpath(page, source)}: docs/index.md does not lead here")

    print("\n".join(wrong) or f"{len(links)} pages: all links lead somewhere")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
