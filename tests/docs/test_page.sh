#!/bin/sh
# Every command of a page runs: its ```sh blocks are executed in order by one shell, in an empty folder
# that looks like a checkout, with the program of this build. Of the README only `./run test` is not run
# here, for it is what runs this. SPDX-License-Identifier: Apache-2.0
# usage: test_page.sh SOURCE BUILD PROGRAM PAGE
set -eu
source=$1 build=$2 program=$3 page=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM

# what a checkout has that commands of the pages read
mkdir -p "$work/checkout/build" "$work/checkout/validation" "$work/home"
cp "$source/run" "$work/checkout/run"
cp "$source/.gitignore" "$work/checkout"
cp -r "$source/tests" "$source/examples" "$work/checkout"
cp -r "$source/validation/pictures" "$work/checkout/validation/pictures"
ln -s "$build" "$work/checkout/build/release"

# indented code would escape this test
if sed '/^```/,/^```$/d' "$source/$page" | grep -q '^    [a-z./]'; then
  echo "$page: put commands into sh blocks"
  exit 1
fi
sed -n '/^```sh$/,/^```$/p' "$source/$page" | sed '/^```/d' >"$work/commands.sh"
lines=$(grep -c . "$work/commands.sh")
if [ "$page" = README.md ]; then
  grep -qx './run demo' "$work/commands.sh"
  grep -qx './run test' "$work/commands.sh"
  sed -i 's|^\./run test$|: ./run test|' "$work/commands.sh"
fi

# a stand-in for the viewer's page where that was not built
test -f "$build/viewer/viewer.html" || {
  printf '<script type="application/octet-stream" id="thrum-pack"></script>' >"$work/viewer.html"
  export THRUM_VIEWER="$work/viewer.html"
}

# what the commands write is to be nothing that git would take for a part of the project
git_there=$(command -v git || :)
if [ -n "$git_there" ]; then
  git -C "$work/checkout" init -q
  git -C "$work/checkout" add -A
fi

# models by name are made once for all pages, in the cache of the build
cd "$work/checkout"
HOME=$work/home XDG_CACHE_HOME=$build/tests/page_cache THRUM_PROGRAM=$program \
  PATH=$(dirname "$program"):$PATH sh -eux "$work/commands.sh"
if [ -n "$git_there" ]; then
  left=$(git -C "$work/checkout" ls-files --others --exclude-standard)
  if [ -n "$left" ]; then
    printf '%s: its commands leave files that git does not ignore:\n%s\n' "$page" "$left"
    exit 1
  fi
fi
echo "-- $lines lines of $page ran"
