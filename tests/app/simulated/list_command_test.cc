// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/list_command.h"

#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/file/model_files.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kKinds[] = {"scenarios", "missions", "metrics",   "vehicles", "worlds",
                                  "cameras",   "pads",     "campaigns", "tunings"};

class ListCommandTest : public InTemporaryFolder {
 protected:
  Ended List(const std::string& arguments, const std::string& environment = "") const {
    return Shell(folder_, fmt::format("{} " KESTREL_PROGRAM " list {}", environment, arguments));
  }
};

TEST_F(ListCommandTest, EverythingThatThereIsHasASentence) {
  for (const char* kind : kKinds) {
    const Ended ended = List(fmt::format("{} --json", kind));
    ASSERT_EQ(ended.status, 0) << ended.err;
    const auto items = nlohmann::json::parse(ended.out);
    EXPECT_FALSE(items.empty()) << kind;
    for (const auto& item : items) {
      EXPECT_FALSE(item.at("description").get<std::string>().empty()) << kind << ' ' << item;
      EXPECT_FALSE(item.contains("error")) << item;
    }
  }
}

TEST_F(ListCommandTest, MetricsHaveUnitsAndScenariosWhatTheyFlyWith) {
  EXPECT_THAT(ListText("metrics"), HasSubstr("touchdown_sink_m_s"));
  const auto metrics = nlohmann::json::parse(List("metrics --json").out);
  for (const auto& metric : metrics) {
    const std::string name = metric.at("name"), unit = metric.at("unit");
    std::string ending = "_" + unit;
    if (unit == "m/s") ending = "_m_s";
    EXPECT_EQ(unit != "1", name.ends_with(ending)) << name;  // one word for one thing
  }
  const auto scenarios = nlohmann::json::parse(List("--json").out);
  EXPECT_EQ(scenarios[0].at("name"), "attitude_1");
  EXPECT_EQ(scenarios[0].at("vehicle"), "pelican");
}

TEST_F(ListCommandTest, EachCampaignOfTheTreeIsNamedByItsPlace) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(Root() / "scenarios")) {
    const std::filesystem::path& path = entry.path();
    if (path.extension() == ".yaml" && path.parent_path().filename() == "campaigns")
      names.insert(path.parent_path().parent_path().filename() / path.stem());
  }
  EXPECT_TRUE(names.contains("landing/dispersion"));
  EXPECT_EQ(List("campaigns --names").out, fmt::format("{}\n", fmt::join(names, "\n")));
}

TEST_F(ListCommandTest, WhatIsNotValidIsListedWithTheReason) {
  for (const char* part : {"models", "scenarios"})
    std::filesystem::copy(Root() / part, folder_ / part, std::filesystem::copy_options::recursive);
  std::ofstream(folder_ / "scenarios/pose/pose.yaml") << "mission: pse\n";
  std::ofstream(folder_ / "models/cameras/foreign.yaml") << "cam0:\n  camera_model: pinhole\n";
  const std::string root = "KESTREL_ROOT=" + folder_.string();
  EXPECT_THAT(List("", root).out, ContainsRegex("pose +not valid: "));
  EXPECT_THAT(List("cameras", root).out, AllOf(HasSubstr("foreign"), Not(HasSubstr("not valid"))));
}

TEST_F(ListCommandTest, AKindThatThereIsNotIsAnsweredWithTheNearest) {
  const Ended ended = List("camera");
  EXPECT_EQ(ended.status, 2);
  EXPECT_THAT(ended.err, HasSubstr("did you mean 'cameras'?"));
}

}  // namespace
}  // namespace kestrel::app
