#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# mcap_peers.sh KESTREL: flies the beginning of a landing and reads its flight.mcap by npm's readers of others (read.mjs), images as
# JPEG and raw. Then others write it anew (write.mjs), with chunks and indexes and without, and `kestrel track` must see the same in it.
# Nothing is downloaded: `npm install` in this folder, once and by hand, brings their libraries. Exit status 77, skipped: they are not
# there.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
kestrel=$1
if ! command -v node > /dev/null || [ ! -d "$here/node_modules/@mcap/core" ]; then
  echo "skipped: no readers of MCAP by others; to have them: npm install in tests/peers/mcap, with Node.js 20"
  exit 77
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for images in jpeg raw; do
  status=0
  "$kestrel" run landing --set duration_s=3 --mcap=$images --no-video --quiet --out "$out/$images" 2> "$out/log" || status=$?
  if [ $status -gt 1 ]; then  # 1: it does not land in that time
    cat "$out/log"
    exit 1
  fi
  node "$here/read.mjs" "$out/$images"
done
# Where the pad is in each image, without the times that it took to see it.
poses() {
  "$kestrel" track "$1" --landmark helipad --csv "$out/poses.csv" > "$out/log" 2>&1 || { cat "$out/log"; exit 1; }
  [ "$(wc -l < "$out/poses.csv")" -gt 50 ]
  cut -d, -f1-33 "$out/poses.csv"
}
ours=$(poses "$out/raw/flight.mcap")
for layout in chunks plain; do
  node "$here/write.mjs" "$out/raw/flight.mcap" "$out/$layout.mcap" $layout
  [ "$(poses "$out/$layout.mcap")" = "$ours" ]
  echo "written by others, $layout: the pad is seen at the same places"
done
