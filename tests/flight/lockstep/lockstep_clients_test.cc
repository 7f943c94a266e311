// SPDX-License-Identifier: Apache-2.0
// Clients of other languages by `kestrel serve --lockstep`: each flies by what the scenario's mission decides, and
// that is the flight of `kestrel run` and of a Sim, bit for bit.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "flight/stepped/sim.h"
#include "records/summary.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

using ::testing::HasSubstr;

constexpr char kFlight[] = "landing --seed 11 --set duration_s=1 --set start.settle_s=1 --no-video ";

class LockstepClientsTest : public InTemporaryFolder {
 protected:
  // The server for one client, and that client; both end. Its records are in served/.
  Ended Flown(const std::string& address, const std::string& client) {
    const Ended ended = Shell(
        folder_,
        fmt::format(
            "export KESTREL_ROOT={0}; {1} serve {2} --once --lockstep {3} --out served >serve.txt 2>&1 & "
            "server=$!; {0}/examples/lockstep/{4}; client=$?; wait $server; served=$?; "
            "[ $served = 0 ] || [ $served = 1 ] || exit 90; exit $client",
            KESTREL_SOURCE_DIR, KESTREL_PROGRAM, kFlight, address, client));
    EXPECT_EQ(ended.status, 0) << ended.err << Content(folder_ / "serve.txt");
    return ended;
  }
  // The flight that it should be.
  records::Summary Run() {
    const Ended run = Shell(folder_, fmt::format("KESTREL_ROOT={} {} run {} --out run", KESTREL_SOURCE_DIR,
                                                 KESTREL_PROGRAM, kFlight));
    EXPECT_LE(run.status, 1) << run.err;
    return records::ReadSummary(folder_ / "run/summary.json");
  }
  void ExpectTheRun(const Ended& client) {
    const records::Summary run = Run(), served = records::ReadSummary(folder_ / "served/summary.json");
    EXPECT_GT(run.sim_s, 0.9);
    EXPECT_EQ(served.state_hash, run.state_hash);
    EXPECT_EQ(served.image_hash, run.image_hash);
    EXPECT_EQ(served.metrics, run.metrics);
    EXPECT_EQ(Content(folder_ / "served/telemetry.csv"), Content(folder_ / "run/telemetry.csv"));
    EXPECT_THAT(client.out, HasSubstr(fmt::format("state_hash {:016x}", run.state_hash)));
    EXPECT_THAT(client.out, HasSubstr(fmt::format("image_hash {:016x}", run.image_hash)));
    EXPECT_THAT(client.out, HasSubstr("brightest"));
    EXPECT_EQ(client.out.find("brightest 0\n"), std::string::npos);  // it has seen images
  }
};

TEST_F(LockstepClientsTest, PythonBySharedMemoryFliesTheFlightOfARunAndOfASim) {
  const Ended client = Flown("./socket", "client.py ./socket");
  ExpectTheRun(client);
  SimOptions options;
  options.seed = 11;
  options.overrides = {"duration_s=1", "start.settle_s=1"};
  Sim sim("landing", options);
  sim.Reset();
  while (!sim.done()) {
    const mission::Decision& decision = sim.Decide();
    sim.Step(decision.setpoint, decision.aid);
  }
  EXPECT_THAT(client.out, HasSubstr(fmt::format("state_hash {:016x}", sim.Summarise().state_hash)));
}

TEST_F(LockstepClientsTest, NodeByTcpFliesTheFlightOfARun) {
  ExpectTheRun(Flown(
      "tcp:0", R"(client.mjs $(for i in $(seq 300); do )"
               R"(sed -n 's/.* tcp:\([0-9]*\),.*/\1/p' serve.txt | grep . && break; sleep 0.1; done) 11)"));
}

}  // namespace
}  // namespace kestrel
