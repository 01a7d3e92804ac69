#!/usr/bin/env python3
"""A notebook runs from its first cell to its last without an error, says something, and is committed without outputs.

usage: test_notebook.py NOTEBOOK [TEXT OF AN OUTPUT]   with THRUM_PROGRAM and PYTHONPATH set
SPDX-License-Identifier: Apache-2.0
"""
import os
import sys

import nbclient
import nbformat


def main() -> int:
    path = sys.argv[1]
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    if any(cell.outputs or cell.execution_count for cell in cells):
        print(f"{path}: it has outputs; clear them (jupyter nbconvert --clear-output --inplace)")
        return 1

    # the folder of the notebook is where its files are
    client = nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3",
                                     resources={"metadata": {"path": os.path.dirname(os.path.abspath(path))}})
    client.execute()
    outputs = [output for cell in cells for output in cell.outputs]
    pictures = sum("image/png" in output.get("data", {}) for output in outputs)
    text = str(outputs)
    print(f"{os.path.basename(path)}: {len(cells)} cells, {len(outputs)} outputs, {pictures} pictures")
    if pictures == 0:
        print(f"{path}: it drew no picture")
        return 1
    missing = [word for word in sys.argv[2:] if word not in text]
    if missing:
        print(f"{path}: no output has {missing}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
