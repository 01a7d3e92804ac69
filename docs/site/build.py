#!/usr/bin/env python3
"""Builds the documentation as a site: pages, notebooks, references of C, Python and JavaScript, the viewer, search.

usage: build.py SOURCE BUILD OUTPUT    with the program, the viewer and the Python package in BUILD

A warning of Sphinx or Doxygen fails it, and so does a link within the site that leads nowhere.
Needs Debian's python3-sphinx, python3-myst-parser, python3-breathe, python3-sphinx-rtd-theme, doxygen, jupyter-nbconvert,
python3-ipykernel and python3-matplotlib. SPDX-License-Identifier: Apache-2.0
"""
import html
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse

SOURCE, BUILD, OUTPUT = (pathlib.Path(argument).resolve() for argument in (sys.argv[1:] + ["."] * 3)[:3])
STAGE, PAGES = OUTPUT / "stage", OUTPUT / "html"
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\])\(([^)\s]+)\)")
NOTEBOOKS = {"swinging_hook": "From an STL file to a swinging model", "energy_drift": "The energy of each integrator",
             "tradeoff": "How accurate, and at what cost?", "training": "Training a basis"}

# the menu: caption, pages by their place in the tree
MENU = [
    ("Start", ["README.md", "docs/tutorial.md", "site/viewer.md", "packaging/README.md"]),
    ("Guides", ["docs/how-to/make_a_model.md", "docs/how-to/simulate_and_look.md", "docs/how-to/build_a_scene.md",
                "docs/how-to/choose_rank_and_step.md", "docs/how-to/use_in_a_program.md", "python/README.md",
                "javascript/README.md", "docs/how-to/run_a_sweep.md", "docs/how-to/repeat_the_results.md"]),
    ("Notebooks", [f"site/{name}.md" for name in NOTEBOOKS]),
    ("Understand", ["docs/which_integrator.md", "docs/limits_and_platforms.md", "docs/mathematics/README.md",
                    "docs/contact.md", "docs/links.md", "docs/determinism.md", "docs/condensed.md", "docs/tradeoff.md",
                    "docs/verification.md", "docs/experiments.md", "docs/bench.md", "docs/beside_mujoco.md"]),
    ("Reference", ["docs/reference/commands.md", "docs/reference/scene_keys.md", "site/c.md", "site/python.md",
                   "site/javascript.md", "docs/index.md"]),
    ("Change Thrum", ["CONTRIBUTING.md", "CHANGELOG.md"]),
]
# what the menu calls pages whose heading is for those who read the tree
TITLES = {"README.md": "What Thrum is", "packaging/README.md": "Install: packages and a tarball", "python/README.md": "Use it from Python",
          "javascript/README.md": "Use it from JavaScript", "docs/index.md": "All pages"}


def run(*words, **options):
    subprocess.run([str(word) for word in words], check=True, **options)


def tracked():
    """Every file of the tree that is, or would be, under version control."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=SOURCE, check=True,
                            capture_output=True, text=True).stdout.splitlines()
    return sorted({name for name in listed if (SOURCE / name).is_file()})


# --- pages of the tree ---------------------------------------------------------------------------


def without_code(text):
    """The text with code blanked out, and of the same length."""
    blank = lambda found: re.sub(r"[^\n]", " ", found.group(0))
    return re.sub(r"`[^`\n]*`", blank, re.sub(r"^```.*?^```$", blank, text, flags=re.M | re.S))


def stage_page(name, names):
    """Copies a page. Links to folders lead to their README; those to other files hand these out."""
    folder = os.path.dirname(name)
    text = (SOURCE / name).read_text(encoding="utf-8")
    places = [found for found in LINK.finditer(text)]
    plain = without_code(text)
    for found in reversed(places):
        target, hash_sign, anchor = found.group(2).partition("#")
        if not plain[found.start(2):found.end(2)].strip() or not target or re.match(r"[a-z]+:", target):
            continue
        path = os.path.normpath(os.path.join(folder, target))
        if (SOURCE / path).is_dir():
            readme = os.path.join(path, "README.md")
            # a folder without a page of its own is named, and not linked
            new = f"{found.group(1)}({os.path.relpath(readme, folder or '.')})" if readme in names else found.group(1)[1:-1]
            text = text[:found.start()] + new + text[found.end():]
        elif not path.endswith(".md") and path in names:
            copy = STAGE / path
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(SOURCE / path, copy)
            if not found.group(1).startswith("!"):
                text = text[:found.start()] + f"{{download}}`{found.group(1)[1:-1].strip('`')} <{os.path.relpath(path, folder or '.')}>`" + text[found.end():]
    # a page that the menu does not list is reached by links
    if not any(name in pages for _, pages in MENU):
        text = "---\norphan: true\n---\n" + text
    place = STAGE / name
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(text, encoding="utf-8")


def stage_index():
    """The first page: what Thrum is, and the menu."""
    lines = ["# Thrum", "", "Real-time deformable bodies that keep their energy: a library in C, and packages for Python, "
             "JavaScript and Debian.", "",
             # the README has this picture too, so it is staged
             "![Six models under load, coloured by displacement](docs/models_under_load.png)", "",
             "Start with [the tutorial](docs/tutorial.md), [pull at a body](site/viewer.md) in this browser, "
             "or read [what it is good for, and what not](README.md#what-it-is-good-for-and-what-not).", ""]
    for caption, pages in MENU:
        lines += ["```{toctree}", f":caption: {caption}", ":maxdepth: 1", "",
                  *(f"{TITLES[page]} <{page}>" if page in TITLES else page for page in pages), "```", ""]
    (STAGE / "index.md").write_text("\n".join(lines), encoding="utf-8")


# --- what is made ----------------------------------------------------------------------------------


def stage_viewer():
    """Pages of the viewer, each with its own models, in frames."""
    folder = STAGE / "extra/viewer"
    folder.mkdir(parents=True)
    for name in ("horse", "bridge"):
        run(BUILD / "thrum", "view", name, "-q", "-o", folder / f"{name}.html", stdout=subprocess.DEVNULL)
    (STAGE / "site/viewer.md").write_text("""# Pull at a body

The engine runs in this page, as WebAssembly: drag the body to pull it, drag beside it to look around. The
[viewer's page](../docs/viewer.md) explains the controls; `thrum view` makes such a page of a model of your own.

```{raw} html
<iframe class="viewer" src="../viewer/horse.html" title="A horse to pull at" loading="lazy"></iframe>
<p><a href="../viewer/horse.html">The horse in a page of its own</a>, and <a href="../viewer/bridge.html">a bridge</a>.</p>
```
""", encoding="utf-8")


def stage_notebooks():
    """Runs the notebooks; what a cell shows as a page within the page becomes a file.

    Cells tagged `measured` show times of the machine. A build that is to give the same bytes again, which
    SOURCE_DATE_EPOCH asks for, runs them and leaves out what they show.
    """
    repeated = "SOURCE_DATE_EPOCH" in os.environ
    environment = dict(os.environ, PYTHONPATH=str(BUILD / "python"), THRUM_PROGRAM=str(BUILD / "thrum"),
                       PYTHONWARNINGS="ignore::RuntimeWarning")
    for name in NOTEBOOKS:
        source = SOURCE / f"examples/notebooks/{name}.ipynb"
        run("/usr/bin/python3", "-m", "nbconvert", "--to", "notebook", "--execute", "--log-level=WARN",
            "--ExecutePreprocessor.timeout=300", "--output-dir", OUTPUT / "executed", source,
            cwd=SOURCE / "examples/notebooks", env=environment)
        run("/usr/bin/python3", "-m", "nbconvert", "--to", "markdown", "--log-level=WARN", "--output-dir", STAGE / "site",
            *(["--TagRemovePreprocessor.remove_all_outputs_tags", "measured"] if repeated else []),
            OUTPUT / f"executed/{name}.ipynb", env=environment)
        page = STAGE / f"site/{name}.md"
        text = page.read_text(encoding="utf-8")
        found = re.search(r'<iframe srcdoc="([^"]*)"[^>]*></iframe>', text)
        if found:
            (STAGE / f"extra/viewer/{name}.html").write_text(html.unescape(found.group(1)), encoding="utf-8")
            frame = f'```{{raw}} html\n<iframe class="viewer" src="../viewer/{name}.html" title="{name}"></iframe>\n```'
            text = text[:found.start()] + frame + text[found.end():]
        # paths of this machine say nothing to a reader
        text = text.replace(str(BUILD), "build/release").replace(str(SOURCE) + "/", "")
        note = f"*This page is the notebook {{download}}`{name}.ipynb <{name}.ipynb>`, run when the site was built.*\n\n"
        if repeated and '"measured"' in source.read_text(encoding="utf-8"):
            note += "*What it measures differs from run to run and is left out here: run it on your own machine.*\n\n"
        shutil.copy(source, STAGE / f"site/{name}.ipynb")
        title, _, rest = text.partition("\n")
        page.write_text(f"{title}\n\n{note}{rest}", encoding="utf-8")


def stage_c():
    """The C reference out of the headers, by Doxygen and Breathe, a section for each header."""
    settings = (BUILD / "reference/Doxyfile").read_text(encoding="utf-8")
    made = OUTPUT / "doxygen"
    made.mkdir(parents=True)
    (made / "Doxyfile").write_text(settings + f"\nOUTPUT_DIRECTORY = {made}\nGENERATE_HTML = NO\nGENERATE_XML = YES\n",
                                   encoding="utf-8")
    run("doxygen", made / "Doxyfile", stdout=subprocess.DEVNULL)
    # the licence of each file stands at the foot of every page
    for path in (made / "xml").glob("*.xml"):
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r"(<para>)?SPDX-License-Identifier: Apache-2.0\s*(</para>)?",
                               lambda found: "" if found.group(1) and found.group(2) else found.group(1) or found.group(2) or "",
                               text), encoding="utf-8")
    intro = (SOURCE / "docs/reference/c_api.md").read_text(encoding="utf-8").partition("\n")[2]
    text = "# C reference\n" + intro
    for header in sorted((SOURCE / "include/thrum").glob("*.h")):
        text += f"\n## {header.name}\n\n```{{doxygenfile}} {header.name}\n:project: thrum\n```\n"
    (STAGE / "site/c.md").write_text(text, encoding="utf-8")
    return made / "xml"


def stage_python():
    """The Python reference out of the docstrings."""
    sys.path.insert(0, str(BUILD / "python"))
    import thrum  # noqa: PLC0415 # built beside the site

    functions = [name for name in thrum.__all__ if not isinstance(getattr(thrum, name), type)]
    classes = [name for name in thrum.__all__ if isinstance(getattr(thrum, name), type)]
    text = "# Python reference\n\nThe [guide](../python/README.md) shows how they go together. r is the number of coordinates " \
           "that are stepped, n the number of vertices; quantities are SI.\n"
    for title, names, directive in (("Classes", [n for n in classes if not issubclass(getattr(thrum, n), BaseException)], "autoclass"),
                                    ("Functions", functions, "autofunction"),
                                    ("Exceptions", [n for n in classes if issubclass(getattr(thrum, n), BaseException)], "autoexception")):
        text += f"\n## {title}\n"
        for name in names:
            members = ":members:\n" if directive == "autoclass" else ":no-undoc-members:\n" if directive == "autoexception" else ""
            text += f"\n```{{eval-rst}}\n.. {directive}:: thrum.{name}\n"
            text += "".join(f"   {line}\n" for line in members.splitlines()) + "```\n"
    (STAGE / "site/python.md").write_text(text, encoding="utf-8")


def stage_javascript():
    """The JavaScript reference out of its types: a section for each that is exported."""
    lines = (SOURCE / "javascript/src/index.d.ts").read_text(encoding="utf-8").splitlines()
    text = "# JavaScript reference\n\nThe [guide](../javascript/README.md) shows how they go together. " \
           "r is a model's rank, n its number of vertices; quantities are SI.\n"
    # each block that begins at the margin, with the comment before it
    block, comment, depth = [], "", 0
    for line in lines:
        if depth == 0 and not block:
            found = re.match(r"/\*\*\s*(.*?)\s*\*/$", line)
            if found:
                comment = found.group(1)
                continue
            if not re.match(r"(export|interface|declare)\b", line):
                if line.startswith("/**"):
                    comment = line[3:].strip()
                elif comment and line.startswith(" *"):
                    comment += " " + line.strip(" */")
                continue
        block.append(line)
        depth += line.count("{") - line.count("}")
        if depth == 0 and line.rstrip().endswith((";", "}")):
            name = re.search(r"(?:class|interface|type|function|const)\s+(\w+)", block[0])
            text += f"\n## {name.group(1) if name else block[0]}\n\n{comment}\n\n```ts\n" + "\n".join(block) + "\n```\n"
            block, comment = [], ""
    (STAGE / "site/javascript.md").write_text(text, encoding="utf-8")


# --- the site ------------------------------------------------------------------------------------


class Page(html.parser.HTMLParser):
    """The anchors and the links of a page."""

    def __init__(self):
        super().__init__()
        self.anchors, self.links = set(), []

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def check_links():
    """Every link within the site leads to a file and, in pages, to an anchor that is there."""
    pages = {}
    for path in sorted(PAGES.rglob("*.html")):
        if "viewer" not in path.relative_to(PAGES).parts[:1]:
            pages[path] = Page()
            pages[path].feed(path.read_text(encoding="utf-8"))
    wrong = []
    count = 0
    # what style sheets load, such as fonts; a query or a fragment behind the name is no part of it
    for path in sorted(PAGES.rglob("*.css")):
        for link in re.findall(r"url\(\s*['\"]?([^)'\"]+)", path.read_text(encoding="utf-8")):
            if not re.match(r"[a-z]+:|//|#", link):
                count += 1
                if not (path.parent / urllib.parse.unquote(re.split(r"[?#]", link)[0])).exists():
                    wrong.append(f"{path.relative_to(PAGES)}: {link} is missing")
    for path, page in pages.items():
        for link in page.links:
            if re.match(r"[a-z]+:|//", link):
                continue
            count += 1
            target, _, anchor = urllib.parse.unquote(link).partition("#")
            target = target.partition("?")[0]
            there = (path.parent / target).resolve() if target else path
            if not there.exists():
                wrong.append(f"{path.relative_to(PAGES)}: {link} is missing")
            elif anchor and there in pages and anchor not in pages[there].anchors:
                wrong.append(f"{path.relative_to(PAGES)}: {link}: no such anchor")
    for line in wrong:
        print(line, file=sys.stderr)
    print(f"{len(pages)} pages, {count} links within them, {len(wrong)} that lead nowhere")
    return not wrong


def main():
    if len(sys.argv) != 4:
        sys.stderr.write(__doc__)
        return 2
    shutil.rmtree(OUTPUT, ignore_errors=True)
    (STAGE / "site").mkdir(parents=True)
    (STAGE / "_static").mkdir()
    shutil.copy(SOURCE / "docs/site/thrum.css", STAGE / "_static/thrum.css")
    shutil.copy(SOURCE / "docs/site/conf.py", STAGE / "conf.py")

    names = tracked()
    for name in names:
        if name.endswith(".md"):
            stage_page(name, set(names))
    stage_index()
    stage_viewer()
    stage_notebooks()
    doxygen = stage_c()
    stage_python()
    stage_javascript()
    version = re.search(r'THRUM_VERSION_STRING "(.*)"', (SOURCE / "include/thrum/version.h").read_text()).group(1)
    (STAGE / "site.json").write_text(json.dumps({"version": version, "doxygen": str(doxygen)}))

    environment = dict(os.environ, PYTHONPATH=str(BUILD / "python"))
    run("/usr/bin/python3", "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", OUTPUT / "doctrees", STAGE, PAGES, env=environment)
    if not check_links():
        return 1
    print(PAGES / "index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
