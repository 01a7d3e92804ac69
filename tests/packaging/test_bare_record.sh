#!/bin/sh
# The record of runs on a bare Debian: a run replaces its row, and a release is refused without a result of its commit.
# SPDX-License-Identifier: Apache-2.0
# usage: test_bare_record.sh SOURCE
set -eu
record=$1/packaging/bare_record.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM
cd "$work"
export GIT_CONFIG_GLOBAL=/dev/null GIT_AUTHOR_NAME=a GIT_AUTHOR_EMAIL=a@b GIT_COMMITTER_NAME=a GIT_COMMITTER_EMAIL=a@b
git init -q . && mkdir packaging && echo 1 >source && git add . && git commit -q -m "a source"

fail() {
  echo "test_bare_record: $*"
  exit 1
}
# a row of a command with a result, committed: run COMMAND RESULT
run() {
  "$record" write packaging/bare_record.md "$1" "$2" "$(git rev-parse HEAD)" 12.0 12.2.0 3.25.1 v18.20.4 "a processor" "9 s"
  git add . && git commit -q -m "a result"
}
# a release is refused, with this in what is said
refused() {
  ! "$record" check . 2>.git/said || fail "a release is let pass: $1"
  grep -q "$1" .git/said || fail "'$1' is not said: $(cat .git/said)"
}

refused 'there is no result'
run demo "done"
refused 'there is no result'
run test '98 passed, 2 failed'
refused "'98 passed, 2 failed'"
run test '0 passed, 0 failed'
refused "'0 passed, 0 failed'"
run test 'exit code 1'
refused "'exit code 1'"
run test '100 passed, 0 failed'
"$record" check . || fail "a release with its result is refused"
run demo "done"
"$record" check . || fail "the row of the demo is part of the record"

# a row a command, under the same head
test "$(grep -c '^| .\./run ' packaging/bare_record.md)" = 2 || fail "$(cat packaging/bare_record.md)"
grep -qF " | 100 passed, 0 failed | 20" packaging/bare_record.md || fail "$(cat packaging/bare_record.md)"
grep -q '| v18.20.4 | a processor | 9 s |$' packaging/bare_record.md || fail "$(cat packaging/bare_record.md)"

echo 2 >source && git commit -q -a -m "another source"
refused 'and 1 files have changed since'
