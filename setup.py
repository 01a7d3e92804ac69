"""Builds the Python package: the C library by CMake, its declarations, and wheels that say what they need.

CMAKE_ARGS in the environment goes to CMake, such as a compiler for another architecture.
SPDX-License-Identifier: Apache-2.0
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from wheel.bdist_wheel import bdist_wheel

ROOT = pathlib.Path(__file__).resolve().parent
# PEP 600: a wheel tagged manylinux_2_17 runs where the C library is at least glibc 2.17
OLDEST_GLIBC = (2, 17)


def version() -> str:
    text = (ROOT / "include/thrum/version.h").read_text(encoding="utf-8")
    found = re.search(r'#define THRUM_VERSION_STRING "([^"]+)"', text)
    if not found:
        raise SystemExit("include/thrum/version.h has no THRUM_VERSION_STRING")
    return found.group(1)


def generator() -> "list[str]":
    """Ninja where it is installed: CMake itself looks for make alone, which a Debian with cmake and ninja may lack."""
    return ["-GNinja"] if "CMAKE_GENERATOR" not in os.environ and shutil.which("ninja") else []


class BuildWithLibrary(build_py):
    """Copies the package as CMake lays it out: sources, declarations, library."""

    def run(self) -> None:
        work = pathlib.Path(self.get_finalized_command("build").build_temp).resolve() / "cmake"
        options = shlex.split(os.environ.get("CMAKE_ARGS", ""))
        subprocess.run(["cmake", *generator(), "-S", str(ROOT), "-B", str(work), "-DCMAKE_BUILD_TYPE=Release",
                        "-DTHRUM_BUILD_PRECOMPUTE=OFF", "-DTHRUM_BUILD_TESTS=OFF", "-DTHRUM_BUILD_PYTHON=ON",
                        f"-DTHRUM_PYTHON={sys.executable}", *options], check=True)
        # without a number make starts a compiler for every source at once
        subprocess.run(["cmake", "--build", str(work), "--target", "thrum_python_package",
                        "--parallel", str(os.cpu_count() or 1)], check=True)
        built = work / "python/thrum"
        target = pathlib.Path(self.build_lib) / "thrum"
        self.mkpath(str(target))
        for name in sorted(path.name for path in built.iterdir() if path.is_file()):
            self.copy_file(str(built / name), str(target / name), preserve_mode=False)
        self.copy_file(str(ROOT / "LICENSE"), str(target / "LICENSE"))


class WheelOfLibrary(bdist_wheel):
    """A wheel for any Python 3 on one architecture, tagged by what its library needs."""

    def finalize_options(self) -> None:
        super().finalize_options()
        self.root_is_pure = False

    def get_tag(self) -> "tuple[str, str, str]":
        library = next(pathlib.Path(self.bdist_dir).rglob("libthrum.so"), None) if self.bdist_dir else None
        return "py3", "none", platform_of(library) if library else super().get_tag()[2]


def platform_of(library: pathlib.Path) -> str:
    """manylinux_2_17_ARCH where the library needs no newer glibc; refuses what needs more than glibc and libm."""
    text = subprocess.run(["readelf", "-hdVW", str(library)], check=True, capture_output=True, text=True).stdout
    needed = set(re.findall(r"\(NEEDED\).*\[([^\]]+)\]", text))
    foreign = {name for name in needed if not re.match(r"lib[cm]\.so\.6$|ld-linux", name)}
    if foreign:
        raise SystemExit(f"libthrum.so needs {', '.join(sorted(foreign))}: the runtime needs libm alone")
    newest = max(tuple(int(part) for part in number.split(".")) for number in re.findall(r"GLIBC_([\d.]+)", text))
    machine = "aarch64" if re.search(r"Machine:\s+AArch64", text) else "x86_64"
    tag = max(newest[:2], OLDEST_GLIBC)
    return f"manylinux_{tag[0]}_{tag[1]}_{machine}"


class WithLibrary(Distribution):
    """A distribution that is not pure Python."""

    def has_ext_modules(self) -> bool:
        return True


setup(version=version(), packages=["thrum"], package_dir={"thrum": "python/thrum"},
      distclass=WithLibrary, cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": WheelOfLibrary})
