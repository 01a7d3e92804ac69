#!/bin/sh
# Runs the tests of the Python package with the wheel for aarch64 under qemu, with Debian's Python for arm64, and compares
# the bits of all integrators with those of the wheel for x86-64. The program that makes the tests' models is that of this
# machine. Needs root for debootstrap, qemu-user and the network. SPDX-License-Identifier: Apache-2.0
# usage: wheel_aarch64.sh SOURCE WHEEL_AARCH64 WHEEL_X86_64 THRUM FOLDER
set -eu
source=$(realpath -- "$1") wheel=$(realpath -- "$2") own=$(realpath -- "$3") program=$(realpath -- "$4")
mkdir -p "$5"
folder=$(realpath -- "$5")
root=$folder/root
if [ ! -x "$root/usr/bin/python3.11" ]; then
  debootstrap --foreign --arch=arm64 --variant=minbase --include=python3-numpy,python3-cffi bookworm "$root" \
    http://deb.debian.org/debian >"$folder/log" 2>&1 || { tail -n 20 "$folder/log" >&2; exit 1; }
  # unpacked and not configured: nothing has to run for that
  for package in "$root"/var/cache/apt/archives/*.deb; do
    dpkg-deb -x "$package" "$root"
  done
fi
lib=/usr/lib/aarch64-linux-gnu
python() {
  PYTHONPATH="$folder/arm:$source/tests/python" THRUM_PROGRAM="$program" qemu-aarch64 -L "$root" \
    -E LD_LIBRARY_PATH="$lib/blas:$lib/lapack" "$root/usr/bin/python3.11" "$@"
}

rm -rf "$folder/arm" "$folder/own"
/usr/bin/python3 -m pip install --quiet --root-user-action=ignore --no-deps --no-index --only-binary=:all: \
  --platform manylinux_2_17_aarch64 --target "$folder/arm" "$wheel"
/usr/bin/python3 -m pip install --quiet --root-user-action=ignore --no-deps --no-index --target "$folder/own" "$own"
for name in model state scene program; do
  python "$source/tests/python/test_$name.py" 2>"$folder/log" || { cat "$folder/log" >&2; exit 1; }
  printf '%s: %s\n' "$name" "$(sed -n 's/^Ran //p' "$folder/log")"
done

cat >"$folder/bits.py" <<'PY'
import hashlib, sys, numpy as np, thrum
model, digest = thrum.Model.load(sys.argv[1]), hashlib.sha256()
for name in thrum.integrators():
    state = model.state(integrator=name, dt=0.003)
    state.set(model.start(0, 0.05))
    try:
        state.step(300)
    except thrum.Error as error:
        digest.update(str(error).encode())
    digest.update(state.q.tobytes())
print(len(thrum.integrators()), "integrators, 300 steps:", digest.hexdigest())
PY
"$program" precompute beam:8x2x2@1x0.2x0.2 --fix 'x<0.001' --modes 4 --rank 8 --order 2 -q -o "$folder/beam.npz" >/dev/null
python "$folder/bits.py" "$folder/beam.npz" >"$folder/bits.arm"
PYTHONPATH=$folder/own /usr/bin/python3 "$folder/bits.py" "$folder/beam.npz" >"$folder/bits.own"
diff "$folder/bits.arm" "$folder/bits.own"
cat "$folder/bits.arm"
