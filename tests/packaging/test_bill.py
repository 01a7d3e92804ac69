#!/usr/bin/env python3
"""The bill of materials of a release names every artefact, what these hold and what they need, the same each time; a file
that was changed, added or removed afterwards is found.

usage: test_bill.py SOURCE
SPDX-License-Identifier: Apache-2.0
"""
import hashlib
import json
import os
import pathlib
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / "packaging"))
import bill  # noqa: E402

ARTEFACTS = ["thrum-0.2.0-linux-x86_64.tar.gz", "thrum-0.2.0-npm.tgz", "thrum-0.2.0-py3-none-manylinux_2_17_x86_64.whl",
             "thrum-0.2.0-source.tar.gz"]


def said(*words):
    """Stands for the programs that a bill asks, so that the test needs no package of Debian."""
    return {"git": "0123456789abcdef", "node": "v20.1.0", "dpkg-query": "1.2-3|source|1.2-3|amd64"}[words[0]]


class Bill(unittest.TestCase):
    def setUp(self):
        os.environ["SOURCE_DATE_EPOCH"] = "1700000000"
        bill.output, bill.licences_of = said, lambda package: [{"license": {"id": "MIT"}}]
        bill.packages_of = lambda archives: ["libexpat1-dev"]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for name in ARTEFACTS:
            (self.folder / name).write_text(name)
        self.made = bill.bill(SOURCE, self.folder, [])
        (self.folder / "thrum-0.2.0.cdx.json").write_text(json.dumps(self.made))
        sums = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in self.folder.iterdir()]
        (self.folder / "SHA256SUMS").write_text("".join(sums))

    def needs(self, artefact):
        return next(entry["dependsOn"] for entry in self.made["dependencies"] if entry["ref"] == f"artefact:{artefact}")

    def test_names_what_is_inside_and_what_is_needed(self):
        self.assertEqual(bill.faults(self.folder), [])
        self.assertEqual([name.split("@")[0] for name in self.needs(ARTEFACTS[0])], ["pkg:deb/debian/libexpat1-dev"])
        self.assertTrue(any("wasi-libc" in name for name in self.needs(ARTEFACTS[1])))
        self.assertEqual(self.needs(ARTEFACTS[2]), ["pkg:pypi/cffi", "pkg:pypi/numpy"])
        self.assertEqual(self.needs(ARTEFACTS[3]), [])
        self.assertEqual(self.made["metadata"]["timestamp"], "2023-11-14T22:13:20Z")

    def test_is_the_same_again(self):
        self.assertEqual(json.dumps(self.made), json.dumps(bill.bill(SOURCE, self.folder, [])))

    def test_finds_what_differs(self):
        (self.folder / ARTEFACTS[0]).write_text("changed")
        (self.folder / ARTEFACTS[1]).unlink()
        (self.folder / "new.whl").write_text("new")
        found = bill.faults(self.folder)
        for line in (f"SHA256SUMS has another {ARTEFACTS[0]}, or none", f"the bill has another {ARTEFACTS[0]}, or none",
                     f"SHA256SUMS names {ARTEFACTS[1]}, which is missing", f"the bill has {ARTEFACTS[1]}, which is missing",
                     "SHA256SUMS has another new.whl, or none", "the bill has another new.whl, or none"):
            self.assertIn(line, found)
        self.assertEqual(len(found), 6)

    def test_finds_a_bill_that_is_not_whole(self):
        path = self.folder / "thrum-0.2.0.cdx.json"
        part = next(part for part in self.made["components"] if part["name"] == "three")
        del part["licenses"]
        self.made["dependencies"].append({"ref": "artefact:unknown", "dependsOn": []})
        self.made["components"].append(part)
        path.write_text(json.dumps(self.made))
        found = bill.faults(self.folder)
        for line in ("the bill says no licenses of three", "the bill has no component artefact:unknown",
                     f"the bill has {part['bom-ref']} twice"):
            self.assertIn(line, found)


if __name__ == "__main__":
    unittest.main()
