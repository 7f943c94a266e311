// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace kestrel::campaign {

// The command of a worker that flies nothing: what it does with a row is said by the row's key "do", and what
// it reports depends on the row alone. Each row that it has flown is a line of a file; each row that it was
// given, of another.
inline std::vector<std::string> ScriptedWorker(const std::filesystem::path& folder) {
  const std::filesystem::path script = folder / "worker.py";
  std::ofstream(script) << R"(
import json, math, os, signal, sys, time
folder = sys.argv[1]
def note(name, row):
    with open(os.path.join(folder, name), "a") as file: file.write(f"{row}\n")
def say(what):
    os.write(1, (json.dumps(what) + "\n").encode())
say({"ready": True})
for line in sys.stdin:
    order = json.loads(line)
    row = order["row"]
    keys = dict(each.split("=", 1) for each in order["overrides"])
    do = keys.get("do", "")
    note("given.txt", row)
    if do:
        print("row", row, "is to", do, file=sys.stderr, flush=True)
    if do == "crash": os.kill(os.getpid(), signal.SIGSEGV)
    if do == "crash once" and not os.path.exists(os.path.join(folder, f"crashed-{row}")):
        note(f"crashed-{row}", row)
        os.abort()
    if do == "exit": os._exit(7)
    if do == "be killed": os.kill(os.getpid(), signal.SIGKILL)
    if do == "be killed once" and not os.path.exists(os.path.join(folder, f"killed-{row}")):
        note(f"killed-{row}", row)
        os.kill(os.getpid(), signal.SIGKILL)
    if do == "hang": time.sleep(1000)
    if do == "babble": os.write(1, b"I saw a bird\n")
    if do == "take another": say({"row": row + 1000, "status": "passed", "outcome": "", "metrics": {}, "state_hash": "",
                                  "image_hash": "", "flight_s": 0, "peak_mib": 0})
    if do.startswith("wait"): time.sleep(float(do.split()[1]))
    good = do != "fail" and row % 5 != 4
    if order.get("folder"): os.makedirs(order["folder"], exist_ok=True)
    status = "broke off" if do == "break off" else "refused" if do == "be refused" else "passed" if good else "failed"
    note("flown.txt", row)
    say({"row": row, "status": status, "outcome": "scripted", "metrics": {"error_m": math.sin(row), "third": 1 / 3, "none": None},
         "state_hash": "%016x" % row, "image_hash": "%016x" % (3 * row), "flight_s": 0.25, "peak_mib": 12.5})
)";
  return {"/usr/bin/env", "python3", script.string(), folder.string()};
}

// The rows that such workers have flown, or were given, as often as they were.
inline std::vector<int> RowsIn(const std::filesystem::path& file) {
  std::vector<int> rows;
  std::ifstream in(file);
  for (int row; in >> row;) rows.push_back(row);
  return rows;
}

}  // namespace kestrel::campaign
