// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/runner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/yaml/yaml_fields.h"
#include "records/recorder.h"
#include "records/summary.h"
#include "records/telemetry/metrics.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class RunnerTest : public InTemporaryFolder {
 protected:
};

LoadedScenario Short(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {"duration_s=2", "start.settle_s=1", "seed=101"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return LoadScenario("landing", overrides);
}

TEST_F(RunnerTest, ARunLeavesAllItsRecords) {
  const LoadedScenario loaded = Short();
  const FlightResult result = RunFlight(loaded, {folder_ / "run", true, {}});
  const records::Summary& s = result.summary;
  EXPECT_EQ(s.error, "");
  EXPECT_TRUE(s.complete);
  EXPECT_EQ(s.outcome, "completed");
  EXPECT_FALSE(s.passed);  // it did not land in two seconds
  for (const char* file : {"scenario.yaml", "summary.json", "telemetry.csv", "events.log", "video.mp4"}) {
    EXPECT_TRUE(fs::exists(folder_ / "run" / file)) << file;
    EXPECT_GT(fs::file_size(folder_ / "run" / file), 50u) << file;
  }
  EXPECT_FALSE(fs::is_empty(folder_ / "run/plots"));
  for (const auto& each : fs::recursive_directory_iterator(folder_))
    EXPECT_NE(each.path().extension(), ".part");
  EXPECT_EQ(Content(folder_ / "run/scenario.yaml"), ToYaml(loaded.scenario));

  // the rows, the file of rows and the summary tell the same
  ASSERT_EQ(result.rows.size(), 41u);
  std::istringstream telemetry(Content(folder_ / "run/telemetry.csv"));
  std::string line;
  std::getline(telemetry, line);
  records::TelemetryOptions columns;
  columns.mission = &loaded.scenario.flight.type();
  EXPECT_EQ(line, records::TelemetryHeader(columns));
  for (const records::LogRow& row : result.rows) {
    ASSERT_TRUE(std::getline(telemetry, line));
    EXPECT_EQ(line, records::TelemetryLine(row, columns));
  }
  EXPECT_FALSE(std::getline(telemetry, line));
  EXPECT_EQ(s.metrics, records::Metrics(result.rows, std::nullopt, &loaded.scenario.flight.type()));
  EXPECT_NEAR(s.sim_s, 2.05, 1e-9);

  const records::Summary read = records::ReadSummary(folder_ / "run/summary.json");
  EXPECT_EQ(read.scenario, "landing");
  EXPECT_EQ(read.seed, 101u);
  EXPECT_EQ(read.state_hash, s.state_hash);
  EXPECT_EQ(read.image_hash, s.image_hash);
  EXPECT_EQ(read.renderer, s.renderer);
  EXPECT_EQ(read.metrics.size(), s.metrics.size());
  const auto json = nlohmann::json::parse(Content(folder_ / "run/summary.json"));
  for (const char* stage : {"physics", "render", "sensor", "vision", "control", "record"}) {
    ASSERT_TRUE(json["timing"]["stages"].contains(stage)) << stage;
    EXPECT_GE(json["timing"]["stages"][stage]["p99_ms"],
              json["timing"]["stages"][stage]["mean_ms"].get<double>() / 100);
  }
  EXPECT_GT(json["timing"]["stages"]["render"]["mean_ms"], 0);
  EXPECT_GT(json["timing"]["real_time_factor"], 0);
}

TEST_F(RunnerTest, ItsScenarioFileGivesTheSameRunAgain) {
  const FlightResult first = RunFlight(Short({"wind.mean_m_s=2.345"}), {folder_ / "first", true, {}});
  const LoadedScenario read = LoadScenario((folder_ / "first/scenario.yaml").string());
  const FlightResult second = RunFlight(read, {folder_ / "second", false, {}});
  const FlightResult unrecorded = RunFlight(read, {});
  for (const FlightResult* again : {&second, &unrecorded}) {
    EXPECT_EQ(again->summary.state_hash, first.summary.state_hash);
    EXPECT_EQ(again->summary.image_hash, first.summary.image_hash);
    EXPECT_EQ(again->summary.metrics, first.summary.metrics);
    EXPECT_EQ(again->summary.scenario, "landing");
  }
  EXPECT_EQ(Content(folder_ / "second/telemetry.csv"), Content(folder_ / "first/telemetry.csv"));
  EXPECT_EQ(Content(folder_ / "second/events.log"), Content(folder_ / "first/events.log"));
  EXPECT_EQ(Content(folder_ / "second/scenario.yaml"), Content(folder_ / "first/scenario.yaml"));
  EXPECT_FALSE(fs::exists(folder_ / "second/video.mp4"));
}

TEST_F(RunnerTest, CriteriaAreJudgedByTheMetrics) {
  const FlightResult met =
      RunFlight(LoadScenario("pose", {"duration_s=1", "start.settle_s=1",
                                      "criteria={fix_share: {min: 0.5, max: 1}, max_tilt_deg: {max: 30}}"}),
                {});
  EXPECT_TRUE(met.summary.passed);
  ASSERT_EQ(met.summary.criteria.size(), 3u);
  for (const records::Criterion& c : met.summary.criteria) EXPECT_EQ(c.value, met.summary.metrics.at(c.name));

  const FlightResult missed =
      RunFlight(LoadScenario("pose", {"duration_s=1", "start.settle_s=1",
                                      "criteria={fix_share: {min: 0.5}, max_tilt_deg: {max: 0.001}}"}),
                {});
  EXPECT_FALSE(missed.summary.passed);
  int failed = 0;
  for (const records::Criterion& c : missed.summary.criteria) {
    failed += !c.passed;
    EXPECT_EQ(c.passed, c.name == "fix_share");
  }
  EXPECT_EQ(failed, 1);

  // what did not happen is not met
  const FlightResult absent =
      RunFlight(LoadScenario("landing", {"duration_s=1", "start.settle_s=1",
                                         "criteria={touchdown_error_m: {max: 100}, rest_error_m: {min: 0}}"}),
                {});
  EXPECT_FALSE(absent.summary.passed);
  for (const records::Criterion& c : absent.summary.criteria) {
    EXPECT_FALSE(c.passed);
    EXPECT_TRUE(std::isnan(c.value));
  }
}

TEST_F(RunnerTest, AFaultOfTheCameraAndItsEndAreInTheLogWithTheirTimes) {
  const FlightResult result = RunFlight(Short({"image.faults=[{type: off, from_s: 0.52, until_s: 1.31}, "
                                               "{type: stuck, from_s: 1.7, until_s: 1.8}]"}),
                                        {folder_ / "run", true, {}});
  EXPECT_EQ(result.summary.error, "");
  EXPECT_EQ(result.summary.outcome, "completed");
  EXPECT_EQ(result.rows.size(), 41u - 16);
  const std::string log = Content(folder_ / "run/events.log");
  std::vector<double> times;
  std::vector<std::string> camera;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    times.push_back(std::stod(line));
    if (line.find("camera: ") != std::string::npos) camera.push_back(line);
  }
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end())) << log;
  EXPECT_THAT(camera, ::testing::ElementsAre("    0.520 s  camera: off", "    1.310 s  camera: ok",
                                             "    1.700 s  camera: stuck", "    1.800 s  camera: ok"));
}

TEST_F(RunnerTest, ACameraThatStaysOffEndsTheRunUnderThatName) {
  const FlightResult later =
      RunFlight(Short({"image.faults=[{type: off, from_s: 0.5}]"}), {folder_ / "later", true, {}});
  const FlightResult never = RunFlight(Short({"image.faults=[{type: off}]"}), {folder_ / "never", true, {}});
  EXPECT_EQ(later.rows.size(), 10u);
  EXPECT_EQ(never.rows.size(), 0u);
  for (const FlightResult* result : {&later, &never}) {
    EXPECT_EQ(result->summary.error, "");
    EXPECT_TRUE(result->summary.complete);
    EXPECT_FALSE(result->summary.passed);
    EXPECT_EQ(result->summary.outcome, "camera off");
    EXPECT_NEAR(result->summary.sim_s, 2, 1e-9);
  }
  EXPECT_THAT(Content(folder_ / "later/events.log"), HasSubstr("0.500 s  camera: off"));
  EXPECT_THAT(Content(folder_ / "never/events.log"), HasSubstr("0.000 s  camera: off"));
}

TEST_F(RunnerTest, ARunThatIsInterruptedKeepsWhatItHadAndSaysSo) {
  int frames = 0;
  const FlightResult result =
      RunFlight(Short(), {folder_ / "run", true, [&](const records::LogRow&) { return ++frames < 10; }});
  EXPECT_FALSE(result.summary.complete);
  EXPECT_FALSE(result.summary.passed);
  EXPECT_EQ(result.summary.outcome, "interrupted");
  EXPECT_EQ(result.rows.size(), 10u);
  const records::Summary read = records::ReadSummary(folder_ / "run/summary.json");
  EXPECT_FALSE(read.complete);
  EXPECT_EQ(read.error, "interrupted");
  const std::string telemetry = Content(folder_ / "run/telemetry.csv");
  EXPECT_EQ(std::count(telemetry.begin(), telemetry.end(), '\n'), 11);
  EXPECT_THAT(Content(folder_ / "run/events.log"), HasSubstr("interrupted"));
}

TEST_F(RunnerTest, AnErrorInTheMiddleBreaksTheRunOff) {
  int frames = 0;
  const FlightResult result =
      RunFlight(Short(), {folder_ / "run", false, [&](const records::LogRow&) -> bool {
                            if (++frames == 5) throw std::runtime_error("the mast broke");
                            return true;
                          }});
  EXPECT_EQ(result.summary.outcome, "broke off");
  EXPECT_EQ(result.summary.error, "the mast broke");
  EXPECT_FALSE(result.summary.complete);
  EXPECT_EQ(records::ReadSummary(folder_ / "run/summary.json").error, "the mast broke");
}

TEST_F(RunnerTest, AFolderThatCannotBeMadeIsAnErrorThatNamesIt) {
  std::ofstream(folder_ / "file") << "in the way";
  try {
    RunFlight(Short(), {folder_ / "file/run", false, {}});
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr((folder_ / "file").string()));
  }
}

}  // namespace
}  // namespace kestrel::flight
