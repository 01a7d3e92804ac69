#!/usr/bin/env python3
"""The pages that validation/report.py makes: every name of a table is escaped, and a table that is empty has a page.

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
    """The page of a committed table cut to `rows` rows, all of whose names are replaced by EVIL."""
    with tempfile.TemporaryDirectory() as name:
        folder, table = pathlib.Path(name), SOURCE / "validation" / "results" / (TABLES[kind] + ".csv")
        for source in [table, *table.parent.glob("units.csv"), *table.parent.glob(table.stem + "_*.csv")]:
            with open(folder / source.name, "w", encoding="utf-8", newline="") as file:
                lines = report.read(source)
                writer = report.csv.DictWriter(file, lines[0].keys())
                writer.writeheader()
                for row in lines[:rows]:
                    writer.writerow({key: EVIL if key in NAMES else value for key, value in row.items()})
        (folder / (table.stem + ".about.json")).write_text(json.dumps(ABOUT), encoding="utf-8")
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
    points = [(x, (-1) ** x * x) for x in range(10000)]
    thinned = report.thin(points)
    assert len(thinned) <= 402 and thinned == sorted(thinned) and max(thinned, key=lambda p: p[1]) == (9998, 9998)


main()
