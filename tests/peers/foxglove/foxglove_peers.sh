#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# foxglove_peers.sh KESTREL: flies the beginning of a landing and watches it by Foxglove's own client (watch.mjs). Nothing is
# downloaded: `npm install` in this folder, once and by hand, brings it. Exit status 77, skipped: it is not there.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
if ! command -v node > /dev/null || [ ! -d "$here/node_modules/@foxglove/ws-protocol" ]; then
  echo "skipped: no client of Foxglove's; to have it: npm install in tests/peers/foxglove, with Node.js 20"
  exit 77
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
node "$here/watch.mjs" "$1" "$out/run"
