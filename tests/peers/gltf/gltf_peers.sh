#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# gltf_peers.sh KESTREL: begins flights over worlds of each kind, and has their scene.glb read by Khronos' validator (validate.mjs).
# Nothing is downloaded: `npm install` in this folder, once and by hand, brings it. Exit status 77, skipped: it is not there.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
kestrel=$1
if ! command -v node > /dev/null || [ ! -d "$here/node_modules/gltf-validator" ]; then
  echo "skipped: no validator of glTF; to have it: npm install in tests/peers/gltf, with Node.js 20"
  exit 77
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for scenario in landing landing_ship follow attitude_1 vicon_1; do
  status=0
  "$kestrel" run $scenario --set duration_s=0.2 --no-video --quiet --out "$out/$scenario" 2> "$out/log" || status=$?
  if [ $status -gt 1 ]; then  # 1: it does not pass in that time
    cat "$out/log"
    exit 1
  fi
done
node "$here/validate.mjs" "$out"/*/scene.glb
