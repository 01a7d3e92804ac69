"""Forces of the file of `export --nlvib`, multiplied out in scipy and in Octave, are those of the model.

SPDX-License-Identifier: Apache-2.0"""
import importlib.util
import pathlib
import subprocess
import sys
import tempfile

import numpy
import scipy.io

PROGRAM, OCTAVE = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""


def run(*arguments, code=0):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    assert done.returncode == code, (arguments, done.returncode, done.stderr)
    return done.stderr


def load(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        model, mat, code = folder / "beam.npz", folder / "beam.mat", folder / "beam_arrays.py"
        run("precompute", "beam:6x1x1@1x0.1x0.1", "--fix", "x<0.001", "--modes", "3", "--rank", "5", "-o", str(model), "-q")
        run("export", str(model), "--nlvib", str(mat), "--damping", "0.5,1e-3", "--damping-ratio", "0.01,0.02", "--at", "tip",
            "--numpy", str(code))
        arrays = scipy.io.loadmat(mat)
        M, D, K, p, E, T = (arrays[key] for key in "MDKpET")
        r = len(K)
        assert p.shape == E.shape == (15 + 35, r) and T.shape == (3, r)

        # the linear part: unit mass, omega squared, and D = alpha + beta omega^2 + 2 zeta omega of the three modes, of which
        # the others have the least
        omega2 = numpy.load(model)["omega2"]
        rates = 2 * numpy.array([0.01, 0.02, 0.02]) * omega2[:3] ** 0.5
        rates = numpy.append(rates, [min(rates)] * (r - 3))
        assert (M == numpy.eye(r)).all() and (K == numpy.diag(omega2)).all()
        assert numpy.allclose(D, numpy.diag(0.5 + 1e-3 * omega2 + rates), rtol=1e-14)

        # f = K q + E' z beside the force of another export, at a large displacement
        q = numpy.random.default_rng(7).normal(size=r) * 300 / omega2**0.5
        wanted = load(code).force(q)
        found = K @ q + E.T @ numpy.prod(q**p, axis=1)
        assert abs(wanted - K @ q).max() > 0.1 * abs(wanted).max(), "the forces are hardly nonlinear"
        assert abs(found - wanted).max() < 1e-12 * abs(wanted).max(), (found, wanted)

        # the same words in Octave
        if OCTAVE:
            text = f"load('{mat}'); q = [{'; '.join(repr(float(x)) for x in q)}]; printf('%.17g ', K*q + E'*prod(q'.^p, 2));"
            out = subprocess.run([OCTAVE, "--norc", "--eval", text], capture_output=True, text=True, check=True).stdout
            assert abs(numpy.array(out.split(), float) - wanted).max() < 1e-12 * abs(wanted).max(), out

        # what has no polynomial of all its coordinates is refused, and leaves no file
        run("precompute", "beam:6x1x1@1x0.1x0.1", "--fix", "x<0.001", "--modes", "3", "--rank", "6", "--condense", "-o", str(model), "-q")
        mat.unlink()
        assert "condensed" in run("export", str(model), "--nlvib", str(mat), code=1)
        assert not mat.exists()


main()
