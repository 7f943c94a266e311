#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# pages_peers.sh KESTREL: has axe-core look at the page of a flight, of two over each other, of one while it flies and of a campaign
# (check.mjs), in Chromium.
# Nothing is downloaded: `npm install` in this folder, once and by hand, brings it. Exit status 77, skipped: it is not there.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
kestrel=$1
if ! command -v node > /dev/null || [ ! -x /usr/bin/chromium ] || [ ! -d "$here/node_modules/axe-core" ]; then
  echo "skipped: no axe-core; to have it: npm install in tests/peers/pages, with Node.js 20 and Debian's chromium"
  exit 77
fi
out=$(mktemp -d)
trap 'kill $(jobs -p) 2> /dev/null || true; wait; rm -rf "$out"' EXIT
flown() {  # 1: it does not pass in that time
  status=0
  "$kestrel" "$@" --quiet 2> "$out/log" || status=$?
  if [ $status -gt 1 ]; then
    cat "$out/log"
    exit 1
  fi
}
for seed in 1 2; do flown run landing --seed $seed --set duration_s=2 --out "$out/$seed"; done
"$kestrel" report "$out/1" "$out/2" --out "$out/two.html"
flown campaign landing/dispersion --runs 8 --set duration_s=1 --record-failures 1 --out "$out/campaign"
"$kestrel" run landing --live 0 --live-speed 0.1 --no-video --quiet --out "$out/live" > "$out/address" 2>&1 &
for _ in $(seq 100); do
  address=$(grep -o 'http://[^ ]*' "$out/address") && break
  sleep 0.1
done
node "$here/check.mjs" "$out/1/report.html" "$out/two.html" "$address" "$out/campaign/report.html"
