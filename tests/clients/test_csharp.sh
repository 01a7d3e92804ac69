#!/bin/sh
# examples/csharp/Thrum.cs under mono: structs have C's sizes and places, and a run has C's bits.
# SPDX-License-Identifier: Apache-2.0
# usage: test_csharp.sh SOURCE PROGRAM LIBRARY COMPILER
set -eu
source=$1 program=$2 library=$3 compiler=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM

# the shared library under the name that P/Invoke looks for, and under its own, by which C finds it
cd "$source"
cp "$library" "$work/libthrum.so"
ln -s libthrum.so "$work/$(basename "$library")"
"$compiler" -std=c11 -O1 -Wall -Wextra -Werror -Iinclude tests/clients/check.c "$work/libthrum.so" -o "$work/check"
"$program" precompute beam:8x2x2@1x0.2x0.2,split=6 --order 1 --fix 'x<0.001' --modes 4 --rank 8 -q -o "$work/beam.npz" >/dev/null 2>&1
mcs -warnaserror -out:"$work/check.exe" examples/csharp/Thrum.cs tests/clients/Check.cs

LD_LIBRARY_PATH=$work "$work/check" "$work/beam.npz" >"$work/c.txt"
LD_LIBRARY_PATH=$work mono "$work/check.exe" "$work/beam.npz" >"$work/csharp.txt"
diff "$work/c.txt" "$work/csharp.txt"
echo "$(wc -l <"$work/c.txt") lines are the same in C and C#"
