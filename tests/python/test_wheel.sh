#!/bin/sh
# The source distribution holds all that it needs, the wheels made from it name the oldest system they run on,
# and an installed wheel passes the tests without the source tree or a compiler. That for aarch64 is built and run for a
# release (packaging/wheel_aarch64.sh). SPDX-License-Identifier: Apache-2.0
# usage: test_wheel.sh SOURCE PYTHON PROGRAM
set -eu
source=$1 python=$2 program=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM
unset PYTHONPATH
# -O1 halves the time to build, and every build gives the same bits
export CMAKE_ARGS="-DCMAKE_C_FLAGS_RELEASE=-O1"

# Runs a hook of PEP 517 in the present folder: hook NAME OUTPUT
hook() {
  "$python" -c 'import sys, setuptools.build_meta as backend; getattr(backend, sys.argv[1])(sys.argv[2])' \
    "$1" "$2" >"$work/log" 2>&1 || { tail -n 40 "$work/log"; exit 1; }
}

# what CMake is called with
mkdir "$work/bin"
printf '#!/bin/sh\necho "$@" >>"%s/calls"\nexec "%s" "$@"\n' "$work" "$(command -v cmake)" >"$work/bin/cmake"
chmod +x "$work/bin/cmake"
PATH=$work/bin:$PATH

# a bare Debian has no make beside cmake and ninja
if command -v ninja >/dev/null 2>&1; then
  printf '#!/bin/sh\necho "make is called where ninja is installed" >&2\nexit 1\n' >"$work/bin/make"
  chmod +x "$work/bin/make"
fi

# a copy, because setuptools writes beside the sources; no build folder comes along
mkdir "$work/tree" "$work/out"
(cd "$source" && tar -c --exclude=./build --exclude=./.git --exclude=node_modules --exclude=./out \
  --exclude=./validation --exclude=./models .) |
  tar -x -C "$work/tree"
echo "-- source distribution"
(cd "$work/tree" && hook build_sdist "$work/out")
rm -rf "$work/tree"
mkdir "$work/sdist"
tar -xzf "$work"/out/thrum-*.tar.gz -C "$work/sdist" --strip-components=1

echo "-- wheel"
(cd "$work/sdist" && hook build_wheel "$work/out")
# as many compilers as processors, not one for each source at once
grep -q -- '--parallel [1-9]' "$work/calls"
wheel=$(ls "$work"/out/thrum-*-py3-none-manylinux_2_17_x86_64.whl)
"$python" -m pip install --quiet --root-user-action=ignore --no-deps --no-index --target "$work/installed" "$wheel"
test -f "$work/installed/thrum/py.typed"

echo "-- tests of the installed package"
cp -r "$source/tests/python" "$work/tests"
for name in model state scene program; do
  (cd "$work" && PYTHONPATH="$work/installed:$work/tests" THRUM_PROGRAM="$program" PYTHONWARNINGS=error::ResourceWarning \
    "$python" "tests/test_$name.py" 2>"$work/log") || { cat "$work/log"; exit 1; }
done
