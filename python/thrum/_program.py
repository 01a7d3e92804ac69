"""The program thrum, for what the run time does not do: precompute, runs with records, statics, the trade-off.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import csv
import importlib
import json
import keyword
import os
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Union

import numpy as np
import numpy.typing as npt

from . import _mesh
from ._errors import ProgramFailed
from ._native import warn

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import PrecomputeOptions, SimulateOptions, StaticOptions
    from .model import Model

Path = Union[str, "os.PathLike[str]"]
Number = Union[int, float]
ModelOrPath = Union["Model", Path]

# done, and done but flagged
_DONE = (0, 3)

# how the program begins a line that warns, and what stands around one that says why it refuses
_WARNING = "thrum: warning: "
_REFUSAL = re.compile(r"^thrum(?: [a-z]+)?: |\s*\(try: [^()]*\)$", re.MULTILINE)

# an option in a message, which is a keyword here; --help has none
_OPTION = re.compile(r"(?<![\w-])--(?!help\b)([a-z][a-z0-9]*(?:-[a-z0-9]+)*)")

# commands that show no progress, and take no option against it
_SHOW_NOTHING = ("check", "compare", "convert", "export", "help", "info", "schema")

# how long an interrupted program may take to clear up behind itself [s]; what it leaves the next one clears up
_GRACE = 0.04


def program() -> str:
    """Path of the program: THRUM_PROGRAM, else `thrum` in PATH. ProgramFailed says what to do without one."""
    found = os.environ.get("THRUM_PROGRAM") or shutil.which("thrum")
    if not found:
        raise ProgramFailed(
            "the program thrum is not installed, and this call needs it: install the Debian package thrum, unpack the "
            "tarball for other distributions, or build it from the sources (cmake --preset release, cmake --build "
            "build/release, cmake --install build/release); set THRUM_PROGRAM where it is not in PATH", 127)

    # what THRUM_PROGRAM names may lie elsewhere, as a relative path does after os.chdir
    if not shutil.which(found):
        raise ProgramFailed(f"THRUM_PROGRAM: {found} is no program that can be run; name one that is built", 127)
    return found


def arguments(options: dict[str, Any]) -> list[str]:
    """Options as the command line has them: fix="x<0.1" is --fix x<0.1, True stands alone, numbers in a row are joined by
    commas, texts in a row repeat the option, and yield_ is --yield."""
    words = []
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        rows = [value]
        if isinstance(value, (list, tuple, np.ndarray)):
            numbers = len(value) > 0 and all(isinstance(item, (int, float, np.number)) and not isinstance(item, bool)
                                             for item in value)
            rows = [",".join(str(item) for item in np.asarray(value).tolist())] if numbers else list(value)
        for item in rows:
            if item is True:
                words.append(option)
            elif item is not None and item is not False:
                # joined by =, so that a value may begin with -
                words.append(f"{option}={os.fspath(item) if isinstance(item, os.PathLike) else item}")
    return words


def _keyword(option: str) -> str:
    """The keyword that stands for an option: dt for --dt, yield_ for --yield."""
    name = option.replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


def _message(text: str, given: dict[str, str]) -> str:
    """What the program says, in Python's names: dt in place of --dt, `mesh` in place of the file made of it."""
    for path, name in given.items():
        text = text.replace(path, name).replace(os.path.basename(path), name)
    return _OPTION.sub(lambda option: _keyword(option[1]), text)


def _communicate(line: list[str]) -> tuple[int, str, str]:
    """Exit code, output and errors of a program. An interrupt ends it and goes on within a tenth of a second."""
    process = subprocess.Popen(line, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               encoding="utf-8", errors="replace")
    try:
        while True:
            try:
                output, errors = process.communicate(timeout=_GRACE)
                return process.returncode, output, errors
            except subprocess.TimeoutExpired:
                pass
    except BaseException:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        raise
    finally:
        for pipe in (process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()


def run_program(command: str, *words: str, _given: dict[str, str] | None = None, **options: Any) -> dict[str, Any]:
    """Runs `thrum COMMAND WORDS OPTIONS --json` and returns the object that it prints.

    A run that is flagged (exit code 3) returns too: look at its "status". What the program warns of is a
    RuntimeWarning. ProgramFailed with the program's own line for every other exit code. Ctrl-C ends the program. Messages
    name options as the keywords that they are here, and the temporary files `_given` by the names that it has for them.
    """
    # a file whose name begins with - is no option
    files = [os.path.join(os.curdir, word) if word.startswith("-") else word for word in words]
    given = _given or {}
    quiet = [] if command in _SHOW_NOTHING else ["-q"]
    code, output, errors = _communicate([program(), command, *files, *arguments(options), "--json", *quiet])

    # nobody sees the program's standard error, and its warnings say where the result is wrong
    refusal = []
    for text in errors.splitlines():
        if text.startswith(_WARNING):
            warn(_message(text[len(_WARNING):], given))
        else:
            refusal.append(text)
    if code not in _DONE:
        text = _REFUSAL.sub("", "\n".join(refusal).strip()) or f"thrum {command} ended with the exit code {code}"
        raise ProgramFailed(_message(text, given), code)
    return dict(json.loads(output))


# --- what stands for files --------------------------------------------------------------------


@contextmanager
def _file_of(given: Any, beside: str | None = None) -> Iterator[tuple[str, dict[str, str], int | None]]:
    """The file of a model or a mesh, the names of temporary ones for messages, and how many vertices arrays may name.

    beside: the file that a Model is written to which has none; None: a temporary one.
    """
    if isinstance(given, (str, os.PathLike)):
        yield os.fspath(given), {}, None
        return
    with tempfile.TemporaryDirectory(prefix="thrum-") as work:
        if hasattr(given, "_file"):
            path = given._file(beside or os.path.join(work, "given-model.npz"))
            yield path, {path: "model"} if path.startswith(work) else {}, given.vertex_count
            return
        # a name that no message has by chance
        path = os.path.join(work, "given-mesh.msh")
        mesh = _mesh.as_mesh(given)
        _mesh.write_mesh(mesh, path)
        yield path, {path: "mesh"}, len(mesh.vertices)


def _run_on(command: str, given: Any, *words: str, _beside: str | None = None, _named: dict[str, str] | None = None,
            **options: Any) -> dict[str, Any]:
    """Runs a command on a model or a mesh, with vertices to hold that may be arrays."""
    with _file_of(given, _beside) as (path, names, count), tempfile.TemporaryDirectory(prefix="thrum-") as work:
        names.update(_named or {})
        if "fix" in options:
            options["fix"] = _mesh.fix_texts(options["fix"], count, work)
            for text in options["fix"] if isinstance(options["fix"], list) else ():
                if str(text).startswith(work):
                    names[str(text)] = "fix"
        return run_program(command, path, *words, _given=names, **options)


def precompute(mesh: Any, output: Path, **options: Unpack[PrecomputeOptions]) -> dict[str, Any]:
    """Makes the model file `output` of a mesh (see `Model.precompute`) and returns the program's report."""
    return _run_on("precompute", mesh, output=output, **options)


class Run:
    """What `thrum simulate` recorded: a folder and its files.

    report: the program's report (run.json). q: rows x r coordinates. energy: its columns by name.
    """

    def __init__(self, folder: str | os.PathLike[str], report: dict[str, Any] | None = None) -> None:
        self.folder = os.fspath(folder)
        if report is None:
            with open(os.path.join(self.folder, "run.json"), encoding="utf-8") as file:
                report = json.load(file)
        self.report: dict[str, Any] = dict(report or {})

    def __repr__(self) -> str:
        return f"<thrum.Run {self.folder!r} {self.report.get('status', 'not finished')}>"

    def array(self, name: str) -> npt.NDArray[Any]:
        """An array that the run recorded, such as "q" or "end"; FileNotFoundError where it recorded none."""
        found: npt.NDArray[Any] = np.load(os.path.join(self.folder, f"{name}.npy"), allow_pickle=False)
        return found

    @property
    def q(self) -> npt.NDArray[Any]:
        """Coordinates, one row a record."""
        return self.array("q")

    @property
    def energy(self) -> dict[str, npt.NDArray[np.float64]]:
        """energy.csv by columns: time_s, kinetic_j and so on."""
        with open(os.path.join(self.folder, "energy.csv"), encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        values = np.array(rows[1:], dtype=np.float64).reshape(len(rows) - 1, len(rows[0]))
        return {name: values[:, column] for column, name in enumerate(rows[0])}


def simulate(model: ModelOrPath, output: Path, **options: Unpack[SimulateOptions]) -> Run:
    """Runs `thrum simulate` and returns what it recorded.

    model: a Model, a model file, a name or a scene file. output: the folder of the run. options: those of the program with
    underscores, such as time=3, load="impulse:0,0,-40@tip", full=True. A Model that was not loaded from a file is written
    beside the folder, as `output`.model.npz, for the run refers to it.
    """
    target = os.fspath(output)
    beside = target.rstrip(os.sep) + ".model.npz"
    return Run(target, _run_on("simulate", model, _beside=beside, output=target, **options))


def static(model: ModelOrPath, **options: Unpack[StaticOptions]) -> dict[str, Any]:
    """Runs `thrum static` on a Model, a model file or a mesh and returns its report; full=True solves the whole mesh."""
    return _run_on("static", model, **options)


class Response:
    """A curve of periodic motions, as `response` found it.

    report: what the program printed. special: its folds, period doublings, tori and branch points, a dict each.
    frequency (n) [Hz], unstable (n): multipliers outside of the unit circle, -1 where nobody looked; energy (n) [J];
    kind (n): "regular", "fold", ...; peak (n x targets): largest displacement [m]; coefficients (n x (2 H + 1) x k): mean,
    cosines and sines of the k coordinates that move.
    """

    def __init__(self, report: dict[str, Any], folder: str) -> None:
        self.report = report
        self.special: list[dict[str, Any]] = report["special"]
        with open(os.path.join(folder, "response.csv"), newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.frequency = np.array([float(row["frequency_hz"]) for row in rows])
        self.unstable = np.array([int(row["unstable"]) for row in rows])
        self.energy = np.array([float(row["energy_j"]) for row in rows])
        self.kind = np.array([row["kind"] for row in rows])
        names = [f"peak{n + 1}_m" for n in range(len(report["at"]))]
        self.peak = np.array([[float(row[name]) for name in names] for row in rows]).reshape(len(rows), len(names))
        flat = np.load(os.path.join(folder, "coefficients.npy"))
        self.coefficients = flat.reshape(len(rows), 2 * int(report["harmonics"]) + 1, int(report["coordinates"]))

    def plot(self, axes: Any = None, target: int = 0) -> Any:
        """Draws the largest displacement of a target over the frequency with matplotlib, stable motions in full and unstable ones
        dashed, with dots at special points; returns the axes."""
        if axes is None:
            axes = importlib.import_module("matplotlib.pyplot").subplots()[1]
        for unstable, style in ((False, "-"), (True, "--")):
            shown = np.where((self.unstable > 0) == unstable, self.peak[:, target], np.nan)
            axes.plot(self.frequency, shown, style, label="unstable" if unstable else "stable")
        special = self.kind != "regular"
        axes.plot(self.frequency[special], self.peak[special, target], "ko", label="special points")
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("largest displacement [m]")
        axes.legend()
        return axes

    def __repr__(self) -> str:
        ends = f"{self.frequency[0]:.6g} to {self.frequency[-1]:.6g} Hz" if len(self.frequency) else "nothing"
        return f"<thrum.Response: {len(self.frequency)} motions, {ends}, {len(self.special)} special points>"


def response(model: ModelOrPath, *, output: Path | None = None, **options: Any) -> Response:
    """Runs `thrum response` on a Model or a model file: the backbone of mode=1, or the curve under load="sine:0,0,10@tip".

    output: a folder that keeps the files; None: none stays. Options are those of the program, such as damping_ratio=[0.002, 0.004],
    from_=20, to=30, at="tip", harmonics=7.
    """
    with tempfile.TemporaryDirectory(prefix="thrum-") as work:
        folder = os.fspath(output) if output is not None else work
        return Response(_run_on("response", model, output=folder, **options), folder)


def identify(model: ModelOrPath, recording: Path | Mapping[str, Any], *, output: Path | None = None, **options: Any) -> dict[str, Any]:
    """Runs `thrum identify`: moduli, Poisson's ratios, densities, damping and start of a model from a recorded free motion.

    recording: a CSV file, or its columns by name, such as {"time_s": times, "tip.z_m": heights}. output: a folder for the report, the
    fit and a plot; None: none. Options are those of the program, such as start="mode:1,0.03", parameters="E,alpha". Returns the report,
    whose "parameters" have a value, a standard deviation and an interval of 95 % each.
    """
    if isinstance(recording, (str, os.PathLike)):
        return _run_on("identify", model, os.fspath(recording), output=output, **options)
    rows = np.column_stack([np.asarray(column, dtype=np.float64) for column in recording.values()])
    with tempfile.TemporaryDirectory(prefix="thrum-") as work:
        path = os.path.join(work, "given-recording.csv")
        # names of places have commas, which the file writes as blanks
        names = ",".join(name.replace(",", " ") for name in recording)
        np.savetxt(path, rows, fmt="%.17g", delimiter=",", header=names, comments="")
        report = _run_on("identify", model, path, _named={path: "recording"}, output=output, **options)
        report["recording"] = None
        return report


def tradeoff(model: ModelOrPath, output: Path, **options: Any) -> dict[str, Any]:
    """Runs `thrum tradeoff`: what speed and accuracy cost each other, such as error="5%"; returns its report."""
    return _run_on("tradeoff", model, output=output, **options)


def info(what: ModelOrPath | Run, *, dt: float | None = None, integrator: str | None = None,
         load: str | Sequence[str] | None = None, touch: bool = False) -> dict[str, Any]:
    """Runs `thrum info` on a Model, a model file, a Run or its folder, or a surface file, and returns what it says."""
    return _run_on("info", what.folder if isinstance(what, Run) else what, dt=dt, integrator=integrator, load=load,
                   touch=touch)


class FrequencyGradient:
    """How frequencies of the whole mesh change, as `frequency_gradient` found it, all relative to the frequency.

    frequency (modes) [Hz]. young, density (modes x regions): by a relative change of E or of the density; poisson (modes x
    regions): by a change of Poisson's ratio; of modes that share a frequency each row has those into which it splits. place
    (modes x vertices x 3) [1/m]: by the place of each vertex, of modes that share a frequency their mean; None: not asked for.
    """

    def __init__(self, rows: list[dict[str, Any]], place: npt.NDArray[np.float64] | None) -> None:
        self.frequency = np.array([row["frequency_hz"] for row in rows])
        self.young, self.poisson, self.density = (np.array([row[name] for row in rows]) for name in ("young", "poisson", "density"))
        self.place = place


def frequency_gradient(model: ModelOrPath, *, places: bool = False) -> FrequencyGradient:
    """Runs `thrum info --gradient` on a Model or a model file: derivatives of the frequencies of its linear modes by the material
    of each region, and where `places` are asked for by the place of each vertex, which only tetrahedra have."""
    with tempfile.TemporaryDirectory(prefix="thrum-") as work:
        path = os.path.join(work, "places.npy")
        report = _run_on("info", model, gradient=True, shape_gradient=path if places else None)
        rows = report["frequency_gradient"]
        place = np.load(path).reshape(len(rows), -1, 3) if places else None
    return FrequencyGradient(rows, place)


def compare(run: Run | Path, other: Run | Path) -> dict[str, Any]:
    """Runs `thrum compare`: how far two runs are apart."""
    first, second = (item.folder if isinstance(item, Run) else os.fspath(item) for item in (run, other))
    return run_program("compare", first, second)


def check(mesh: Any, *, scale: float | None = None, unit: str | None = None, regions: str | None = None,
          order: int | str | None = None, element: str | None = None) -> dict[str, Any]:
    """Runs `thrum check`: what a mesh is like, and under "flags" what may be wrong.

    mesh: as `Model.precompute` takes it.
    """
    return _run_on("check", mesh, scale=scale, unit=unit, regions=regions, order=order, element=element)


@contextmanager
def _surface_file(given: Any) -> Iterator[tuple[str, dict[str, str]]]:
    if isinstance(given, (str, os.PathLike)):
        yield os.fspath(given), {}
        return
    with tempfile.TemporaryDirectory(prefix="thrum-") as work:
        path = os.path.join(work, "given-surface.obj")
        _mesh.write_surface(given, path)
        yield path, {path: "surface"}


def mesh(surface: Any, output: Path, *, size: float | None = None, scale: float | None = None, order: int | None = None,
         thickness: float | None = None, layers: int | None = None, side: str | None = None,
         tool: str | None = None) -> dict[str, Any]:
    """Runs `thrum mesh`: fills a closed surface with tetrahedra, by Gmsh or TetGen, or with thickness= makes a sheet of it, and
    writes the mesh file `output`.

    surface: a file (.obj, .stl) or a pair (vertices, triangles). Returns the program's report.
    """
    with _surface_file(surface) as (path, names):
        return run_program("mesh", path, _given=names, output=output, size=size, scale=scale, order=order,
                           thickness=thickness, layers=layers, side=side, tool=tool)


def embed(model: ModelOrPath, surface: Any, output: Path, *, scale: float | None = None) -> dict[str, Any]:
    """Runs `thrum embed`: binds a fine surface to a model and writes the surface file `output`; returns the report.

    surface: a file (.obj, .stl) or a pair (vertices, triangles).
    """
    with _surface_file(surface) as (path, names), _file_of(model) as (file, _, _):
        return run_program("embed", file, path, _given=names, output=output, scale=scale)


def export(what: ModelOrPath | Run, *, glb: Path | None = None, obj: Path | None = None, pc2: Path | None = None,
           mdd: Path | None = None, vega_basis: Path | None = None, vega_cubic: Path | None = None,
           matrices: Path | None = None, numpy: Path | None = None, torch: Path | None = None, jax: Path | None = None,
           header: Path | None = None, fmu: Path | None = None, fmi: int | None = None, at: str | Sequence[str] | None = None,
           nlvib: Path | None = None, damping: Any = None, damping_ratio: Any = None,
           surface: Path | None = None, model: ModelOrPath | None = None,
           fps: float | None = None, float_: bool = False) -> dict[str, Any]:
    """Runs `thrum export`: writes a model or a run for other programs, in the files that are named; returns the report.

    what: a Model, a model file, a Run or its folder. model: that of a run, where it lies elsewhere now.
    """
    with tempfile.TemporaryDirectory(prefix="thrum-") as work:
        beside = model._file(os.path.join(work, "given-model.npz")) if model is not None and not isinstance(model, (str, os.PathLike)) else model
        return _run_on("export", what.folder if isinstance(what, Run) else what, glb=glb, obj=obj, pc2=pc2, mdd=mdd,
                       vega_basis=vega_basis, vega_cubic=vega_cubic, matrices=matrices, numpy=numpy, torch=torch, jax=jax,
                       header=header, fmu=fmu, fmi=fmi, at=at, nlvib=nlvib, damping=damping,
                       damping_ratio=damping_ratio, surface=surface, model=beside, fps=fps, float=float_)
