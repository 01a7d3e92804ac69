#!/bin/sh
# Fails when a program can call malloc or the like, by the symbols that it leaves undefined.
# SPDX-License-Identifier: Apache-2.0
set -eu
if nm -u "$1" | grep -E ' (malloc|calloc|realloc|aligned_alloc|posix_memalign)(@|$)'; then
  echo "$1 takes memory" >&2
  exit 1
fi
