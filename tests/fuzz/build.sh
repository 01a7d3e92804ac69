#!/bin/sh
# Builds the fuzz targets fuzz_*.c with clang's libFuzzer, and prints their names. The sources that a
# target needs are listed in its first comment, after "sources:", patterns included, and the
# libraries beside libm and expat after "libraries:"; the sources of the mesh readers are the same
# for all.
#   build.sh SOURCE_FOLDER FOLDER CLANG [TARGETS] [sanitized | brief | plain | covered]
# "sanitized" stops at errors that the address and undefined-behaviour sanitizers see; "brief" does so
# without optimisation, which for a few seconds of inputs takes longer than it saves; "plain" has
# neither and is several times as fast, to find the inputs that reach something new; "covered" counts
# which lines are reached instead.
# SPDX-License-Identifier: Apache-2.0
set -eu
source=$(cd "$1" && pwd)
mkdir -p "$2"
build=$(cd "$2" && pwd)
clang=$3
wanted=${4:-"fuzz_*"}
flags="-std=c11 -O1 -g1 -I$source -I$source/include"
flags="$flags -D_POSIX_C_SOURCE=200809L -DTHRUM_FUZZ -ffp-contract=off -Wno-comment -Wno-unknown-attributes"
flags="$flags -Wno-ignored-attributes"
followed=-fsanitize=fuzzer-no-link
# the unrolled kernels of processors, which take minutes to compile with sanitizers; tests of their own
# run them so. Sums over coefficients and checksums have no branches that an input should look for: they
# are compiled with sanitizers, but not to be followed, which takes most of their time.
plain=$flags
case ${5:-sanitized} in
sanitized | brief)
  [ "${5:-}" != brief ] || flags="$flags -O0"
  flags="$flags -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer" ;;
# without a look at what is compared, which takes more than half of the time of a small input
plain) flags="$flags -O2" plain=$flags followed=-fsanitize-coverage=inline-8bit-counters,pc-table ;;
covered) flags="$flags -fprofile-instr-generate -fcoverage-mapping" ;;
esac
mesh_sources="mesh/*.c mesh/formats/*.c io/text.c io/file.c"
mesh_sources="$mesh_sources platform/interrupt.c platform/allocate.c core/base/quadratic_tet.c core/base/status.c"

# patterns of sources are those of this tree, wherever the script is called
cd "$source"

# a header that changed may concern any object
headers=$build/headers
if [ ! -e "$headers" ] ||
  [ -n "$(find "$source" -path '*/build' -prune -o \( -name '*.h' -o -name '*.inl' \) \
    -newer "$headers" -print)" ]; then
  rm -f "$build"/*.o
fi
: >"$headers"

# the object of a source goes to $object
object_of() {
  folder=${1%/*}
  file_name=${1##*/}
  object=$build/${folder##*/}_${file_name%.c}.o
}

# prints source and object of each file of the patterns whose object is not newer than it
stale() {
  for pattern in "$@"; do
    for file in "$source"/$pattern; do
      object_of "$file"
      [ "$object" -nt "$file" ] || printf '%s\n%s\n' "$file" "$object"
    done
  done
}

for target in "$source"/tests/fuzz/$wanted.c; do
  name=${target##*/}
  name=${name%.c}
  case $name in
  fuzz_mesh_*) sources=$mesh_sources ;;
  *) sources=$(sed -n '/sources:/,/SPDX/p' "$target" | tr ' ' '\n' | grep '\.c$') ;;
  esac
  libraries=$(sed -n 's/.*libraries: *\(.*[a-z0-9]\).*/\1/p' "$target")
  # shellcheck disable=SC2086
  set -- $libraries
  library_flags=
  [ $# -eq 0 ] || library_flags=$(pkg-config --cflags --libs "$@")

  # shellcheck disable=SC2086
  stale $sources | xargs -r -n 2 -P "$(nproc)" sh -c \
    'case $1 in
     */*kernel_avx*.c) flags="'"$plain"'" ;;
     */core/base/crc32.c | */core/polynomial/*.c | */runtime/kernels/*.c | */runtime/batch/batch_kernel*.c |\
       */runtime/points/kernel_points.c | */core/linear_algebra/*.c)
       flags="'"$flags"'" ;;
     *) flags="'"$flags $library_flags $followed"'" ;;
     esac
     "$0" $flags -c "$1" -o "$2"' "$clang"
  objects=
  for pattern in $sources; do
    for file in "$source"/$pattern; do
      object_of "$file"
      objects="$objects $object"
    done
  done

  # functions that a target does not reach may miss the sources that they call
  # shellcheck disable=SC2086
  "$clang" $flags -fsanitize=fuzzer -no-pie -Wl,--unresolved-symbols=ignore-in-object-files "$target" \
    $objects $library_flags -lexpat -lz -lm -o "$build/$name"
  echo "$name"
done
