#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Looks for new inputs of every fuzz target, from those that it has, and keeps the fewest that reach as much of the
# code (tests/fuzz/corpora/):
#   tests/fuzz/renew_corpora.sh [SECONDS for each]
# Needs clang++ and xxd. Ends with the target's own status where one breaks.
set -euo pipefail
seconds=${1:-60}
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for source in tests/fuzz/*_fuzz.cc; do
  name=$(basename "$source" .cc) inputs=$work/$(basename "$source" .cc) number=0
  corpus=tests/fuzz/corpora/$name.hex
  mkdir "$inputs" "$inputs.least"
  while read -r line; do
    number=$((number + 1))
    xxd -r -p <<<"$line" >"$inputs/$number"
  done < <(cat "$corpus" 2>/dev/null)
  for what in "-max_total_time=$seconds -max_len=256 $inputs" "-merge=1 $inputs.least $inputs"; do
    # shellcheck disable=SC2086
    "build-fuzz/tests/fuzz/$name" -print_funcs=0 $what 2>"$work/log" || { tail -n 40 "$work/log" >&2; exit 1; }
  done
  for input in "$inputs.least"/*; do xxd -p -c 100000 "$input"; done | sort >"$corpus"
  echo "$name: $(wc -l <"$corpus") inputs"
done
