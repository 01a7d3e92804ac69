"""The Python of a page runs, block after block. SPDX-License-Identifier: Apache-2.0

usage: test_readme.py PAGE.md
"""
import re
import sys

import support  # its folder is where the page's files are written


def main():
    page = sys.argv[1]
    with open(page, encoding="utf-8") as file:
        text = file.read()
    blocks = [(match.start(), match.group(1)) for match in re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S)]
    assert blocks, f"{page} has no Python"
    namespace = {}
    for start, block in blocks:
        # line numbers of a failure are those of the page
        lines = text.count("\n", 0, start) + 1
        exec(compile("\n" * lines + block, page, "exec"), namespace)
    print(f"{len(blocks)} blocks of {page} ran in {support.FOLDER}")


if __name__ == "__main__":
    main()
