#!/usr/bin/env python3
"""The bill of materials of a release, as CycloneDX 1.5 in JSON: every artefact with its hash, what of others it holds,
what it needs and does not hold, and the tools that made it.

usage: bill.py SOURCE ARTEFACTS ARCHIVES   writes the bill of a folder of artefacts; ARCHIVES lists the libraries inside
                                           the relocatable program, one a line
       bill.py --check ARTEFACTS           demands that the bill and SHA256SUMS say what lies in the folder

SOURCE_DATE_EPOCH is its time. Runs on Debian, whose packages it asks for versions and licences.
SPDX-License-Identifier: Apache-2.0
"""
import base64
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import urllib.parse
import uuid

# the names of Debian's copyright files that are not SPDX's; those of neither stay names
SPDX = {"apache-2.0": "Apache-2.0", "apache-2-llvm-exceptions": "Apache-2.0 WITH LLVM-exception", "bsd-2-clause": "BSD-2-Clause",
        "bsd-3-clause": "BSD-3-Clause", "cc0-1.0": "CC0-1.0", "expat": "MIT", "mit": "MIT", "isc": "ISC", "zlib": "Zlib",
        "gpl-2+": "GPL-2.0-or-later", "gpl-3+": "GPL-3.0-or-later", "lgpl-2.1+": "LGPL-2.1-or-later", "ofl-1.1": "OFL-1.1"}
# gcc's copyright file has no fields; its run-time libraries carry the exception
GCC = "GPL-3.0-or-later WITH GCC-exception-3.1"
WASM = ("wasi-libc", "libclang-rt-14-dev-wasm32")
SITE = ("sphinx-rtd-theme-common", "libjs-sphinxdoc", "libjs-jquery", "libjs-underscore", "fonts-lato", "fonts-font-awesome")
TOOLS = ("binutils", "clang-14", "cmake", "debhelper", "doxygen", "dpkg-dev", "g++-12", "gcc-12", "gcc-12-aarch64-linux-gnu",
         "jupyter-nbconvert", "libc6-dev", "libc6-dev-arm64-cross", "lld-14", "ninja-build", "python3-breathe", "python3-cffi",
         "python3-matplotlib", "python3-myst-parser", "python3-numpy", "python3-setuptools", "python3-sphinx", "python3-wheel",
         "python3.11", "tetgen")


def output(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout.strip()


def licences_of(package):
    """What the copyright file of a Debian package names, as CycloneDX has licences."""
    if re.match(r"(lib)?(gcc|gfortran|quadmath|gomp)", package):
        return [{"expression": GCC}]
    text = pathlib.Path(f"/usr/share/doc/{package}/copyright").read_text(encoding="utf-8", errors="replace")
    names = set()
    for line in re.findall(r"^License:[ \t]*(\S.*)$", text, flags=re.M | re.I):
        names.update(word.strip() for word in re.split(r",|\band\b|\bor\b", line) if word.strip())
    known = {SPDX.get(name.lower(), name) for name in names}
    return [{"license": {"id" if name in SPDX.values() and " WITH " not in name else "name": name}} for name in sorted(known)] or \
           [{"license": {"name": f"see /usr/share/doc/{package}/copyright"}}]


def of_debian(package, scope="required"):
    """A component that is a Debian package as it is installed here."""
    version, source, source_version, architecture = output(
        "dpkg-query", "-W", "-f", "${Version}|${source:Package}|${source:Version}|${Architecture}", package).split("|")
    place = f"pkg:deb/debian/{package}@{urllib.parse.quote(version, safe='.+~-')}?arch={architecture}&distro=debian-12"
    return {"type": "library" if scope == "required" else "application", "bom-ref": place, "name": package, "version": version,
            "scope": scope, "licenses": licences_of(package), "purl": place,
            "properties": [{"name": "debian:source", "value": f"{source} {source_version}"}]}


def of_npm(source, folder, name, scope="required"):
    """A component that is a package of npm as the lock file pins it."""
    entry = json.loads((source / folder / "package-lock.json").read_text())["packages"][f"node_modules/{name}"]
    algorithm, _, digest = entry["integrity"].partition("-")
    place = f"pkg:npm/{name}@{entry['version']}"
    return {"type": "library" if scope == "required" else "application", "bom-ref": place, "name": name,
            "version": entry["version"], "scope": scope, "licenses": [{"license": {"id": entry["license"]}}], "purl": place,
            "hashes": [{"alg": algorithm.upper().replace("SHA", "SHA-"), "content": base64.b64decode(digest).hex()}]}


def needed(artefact, folder):
    """What an artefact names as needed and does not hold: [(name, purl)]."""
    path = folder / artefact
    if artefact.endswith(".deb"):
        names = output("dpkg-deb", "-f", str(path), "Depends").replace("\n", " ").split(",")
        return [(found, f"pkg:deb/debian/{found}") for found in (re.sub(r"[\s(:|].*", "", name.strip()) for name in names)
                if found and "thrum" not in found]
    if artefact.endswith(".whl"):
        return [(name, f"pkg:pypi/{name}") for name in ("cffi", "numpy")]
    return []


def packages_of(archives):
    """The Debian packages that files come from; /lib and /usr/lib are one folder."""
    found = set()
    for file in archives:
        file = os.path.realpath(file)
        for place in (file, file.removeprefix("/usr")):
            asked = subprocess.run(["dpkg", "-S", place], capture_output=True, text=True)
            if asked.returncode == 0:
                found.add(asked.stdout.split(":")[0])
                break
        else:
            raise SystemExit(f"bill.py: no package of Debian has {file}")
    return sorted(found)


def held(artefact, inside):
    """The parts of others within an artefact, by the end of its name."""
    for pattern, parts in ((r"-linux-x86_64\.tar\.gz$", "program"), (r"-npm\.tgz$", "wasm"), (r"^thrum-viewer_.*\.deb$", "viewer"),
                           (r"-site\.tar\.gz$", "site")):
        if re.search(pattern, artefact):
            return inside[parts]
    return []


def bill(source, folder, archives):
    """The whole bill, a dictionary."""
    version = re.search(r'THRUM_VERSION_STRING "(.*)"', (source / "include/thrum/version.h").read_text()).group(1)
    commit = output("git", "-C", str(source), "rev-parse", "HEAD")
    wasm = [of_debian(name) for name in WASM]
    viewer = wasm + [of_npm(source, "viewer", "three")]
    inside = {"program": [of_debian(name) for name in packages_of(archives)], "wasm": wasm, "viewer": viewer,
              "site": viewer + [of_debian(name) for name in SITE]}
    parts = {part["bom-ref"]: part for parts in inside.values() for part in parts}
    tools = [of_debian(name, "excluded") for name in TOOLS] + [of_npm(source, "viewer", "esbuild", "excluded")]
    node = output("node", "--version").lstrip("v")
    tools.append({"type": "application", "bom-ref": f"pkg:generic/node@{node}", "name": "node", "version": node, "scope": "excluded",
                  "licenses": [{"license": {"id": "MIT"}}], "purl": f"pkg:generic/node@{node}"})

    artefacts, depends, outside = [], [], {}
    for path in sorted(path for path in folder.iterdir() if path.name != "SHA256SUMS" and not path.name.endswith(".cdx.json")):
        reference = f"artefact:{path.name}"
        artefacts.append({"type": "file", "bom-ref": reference, "name": path.name, "version": version,
                          "licenses": [{"license": {"id": "Apache-2.0"}}],
                          "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(path.read_bytes()).hexdigest()}]})
        wanted = needed(path.name, folder)
        for name, place in wanted:
            outside[place] = {"type": "library", "bom-ref": place, "name": name, "scope": "required", "purl": place,
                              "properties": [{"name": "thrum:place", "value": "needed, and not inside"}]}
        depends.append({"ref": reference, "dependsOn": sorted({part["bom-ref"] for part in held(path.name, inside)} |
                                                              {place for _, place in wanted})})
    whole = f"pkg:github/thrum/thrum@{commit}"
    components = artefacts + [parts[key] for key in sorted(parts)] + [outside[key] for key in sorted(outside)] + \
        sorted((tool for tool in tools if tool["bom-ref"] not in parts), key=lambda tool: tool["bom-ref"])
    time = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    digest = hashlib.sha256(json.dumps(components, sort_keys=True).encode()).hexdigest()
    return {"bomFormat": "CycloneDX", "specVersion": "1.5", "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, whole + digest)}",
            "version": 1,
            "metadata": {"timestamp": time.strftime("%Y-%m-%dT%H:%M:%SZ"),
                         "component": {"type": "library", "bom-ref": whole, "name": "thrum", "version": version, "purl": whole,
                                       "licenses": [{"license": {"id": "Apache-2.0"}}]}},
            "components": components,
            "dependencies": [{"ref": whole, "dependsOn": sorted(part["bom-ref"] for part in artefacts)}] + depends}


def faults(folder):
    """What is wrong with a folder of artefacts: a list of lines."""
    wrong = []
    names = sorted(path.name for path in folder.iterdir())
    bills = [name for name in names if name.endswith(".cdx.json")]
    if len(bills) != 1:
        return [f"{len(bills)} bills of materials"]
    listed = dict(reversed(line.split("  ", 1)) for line in (folder / "SHA256SUMS").read_text().splitlines())
    for name in names:
        digest = hashlib.sha256((folder / name).read_bytes()).hexdigest()
        if name != "SHA256SUMS" and listed.pop(name, "") != digest:
            wrong.append(f"SHA256SUMS has another {name}, or none")
    wrong += [f"SHA256SUMS names {name}, which is missing" for name in listed]

    said = json.loads((folder / bills[0]).read_text())
    references = [part["bom-ref"] for part in said["components"]] + [said["metadata"]["component"]["bom-ref"]]
    wrong += [f"the bill has {name} twice" for name in sorted({name for name in references if references.count(name) > 1})]
    files = {part["name"]: part["hashes"][0]["content"] for part in said["components"] if part["type"] == "file"}
    for name in names:
        if name not in ("SHA256SUMS", bills[0]) and files.pop(name, "") != hashlib.sha256((folder / name).read_bytes()).hexdigest():
            wrong.append(f"the bill has another {name}, or none")
    wrong += [f"the bill has {name}, which is missing" for name in files]
    for part in said["components"]:
        if part["type"] != "file" and "properties" in part and part["properties"][0]["name"] == "thrum:place":
            continue
        wrong += [f"the bill says no {key} of {part['name']}" for key in ("version", "licenses") if not part.get(key)]
    for entry in said["dependencies"]:
        wrong += [f"the bill has no component {name}" for name in [entry["ref"], *entry["dependsOn"]] if name not in references]
    return wrong


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--check":
        wrong = faults(pathlib.Path(sys.argv[2]))
        for line in wrong:
            print(f"bill.py: {line}", file=sys.stderr)
        return 1 if wrong else 0
    if len(sys.argv) != 4:
        sys.stderr.write(__doc__)
        return 2
    archives = pathlib.Path(sys.argv[3]).read_text().split()
    print(json.dumps(bill(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), archives), indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
