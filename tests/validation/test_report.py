#!/usr/bin/env python3
"""Tests of the pages that validation/report.py makes: every name of a table is escaped, and long curves are thinned.

usage: test_report.py SOURCE
SPDX-License-Identifier: Apache-2.0
"""
import json
import pathlib
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(SOURCE / "validation"))
import report  # noqa: E402

EVIL = "<script>alert(\"'&\")</script>"
ABOUT = {"version": EVIL, "compiler": EVIL, "machine": EVIL, "blas_core": EVIL, "dt": 0.003, "time_s": 1, "wanted": EVIL,
         "recommended_row": 0, "full": {"components": 3, "dt": 0.01, "us_per_step": 1, "cost_s_per_s": 1, "error": None}}
TABLES = {"matrix": "matrix/runs", "long": "long/long", "sweep": "sweep/sweep", "extremes": "extremes/extremes",
          "linear": "linear/linear", "tradeoff": "tradeoff/beam"}
NAMES = {"model", "case", "reason", "units", "precision", "subject"}


def page_of(kind, rows):
    """Returns the page of a committed table that is cut to `rows` rows and has all its names replaced by EVIL."""
    with tempfile.TemporaryDirectory() as name:
        folder, table = pathlib.Path(name), SOURCE / "validation" / "results" / (TABLES[kind] + ".csv")

        # the table and its companions, cut short and with names that would run as a script
        for source in [table, *table.parent.glob("units.csv"), *table.parent.glob(table.stem + "_*.csv")]:
            with open(folder / source.name, "w", encoding="utf-8", newline="") as file:
                lines = report.read(source)
                writer = report.csv.DictWriter(file, lines[0].keys())
                writer.writeheader()
                for row in lines[:rows]:
                    writer.writerow({key: EVIL if key in NAMES else value for key, value in row.items()})
        (folder / (table.stem + ".about.json")).write_text(json.dumps(ABOUT), encoding="utf-8")

        # the report makes one page of them
        run = subprocess.run([sys.executable, "-I", SOURCE / "validation" / "report.py", kind, folder / table.name],
                             capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr
        pages = list(folder.glob("*.html"))
        assert len(pages) == 1, pages
        return pages[0].read_text(encoding="utf-8")


def main():
    for kind in TABLES:
        page = page_of(kind, 40)
        assert page.endswith("</body></html>\n") and "alert" in page, kind
        assert "<script" not in page, f"{kind}: a name is not escaped"
        assert ">nan" not in page and ">inf" not in page, kind

    # a curve of many points is thinned, and keeps its extremes
    points = [(x, (-1) ** x * x) for x in range(10000)]
    thinned = report.thin(points)
    assert len(thinned) <= 402 and thinned == sorted(thinned) and max(thinned, key=lambda p: p[1]) == (9998, 9998)


main()
