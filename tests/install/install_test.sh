#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs a build, moves it, builds the examples against it, and flies them from it.
#   install_test.sh CMAKE BUILD
set -euo pipefail
cmake=$1 build=$2
source=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
unset KESTREL_ROOT KESTREL_PATH KESTREL_PLUGINS

fail() { echo "FAILED: $*" >&2; exit 1; }
step() { echo "-- $(date +%T) $*"; }
# $1: what a refusal must say; the rest: the command, which must end with status 2.
refused() {
  local say=$1 status=0
  shift
  "$@" >refused.txt 2>&1 || status=$?
  [[ $status == 2 ]] || { cat refused.txt; fail "status $status of: $*"; }
  grep -qF "$say" refused.txt || { cat refused.txt; fail "does not say '$say': $*"; }
}

step "install and move"
"$cmake" --install "$build" --prefix "$folder/first" --strip >install.log || { cat install.log; fail "the installation"; }
mv first prefix
prefix=$folder/prefix
root=$(sed -n 1p "$build/kestrel-source.txt")
! grep -rlF "$root" prefix || fail "the files above name the source"

step "build the examples"
"$cmake" -S "$source" -B examples -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)" >configure.log 2>&1 || { cat configure.log; fail "configure"; }
"$cmake" --build examples -j 2 >build.log 2>&1 || { cat build.log; fail "build"; }
cat >unknown.cmake <<'END'
cmake_minimum_required(VERSION 3.25)
project(unknown LANGUAGES CXX)
find_package(kestrel 0.1 REQUIRED COMPONENTS visoin)
END
mkdir unknown && mv unknown.cmake unknown/CMakeLists.txt
! "$cmake" -S unknown -B unknown/build -DCMAKE_PREFIX_PATH="$prefix" >unknown.log 2>&1 || fail "an unknown component is taken"
tr -s ' \n' ' ' <unknown.log | grep -qF "has no component 'visoin'; valid: vision, control," || { cat unknown.log; fail "the word on it"; }

step "fly"
kestrel=$prefix/bin/kestrel
circle=$source/../../examples/own_flight/circle.yaml
wide=$source/../../examples/own_camera/wide.yaml
plugins=(--plugin examples/own_flight/circle.so --plugin examples/own_camera/stereographic.so)
examples/own_law/own_law
examples/own_loop/own_loop 7 | tee loop.txt
"$kestrel" check landing >/dev/null
refused "there is no" "$kestrel" check "$circle"
"$kestrel" check "$circle" "${plugins[@]}" >/dev/null
"$kestrel" run "$circle" "${plugins[@]}" --set camera="$wide" --images --no-video --out flown
[[ -s flown/plots/circle.png ]] || fail "there is no plot of the plug-in"
grep -q 'circle.so' flown/summary.json || fail "summary.json does not name the plug-in"
grep -q '"circle_around_deg"' flown/summary.json || fail "summary.json has no metric of the plug-in"
module=$(find "$prefix" -name '_core.*.so')
if [[ -n $module ]]; then
  PYTHONPATH=$(dirname "$(dirname "$module")") /usr/bin/python3 -B -c "import kestrel
sim = kestrel.Sim('hover', overrides={'duration_s': 2}, images=False)
sim.reset()
while not sim.done: sim.step()
print(sim.summary()['outcome'])" | grep -qx completed || fail "a flight from Python"
fi
# That program knows the cameras of Kestrel alone.
"$kestrel" run landing --set duration_s=5 --images --no-video --out landing --quiet || [[ $? == 1 ]]
models=$prefix/share/kestrel/models
examples/use_vision/use_vision landing/recording/%06d.png "$models/cameras/thesis_6mm.yaml" \
  "$models/pads/helipad/helipad.yaml" | tail -1 | tee seen.txt
read -r _ _ seen _ frames _ <seen.txt
((frames > 90 && 10 * seen > 9 * frames)) || fail "use_vision does not see the pad"
"$kestrel" fly --help >fly.txt  # not to a pipe, which grep may close before all is said
grep -qF -- "kestrel-fly fly" fly.txt || fail "kestrel fly does not start kestrel-fly"
"$prefix/bin/kestrel-fly" check "$circle" "${plugins[@]}" >/dev/null

if grep -qw avx /proc/cpuinfo; then
  step "a plug-in for a newer processor, whose classes are laid out as the program's"
  "$cmake" -S "$source/../../examples/own_flight" -B avx -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_CXX_FLAGS=-mavx >configure.log 2>&1 || { cat configure.log; fail "configure with -mavx"; }
  "$cmake" --build avx >build.log 2>&1 || { cat build.log; fail "build with -mavx"; }
  "$kestrel" run "$circle" --plugin avx/circle.so --set duration_s=2 --no-video --quiet --out avx/flown || [[ $? == 1 ]] ||
    fail "a flight by a plug-in that was built with -mavx"
fi

step "a loop of one's own, built without CMake: the same flight"
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name kestrel-flight.pc)")
export PKG_CONFIG_PATH
read -ra flags < <(pkg-config --cflags --libs kestrel-flight)
"${CXX:-c++}" -w -O1 "$source/../../examples/own_loop/own_loop.cc" "${flags[@]}" -o loop || fail "the build by pkg-config"
KESTREL_ROOT=$prefix/share/kestrel ./loop 7 | cmp - loop.txt || fail "another flight"

step "a campaign, whose workers load the plug-in"
printf 'scenario: %s\nruns: 2\nset: [duration_s=2]\nvary: {wind.mean_m_s: {uniform: [0, 2]}}\n' "$circle" >campaign.yaml
"$kestrel" campaign campaign.yaml "${plugins[@]}" --jobs 1 --record-failures 0 --out campaign --quiet || [[ $? == 1 ]]
grep -rqa circle_around_deg campaign || fail "the campaign has no metric of the plug-in"

step "refusals"
refused "is no plug-in of Kestrel" "$kestrel" list --plugin "$circle"
mv prefix/share/kestrel away
refused "install Kestrel anew, or name the folder" "$kestrel" list
KESTREL_ROOT=$folder/away "$kestrel" check landing >/dev/null
step "done"
