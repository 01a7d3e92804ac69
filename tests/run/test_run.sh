#!/bin/sh
# The script ./run, with stand-ins for cmake, dpkg, id and sudo: what it prints where, what it does
# without its packages, and that builds asked for at once wait for each other.
# SPDX-License-Identifier: Apache-2.0
# usage: test_run.sh SOURCE
set -eu
source=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM
unset THRUM_PROGRAM THRUM_TEST_MPI || true

fail() {
  echo "test_run: $*"
  exit 1
}

# a stand-in NAME: its text is read from standard input
stand_in() {
  { echo '#!/bin/sh' && cat; } >"$work/bin/$1"
  chmod +x "$work/bin/$1"
}

# a blank in the path, as a stranger's folder may have
checkout="$work/a checkout"
mkdir -p "$checkout" "$work/bin"
cp "$source/run" "$checkout/run"
export WORK="$work"
export PATH="$work/bin:$PATH"
stand_in dpkg <<'TEXT'
[ ! -f "$WORK/packages-missing" ] || exit 1
echo 'Status: install ok installed'
TEXT
# makes a program that shows its arguments; two at a time would meet in the folder "building"
stand_in cmake <<'TEXT'
echo noise
mkdir "$WORK/building" || { echo overlap >>"$WORK/overlaps"; exit 1; }
sleep 0.1
echo "$*" >>"$WORK/builds"
folder=$(printf '%s\n' "$@" | grep '/release$' | head -n 1)
mkdir -p "$folder"
touch "$folder/build.ninja"
printf '#!/bin/sh\n[ "$1" != called ] || exec printf %%s "$THRUM_COMMAND"\nprintf "<%%s>" "$@"\n' >"$folder/thrum"
chmod +x "$folder/thrum"
# what npm puts beside the viewer's sources
case $* in
*' viewer') mkdir -p viewer/node_modules/new ;;
esac
rmdir "$WORK/building"
TEXT

echo "-- arguments and folders pass through, standard output is the program's alone"
cd "$work"
out=$("$checkout/run" thrum info 'two words' '' 2>err)
test "$out" = '<info><two words><>' || fail "standard output: $out"
! grep -q noise err || fail "the build's output is shown: $(cat err)"
grep -q 'building thrum' err || fail "nothing says that a build began: $(cat err)"
grep -q noise "$checkout/build/run.log" || fail "the build's output is in no log"

echo "-- what is built is started at once, until a source changes"
rm -f builds
out=$("$checkout/run" thrum info 2>err)
test "$out" = '<info>' || fail "built: $out"
test ! -f builds || fail "built again: $(cat builds)"
test ! -s err || fail "a built program starts with words: $(cat err)"
sleep 0.01
mkdir -p "$checkout/runtime"
touch "$checkout/runtime/new.c"
"$checkout/run" thrum info >/dev/null 2>&1
test -f builds || fail "a new source was not built"

echo "-- it builds where THRUM_BUILD_DIR says"
mkdir -p "$work/elsewhere"
out=$(THRUM_BUILD_DIR="$work/elsewhere" "$checkout/run" viewer 2>/dev/null)
test "$out" = "$work/elsewhere/release/viewer/viewer.html" || fail "THRUM_BUILD_DIR: $out"
test -f "$work/elsewhere/run.log" || fail "THRUM_BUILD_DIR: nothing was built there"
if [ "$(id -u)" -ne 0 ]; then
  echo "-- and in the user's cache where the checkout cannot be written"
  cp -r "$checkout" "$work/locked"
  rm -rf "$work/locked/build"
  chmod -R a-w "$work/locked"
  out=$(XDG_CACHE_HOME="$work/cache" "$work/locked/run" viewer 2>err)
  case $out in
  "$work/cache/thrum/build-"*) ;;
  *) fail "a checkout that cannot be written: $out" ;;
  esac
  grep -q 'cannot be written; building in' err || fail "the other folder is not said: $(cat err)"
  chmod -R u+w "$work/locked"
fi

echo "-- through links it finds its own folder"
mkdir "$work/links"
ln -s "../a checkout/run" "$work/links/relative"
ln -s "$work/links/relative" "$work/links/absolute"
for name in relative absolute; do
  out=$("$work/links/$name" thrum "$name" 2>err) || fail "$name: $(cat err)"
  test "$out" = "<$name>" || fail "$name: $out"
done
test ! -e "$work/links/build" || fail "a link was built in its own folder"

echo "-- the viewer is built where it is shown, and nowhere else"
rm -f builds
touch "$checkout/runtime/newer.c"
"$checkout/run" thrum info >/dev/null 2>&1
! grep -q viewer builds || fail "info built the viewer"
out=$("$checkout/run" thrum view horse 2>/dev/null)
test "$out" = '<view><horse>' || fail "view: $out"
grep -q 'thrum_program viewer$' builds || fail "view did not build the viewer: $(cat builds)"
out=$("$checkout/run" viewer 2>/dev/null)
test "$out" = "$checkout/build/release/viewer/viewer.html" || fail "viewer: $out"
test "$(grep -c viewer builds)" = 1 || fail "the viewer was built again: $(cat builds)"

echo "-- the program is told how it is called"
out=$("$checkout/run" thrum called)
test "$(sh -c "$out called")" = "$out" || fail "a command with a blank in its path: $out"
out=$(cd "$checkout" && ./run thrum called)
test "$out" = "./run thrum" || fail "called as $out"

if command -v flock >/dev/null 2>&1; then
  echo "-- builds wait for each other"
  rm -rf "$checkout/build"
  for n in 1 2 3; do
    "$checkout/run" thrum "$n" >"out$n" 2>/dev/null &
  done
  wait
  for n in 1 2 3; do
    test "$(cat "out$n")" = "<$n>" || fail "call $n: $(cat "out$n")"
  done
  test ! -f overlaps || fail "two builds at once"
fi

echo "-- the last line of ./run test counts the tests of all builds, as ctest does"
for name in gcc g++ clang clang++ clang-format clang-tidy git; do
  printf 'exit 0\n' | stand_in "$name"
done
# tests PRESET COMMAND...: the tests that a build of this preset has
tests() {
  mkdir -p "$checkout/build/$1"
  file=$checkout/build/$1/CTestTestfile.cmake
  shift
  : >"$file"
  for what in "$@"; do
    printf 'add_test(test_%s "sh" "-c" "exit %s")\n' "$what" "${what#*_}" >>"$file"
    printf 'set_tests_properties(test_%s PROPERTIES SKIP_RETURN_CODE 77)\n' "$what" >>"$file"
  done
}
tests release a_0 b_0 skipped_77
tests clang a_0
tests asan a_0 b_0
tests tsan threads_0
sed -i 's/test_threads_0/test_threads/' "$checkout/build/tsan/CTestTestfile.cmake"
"$checkout/run" test >out 2>err || fail "tests that pass: $(cat out err)"
test "$(tail -n 1 out)" = '6 passed, 0 failed' || fail "counts: $(tail -n 1 out)"

# a compiler that works until it has taken more than a second
stand_in gcc <<'TEXT'
while times >"$WORK/times"; ! grep -q '^0m[1-9]' "$WORK/times"; do :; done
TEXT
"$checkout/run" test >out 2>err || fail "tests that pass: $(cat out err)"
spent=$(sed -n 's/^run: all of it took \([0-9]*\) s of processor time$/\1/p' err)
test "${spent:-0}" -ge 1 || fail "processor time: ${spent:-none} s, $(cat err)"
printf 'exit 0\n' | stand_in gcc
tests clang a_0 b_1 c_0
! "$checkout/run" test >out 2>err || fail "a test that fails is no failure"
test "$(tail -n 1 out)" = '4 passed, 1 failed' || fail "counts of a failure: $(tail -n 1 out)"
tests clang
! "$checkout/run" test >out 2>err || fail "a build without tests is no failure"
test "$(tail -n 1 out)" = '2 passed, 0 failed' || fail "counts without tests: $(tail -n 1 out)"

echo "-- a build that fails is the script's failure"
mkdir "$work/building"
touch "$checkout/runtime/newest.c"
! "$checkout/run" thrum info >out 2>err || fail "a failed build went on"
grep -q noise err || fail "the end of a failed build's log is not shown: $(cat err)"
test ! -s out || fail "a failed build printed results"
rmdir "$work/building"

echo "-- without root and sudo it says what to install, and stops"
touch packages-missing
touch "$checkout/runtime/other.c"
printf 'echo 1000\n' | stand_in id
printf 'exit 1\n' | stand_in sudo
for command in thrum demo test viewer; do
  ! "$checkout/run" "$command" >out 2>err </dev/null || fail "$command went on without packages"
  grep -q '^  apt-get update && apt-get install --no-install-recommends .*libarpack2-dev' err || fail "$command: $(cat err)"
  test ! -s out || fail "$command: standard output is not empty"
  case $command in
  thrum | demo) ! grep -q wasi-libc err || fail "$command wants what the viewer is built with" ;;
  *) grep -q wasi-libc err || fail "$command: $(cat err)" ;;
  esac
done

echo "-- usage"
"$checkout/run" help | grep -q '^usage' || fail "help"
code=0
"$checkout/run" melt >out 2>err || code=$?
test "$code" = 2 || fail "an unknown command: exit $code"
grep -q melt err || fail "an unknown command: $(cat err)"
test ! -s out || fail "an unknown command: $(cat out)"
echo "-- all as it should be"
