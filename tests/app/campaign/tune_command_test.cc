// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/tune_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/yaml/yaml_fields.h"
#include "campaign/execution/result_store.h"
#include "flight/simulated/scenario.h"
#include "tests/campaign/scripted_worker.h"
#include "tests/support/content.h"
#include "tests/support/diagnostic_texts.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class TuneCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::ofstream(folder_ / "t.yaml")
        << "scenario: follow\n"
           "vary: {wind.mean_m_s: {uniform: [0, 6]}}\n"
           "gains:\n"
           "  pilot.servo.lambda_per_s: {low: 0.1, high: 4, log: true, start: 3.9}\n"
           "  pilot.servo.lambda_yaw_per_s: {low: 0, high: 2, start: 0.1}\n"
           "cost: {follow_distance_rms: {scale: 1}}\n"
           "budget: 120\nrows: 2\nleaders: 3\nfresh_rows: 4\nheld_out_rows: 10\n";
    // Flies nothing: least at the gains 1 and 1.2. Every flight is a line of a file.
    std::ofstream(folder_ / "worker.py") << R"(
import json, math, os, sys
def say(what):
    os.write(1, (json.dumps(what) + "\n").encode())
say({"ready": True})
for line in sys.stdin:
    order = json.loads(line)
    keys = dict(each.split("=", 1) for each in order["overrides"])
    a, b = float(keys["pilot.servo.lambda_per_s"]), float(keys["pilot.servo.lambda_yaw_per_s"])
    with open(os.path.join(sys.argv[1], "flown.txt"), "a") as file: file.write(f"{order['row']}\n")
    cost = math.log(a) ** 2 + (b - 1.2) ** 2 + 0.05 * float(keys["wind.mean_m_s"]) * (1 + 0.1 * a)
    say({"row": order["row"], "status": "passed", "outcome": "", "metrics": {"follow_distance_rms": cost},
         "state_hash": "", "image_hash": "", "flight_s": 0.01, "peak_mib": 1})
)";
  }
  TuneArguments Arguments(const std::string& out, int jobs) const {
    return {(folder_ / "t.yaml").string(),
            (folder_ / out).string(),
            {},
            0,
            jobs,
            true,
            {"/usr/bin/env", "python3", (folder_ / "worker.py").string(), folder_.string()}};
  }
  std::string Text(const fs::path& file) const { return Content(folder_ / file); }
};

TEST_F(TuneCommandTest, TheNumberOfWorkersChangesNothingAndWhatWasFlownIsNotFlownAgain) {
  EXPECT_TRUE(TuneCommand(Arguments("one", 1)));
  const std::vector<int> flown = campaign::RowsIn(folder_ / "flown.txt");
  const std::size_t flights = flown.size();
  const auto beyond = std::count_if(flown.begin(), flown.end(), [](int row) { return row >= 57; });
  EXPECT_LE(flights, 120u + 3 * 10);
  EXPECT_TRUE(TuneCommand(Arguments("three", 3)));
  EXPECT_EQ(Text("three/tuning.json"), Text("one/tuning.json"));
  EXPECT_EQ(Text("three/gains.yaml"), Text("one/gains.yaml"));
  EXPECT_THAT(campaign::RowsIn(folder_ / "flown.txt"), SizeIs(2 * flights));
  {
    const campaign::CampaignIdentity identity =
        campaign::ResultStore::Read(folder_ / "three/flights.sqlite").identity();
    campaign::ResultStore::Open(folder_ / "three/flights.sqlite", identity)
        .DropFrom(57);  // as if it had ended there
    fs::remove(folder_ / "three/gains.yaml");
  }
  EXPECT_TRUE(TuneCommand(Arguments("three", 2)));
  EXPECT_EQ(Text("three/tuning.json"), Text("one/tuning.json"));
  EXPECT_EQ(Text("three/gains.yaml"), Text("one/gains.yaml"));
  EXPECT_THAT(campaign::RowsIn(folder_ / "flown.txt"),
              SizeIs(2 * flights + static_cast<std::size_t>(beyond)));
  const flight::Scenario s =
      flight::LoadScenario("follow", {"gains=" + (folder_ / "one/gains.yaml").string()}).scenario;
  EXPECT_NEAR(s.pilot.servo.lambda_per_s, 1, 0.3);
  EXPECT_NEAR(s.pilot.servo.lambda_yaw_per_s, 1.2, 0.3);
}

// What several searches fly alike is flown once: the start and its flights on the held-out rows.
TEST_F(TuneCommandTest, MethodsAreComparedByTheRowsHeldOutOnOnePage) {
  EXPECT_TRUE(TuneCommand(Arguments("alone", 2)));
  const std::size_t alone = campaign::RowsIn(folder_ / "flown.txt").size();
  TuneArguments arguments = Arguments("all", 2);
  arguments.compare = 2;
  EXPECT_TRUE(TuneCommand(arguments));
  EXPECT_LE(campaign::RowsIn(folder_ / "flown.txt").size(), alone + 6 * alone - 5 * 10);
  for (const char* method : {"cma_es", "cross_entropy", "random_search"})
    for (const char* seed : {"1", "2"})
      EXPECT_TRUE(fs::exists(folder_ / "all" / fmt::format("{}-{}", method, seed) / "gains.yaml"));
  // The same, but for the names of what it was set to: nothing known stands for what was not flown.
  const auto tuned = [&](const char* file) {
    return nlohmann::json::parse(Text(file)).at("held_out").at("tuned");
  };
  EXPECT_EQ(tuned("all/cma_es-1/tuning.json"), tuned("alone/tuning.json"));
  const std::string page = Text("all/report.html");
  for (const char* method : {"CMA-ES", "cross-entropy", "random search"})
    EXPECT_THAT(page, HasSubstr(fmt::format("{{\"method\":\"{}\",\"repetition\":2", method)));
  EXPECT_THAT(page, HasSubstr("./kestrel run follow --set"));
}

TEST_F(TuneCommandTest, AFileMayBeNamedByItsFlight) {
  TuneArguments arguments = Arguments("out", 1);
  const auto refusal = [&](const char* file) -> std::string {
    arguments.file = file, arguments.overrides = {"budget=1"};
    try {
      TuneCommand(arguments);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("poor"), HasSubstr("'poor' is the name of "));
  EXPECT_THAT(refusal("hover/poor"), HasSubstr("budget: 1 flights are not enough"));  // so it was read
  EXPECT_THAT(refusal("porr"), HasSubstr("there is no tuning 'porr'; did you mean "
                                         "'avoid/poor' or 'follow/poor' or 'hover/poor'?"));
  EXPECT_THAT(refusal("hovr/poor"), HasSubstr("there is no tuning 'hovr/poor'; did you mean 'hover/poor'?"));
  EXPECT_THAT(refusal("quack"),
              HasSubstr("valid: avoid/poor, follow/poor, hover/family, hover/poor, landing/"));
  EXPECT_THAT(refusal(""),
              HasSubstr("no tuning is named; valid: a tuning's YAML file, or one of\n  avoid/poor   "));
}

// Flights that are only read again are not told as progress.
TEST_F(TuneCommandTest, WhatIsThereAlreadyIsNotCountedFromOneAgain) {
  EXPECT_TRUE(TuneCommand(Arguments("out", 2)));
  TuneArguments again = Arguments("out", 2);
  again.quiet = false;
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  EXPECT_TRUE(TuneCommand(again));
  testing::internal::GetCapturedStdout();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr(" flights are there already\n"));
  EXPECT_THAT(said, testing::Not(HasSubstr("round")));
}

TEST_F(TuneCommandTest, AMethodThatCannotBeComparedIsRefusedBeforeAnyFlies) {
  TuneArguments arguments = Arguments("out", 1);
  arguments.compare = 1, arguments.overrides = {"budget=34"};  // 20 candidates of cross-entropy take more
  try {
    TuneCommand(arguments);
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_THAT(Texts(e), testing::ElementsAre(testing::ContainsRegex("budget: 34 .*\\(cross_entropy\\)")));
  }
  EXPECT_FALSE(fs::exists(folder_ / "flown.txt"));
}

TEST_F(TuneCommandTest, TheFolderOfACampaignIsRefused) {
  std::ofstream(folder_ / "results.sqlite") << "";
  EXPECT_THROW(TuneCommand(Arguments(".", 1)), InputError);
}

TEST_F(TuneCommandTest, TheFolderOfAnotherTuningIsRefused) {
  EXPECT_TRUE(TuneCommand(Arguments("out", 2)));
  TuneArguments other = Arguments("out", 2);
  other.overrides = {"seed=2"};
  EXPECT_THROW(TuneCommand(other), InputError);
}

}  // namespace
}  // namespace kestrel::app
