#!/usr/bin/env python3
"""Tests of the pages that validation/report.py makes: no name of a table becomes markup, and long curves are thinned.

usage: test_report.py SOURCE
SPDX-License-Identifier: Apache-2.0
"""
import html.parser
import json
import pathlib
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(SOURCE / "validation"))
import report  # noqa: E402

# names that would run as a script, close an element, stand for a plot, or run a command of gnuplot or of the shell
EVIL = ["<script>alert(\"'&\")</script>", "<svg onload=alert(1)>.npz", "\"'><img src=x onerror=alert(1)>", "<!--plot 0-->",
        "</td></table></style><iframe src=javascript:alert(1)>", "]]><a href='javascript:alert(1)'>&lt;", "&#60;script&#62;",
        "'; system 'touch made'; plot '", "`touch made`", "a\nEND\nset output 'made'\n", "{0} {} %s"]
TABLES = {"matrix": "matrix/runs", "long": "long/long", "sweep": "sweep/sweep", "extremes": "extremes/extremes",
          "linear": "linear/linear", "tradeoff": "tradeoff/beam", "step_sizes": "step_sizes/runs",
          "variable": "variable/variable", "work_precision": "work_precision/work_precision"}
NAMES = {"model", "case", "reason", "units", "precision", "subject", "load", "status", "outcome", "start"}

# what the pages and gnuplot's pictures are made of
ELEMENTS = {"html", "head", "meta", "title", "style", "body", "h1", "h2", "h3", "p", "i", "code", "sup", "sub", "table", "tr",
            "th", "td", "div", "br", "svg", "desc", "defs", "circle", "path", "use", "g", "text", "tspan", "rect", "line",
            "polyline", "polygon", "lineargradient", "stop", "filter", "feflood", "fecomposite", "pattern", "a", "image"}


class Markup(html.parser.HTMLParser):
    """Collects what a browser would take for elements that are not the pages' own, and for code."""

    def __init__(self):
        super().__init__()
        self.foreign = []

    def handle_starttag(self, tag, attrs):
        code = [name for name, value in attrs if name.startswith("on") or "javascript" in (value or "")]
        if tag not in ELEMENTS or code:
            self.foreign.append((tag, attrs))

    handle_startendtag = handle_starttag

    def handle_comment(self, data):
        if data.startswith("plot"):
            self.foreign.append(("comment", data))


def page_of(kind, rows, evil):
    """Returns the page of a committed table that is cut to `rows` rows and has all its names replaced by `evil`."""
    about = {"kind": "matrix", "time": 10, "version": evil, "compiler": evil, "machine": evil, "blas_core": evil, "dt": 0.003, "time_s": 1, "wanted": evil,
             "model": evil, "loads": [evil, evil], "command": ["thrum", "tradeoff", evil], "recommended_row": 0, "full": {"components": 3, "dt": 0.01, "us_per_step": 1, "cost_s_per_s": 1, "error": None, "mesh_error": 0.231}}
    with tempfile.TemporaryDirectory() as name:
        folder, table = pathlib.Path(name), SOURCE / "validation" / "results" / (TABLES[kind] + ".csv")

        # the table and its companions, cut short and with names that would run as a script
        for source in [table, *table.parent.glob("units.csv"), *table.parent.glob(table.stem + "_*.csv")]:
            with open(folder / source.name, "w", encoding="utf-8", newline="") as file:
                lines = report.read(source)
                writer = report.csv.DictWriter(file, lines[0].keys())
                writer.writeheader()
                for row in lines[:rows]:
                    writer.writerow({key: evil if key in NAMES else value for key, value in row.items()})

        # the energies over time are not committed
        if kind == "matrix":
            with open(folder / "curves.csv", "w", encoding="utf-8", newline="") as file:
                writer = report.csv.writer(file)
                writer.writerow(["model", "load", "damping", "dt_s", "scheme", "time_s", "total_j", "explicit_modes",
                                 "implicit_modes"])
                writer.writerows([evil, evil, 0, 0.003, name, t, 1 + t, 3, 2] for name in ("imexv", "newmark") for t in range(3))
        (folder / (table.stem + ".about.json")).write_text(json.dumps(about), encoding="utf-8")

        # the report makes one page of them
        run = subprocess.run([sys.executable, "-I", SOURCE / "validation" / "report.py", kind, folder / table.name],
                             capture_output=True, text=True, check=False, cwd=folder)
        assert not (folder / "made").exists(), f"{kind}: a name was run: {evil}"
        assert run.returncode == 0, run.stderr
        pages = list(folder.glob("*.html"))
        assert len(pages) == 1, pages
        return pages[0].read_text(encoding="utf-8")


def main():
    for kind in TABLES:
        for evil in EVIL:
            page = page_of(kind, 12, evil)
            assert page.endswith("</body></html>\n") and html.escape(evil) in page, f"{kind}: {evil} is not shown"
            assert ">nan" not in page and ">inf" not in page, kind

            # nothing but the names themselves has come into the page
            markup = Markup()
            markup.feed(page)
            assert not markup.foreign, f"{kind}: {evil} became {markup.foreign}"

    # the page of a trade-off says of what it is, which row is taken, and how wrong the mesh is
    page = page_of("tradeoff", 12, "beam.npz")
    for text in ("Model beam.npz", "thrum tradeoff beam.npz", "too high", "23 %", ">recommended<"):
        assert text in page, text

    # there is one place that escapes, so that no other one can forget to
    assert (SOURCE / "validation" / "report.py").read_text(encoding="utf-8").count("html.escape") == 1

    # a curve of many points is thinned, and keeps its extremes
    points = [(x, (-1) ** x * x) for x in range(10000)]
    thinned = report.thin(points)
    assert len(thinned) <= 402 and thinned == sorted(thinned) and max(thinned, key=lambda p: p[1]) == (9998, 9998)


main()
