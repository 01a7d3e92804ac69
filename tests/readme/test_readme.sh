#!/bin/sh
# Every command in the README runs: its ```sh blocks are executed in order, in an empty folder that
# looks like a checkout, with the program of this build. Of them only `./run test` is not run here,
# for it is what runs this. SPDX-License-Identifier: Apache-2.0
# usage: test_readme.sh SOURCE BUILD PROGRAM
set -eu
source=$1 build=$2 program=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM

mkdir -p "$work/checkout/build" "$work/home"
cp "$source/run" "$work/checkout/run"
cp -r "$source/tests" "$work/checkout/tests"
cp -r "$source/examples" "$work/checkout/examples"
ln -s "$build" "$work/checkout/build/release"

# what it links to and shows is there
sed 's/](\([^)]*\))/\n@\1\n/g' "$source/README.md" | sed -n 's/^@//p' | while read -r link; do
  test -e "$source/$link" || {
    echo "README.md links to $link, which is missing"
    exit 1
  }
done

# indented code would escape this test
if grep -q '^    [a-z./]' "$source/README.md"; then
  echo "README.md: put commands into sh blocks"
  exit 1
fi
sed -n '/^```sh$/,/^```$/p' "$source/README.md" | sed '/^```/d' >"$work/commands.sh"
commands=$(grep -c . "$work/commands.sh")
test "$commands" -ge 5
grep -qx './run demo' "$work/commands.sh"
grep -qx './run test' "$work/commands.sh"
sed -i 's|^\./run test$|: ./run test|' "$work/commands.sh"

# a stand-in for the viewer's page where that was not built
test -f "$build/viewer/viewer.html" || {
  printf '<script type="application/octet-stream" id="thrum-pack"></script>' >"$work/viewer.html"
  export THRUM_VIEWER="$work/viewer.html"
}

cd "$work/checkout"
HOME=$work/home THRUM_PROGRAM=$program PATH=$(dirname "$program"):$PATH \
  sh -eux "$work/commands.sh"
echo "-- $commands lines of README.md ran"
