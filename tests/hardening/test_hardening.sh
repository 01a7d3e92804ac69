#!/bin/sh
# A hardened build has what it says: the program lies anywhere in memory, binds its symbols at the start
# and checks copies and the stack; libthrum and the scene library need none of that.
# usage: test_hardening.sh PROGRAM LIBTHRUM LIBSCENE. SPDX-License-Identifier: Apache-2.0
set -eu
program=$1
status=0

# fails TEXT: says what is missing and goes on
fails() {
  printf 'test_hardening: %s\n' "$1" >&2
  status=1
}

readelf -h "$program" | grep -q 'Type:.*DYN' || fails "$program is no position-independent executable"
readelf -lW "$program" | grep -q 'GNU_RELRO' || fails "$program has no GNU_RELRO"
readelf -dW "$program" | grep -qE 'BIND_NOW|NOW' || fails "$program does not bind its symbols at the start"
readelf -lW "$program" | grep 'GNU_STACK' | grep -q 'RWE' && fails "$program has an executable stack"
nm -D "$program" | grep -q '__stack_chk_fail' || fails "$program does not check its stack"
nm -D "$program" | grep -qE '__(memcpy|snprintf|strcpy|vsnprintf)_chk' || fails "$program does not check copies"

# what steps calls nothing that a program without an operating system lacks
for library in "$2" "$3"; do
  if nm "$library" 2>/dev/null | grep -E ' U __(stack_chk_fail|[a-z]*_chk)$'; then
    fails "$library calls checks of the C library"
  fi
done
exit $status
