#!/bin/sh
# The record of runs on a bare Debian 12, a row a command, which bare.sh writes and a release asks for.
# SPDX-License-Identifier: Apache-2.0
# usage: bare_record.sh write FILE demo|test RESULT COMMIT DEBIAN GCC CMAKE NODE PROCESSOR TIME
#        bare_record.sh check SOURCE    exit 1 unless all tests passed there with the commit that SOURCE is at, which may
#                                       have the record alone on top
set -eu
name=packaging/bare_record.md

# shellcheck disable=SC2016 # the ticks are those of Markdown
name_row() { printf '| `./run %s` |' "$1"; }

# A row in place of the one that the command has.
write() {
  file=$1 command=$2 result=$3 commit=$4
  shift 4
  {
    printf '# Runs on a bare Debian 12\n\n'
    # shellcheck disable=SC2016
    printf 'What `./run bare demo` and `./run bare test` did last ([packaging](README.md#a-bare-debian)); they write this file.\n\n'
    printf '| command | result | date | commit | Debian | gcc | cmake | node | processor | processor time |\n'
    printf '|---|---|---|---|---|---|---|---|---|---|\n'
    {
      grep '^| .\./run ' "$file" 2>/dev/null | grep -vF "$(name_row "$command")" || true
      name_row "$command"
      printf ' %s | %s | %s' "$result" "$(date -u +%Y-%m-%d)" "$commit"
      printf ' | %s' "$@"
      printf ' |\n'
    } | LC_ALL=C sort
  } >"$file.part"
  mv "$file.part" "$file"
}

# Says what is missing, and how to come by it.
refuse() {
  printf 'release: %s; ./run bare test makes it, and %s is to be committed then\n' "$1" "$name" >&2
  exit 1
}

check() {
  row=$(git -C "$1" show "HEAD:$name" 2>/dev/null | grep -F "$(name_row test)") ||
    refuse "there is no result of the tests on a bare Debian 12"
  result=$(printf '%s' "$row" | awk -F ' *[|] *' '{ print $3 }')
  commit=$(printf '%s' "$row" | awk -F ' *[|] *' '{ print $5 }')
  case $result in
  *[1-9]*' passed, 0 failed') ;;
  *) refuse "the last result of the tests on a bare Debian 12 is '$result'" ;;
  esac
  changed=$(git -C "$1" diff --name-only "$commit" HEAD 2>/dev/null) || changed="everything"
  [ "${changed:-$name}" = "$name" ] ||
    refuse "the result of the tests on a bare Debian 12 is of $commit, and $(printf '%s\n' "$changed" | grep -cvxF "$name") files have changed since"
}

case $1 in
write | check) "$@" ;;
*) echo "bare_record.sh: write or check" >&2 && exit 2 ;;
esac
