"""What the tests of the Python package share: models that the program makes once. SPDX-License-Identifier: Apache-2.0"""
import atexit
import os
import shutil
import tempfile

import thrum

FOLDER = tempfile.mkdtemp(prefix="thrum-python-")
atexit.register(shutil.rmtree, FOLDER, True)
# whatever the tests write beside themselves ends here
os.chdir(FOLDER)


def model_file(name, mesh, **options):
    path = os.path.join(FOLDER, name + ".npz")
    if not os.path.exists(path):
        thrum.precompute(mesh, path, **options)
    return path


def beam_file():
    """A cantilever of 1 m: rank 12, 6 modes."""
    return model_file("beam", "beam:8x2x2@1x0.15x0.15,split=6", fix="x<0.001", order=1, modes=6, rank=12)


def block_file():
    """A free cube of 0.2 m."""
    return model_file("block", "beam:2x2x2@0.2x0.2x0.2,split=6", order=1, modes=3, rank=6)


def beam():
    return thrum.Model.load(beam_file())


def block():
    return thrum.Model.load(block_file())
