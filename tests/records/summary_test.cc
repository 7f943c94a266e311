// SPDX-License-Identifier: Apache-2.0
#include "records/summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "records/junit.h"

namespace kestrel::records {
namespace {

using ::testing::HasSubstr;

Summary Example() {
  Summary s;
  s.scenario = "land_on_helipad";
  s.version = "0.1.0";
  s.renderer = "OSMesa";
  s.machine = {{"instruction_set", "avx2"}};
  s.outcome = "landed";
  s.seed = 18446744073709551615u;
  s.complete = s.passed = true;
  s.criteria = {{"touchdown_error_m", 0.08, 0.12, false, true}, {"visible_share", 0.99, 0.95, true, true}};
  s.metrics = {{"touchdown_error_m", 0.08}, {"yaw_rmse_deg", 1.0 / 3}};
  s.sim_s = 40, s.wall_s = 16;
  s.stages = {{"render", {5.5, 7.25}}, {"vision", {9, 14}}};
  s.state_hash = 0x1234, s.image_hash = 0xfedcba9876543210;
  return s;
}

TEST(SummaryJson, HoldsEveryPromisedFieldByName) {
  const auto json = nlohmann::json::parse(ToJson(Example()));
  for (const char* name :
       {"scenario", "seed", "version", "passed", "outcome", "criteria", "metrics", "timing", "state_hash",
        "image_hash", "renderer", "complete", "error", "machine"}) {
    EXPECT_TRUE(json.contains(name)) << name;
  }
  EXPECT_EQ(json["seed"], 18446744073709551615u);
  EXPECT_EQ(json["criteria"][1]["name"], "visible_share");
  EXPECT_EQ(json["criteria"][1]["limit"], 0.95);
  EXPECT_EQ(json["metrics"]["yaw_rmse_deg"], 1.0 / 3);
  EXPECT_EQ(json["timing"]["real_time_factor"], 2.5);
  EXPECT_EQ(json["timing"]["stages"]["render"]["p99_ms"], 7.25);
  EXPECT_EQ(json["state_hash"], "0000000000001234");
  EXPECT_EQ(json["image_hash"], "fedcba9876543210");
}

TEST(SummaryJson, ReadsBackAsItWas) {
  const std::string json = ToJson(Example());
  const Summary back = SummaryFromJson(json, "summary.json");
  EXPECT_EQ(ToJson(back), json);
  EXPECT_EQ(back.seed, Example().seed);
  EXPECT_EQ(back.image_hash, Example().image_hash);
  EXPECT_TRUE(back.criteria.at(1).at_least);
  EXPECT_EQ(back.stages.at("vision").p99_ms, 14);
  EXPECT_EQ(back.machine, Example().machine);
}

TEST(SummaryJson, AnOlderOneIsReadAndItsMachineIsNotKnown) {
  auto older = nlohmann::json::parse(ToJson(Example()));
  older.erase("machine");
  EXPECT_TRUE(SummaryFromJson(older.dump(), "summary.json").machine.empty());
}

TEST(SummaryJson, WhatIsNoNumberIsNull) {
  Summary s = Example();
  s.metrics["touchdown_error_m"] = std::numeric_limits<double>::quiet_NaN();
  s.criteria[0].value = std::numeric_limits<double>::infinity();
  s.wall_s = 0;
  const auto json = nlohmann::json::parse(ToJson(s));
  EXPECT_TRUE(json["metrics"]["touchdown_error_m"].is_null());
  EXPECT_TRUE(json["criteria"][0]["value"].is_null());
  EXPECT_EQ(json["timing"]["real_time_factor"], 0);
  EXPECT_TRUE(std::isnan(SummaryFromJson(ToJson(s), "s").metrics.at("touchdown_error_m")));
}

TEST(SummaryJson, WhatIsNoSummaryIsRefusedByName) {
  for (const std::string text : {"", "{}", "[1]", "{\"scenario\": 3}"}) {
    try {
      SummaryFromJson(text, "some.json");
      ADD_FAILURE() << text;
    } catch (const std::runtime_error& e) {
      EXPECT_THAT(e.what(), HasSubstr("some.json: not a summary"));
    }
  }
  EXPECT_THROW(ReadSummary("/nowhere/summary.json"), std::runtime_error);
}

TEST(Junit, HasACaseForEachCriterionAndTheFailureHasValueAndLimit) {
  Summary failed = Example();
  failed.seed = 2, failed.passed = false;
  failed.criteria[0] = {"touchdown_error_m", 0.31, 0.12, false, false};
  failed.criteria[1] = {"visible_share", 0.5, 0.95, true, false};
  Summary other = Example();
  other.scenario = "hover <&> \"hold\"";
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(ToJunit({Example(), other, failed}).c_str()));
  const auto root = document.child("testsuites");
  EXPECT_EQ(root.attribute("tests").as_int(), 6);
  EXPECT_EQ(root.attribute("failures").as_int(), 2);
  EXPECT_EQ(root.attribute("errors").as_int(), 0);
  const auto suite = root.find_child_by_attribute("testsuite", "name", "land_on_helipad");
  EXPECT_EQ(suite.attribute("tests").as_int(), 4);
  EXPECT_EQ(suite.attribute("failures").as_int(), 2);
  EXPECT_EQ(suite.attribute("time").as_double(), 32);
  EXPECT_EQ(std::distance(suite.children("testcase").begin(), suite.children("testcase").end()), 4);
  const auto bad = suite.find_child_by_attribute("testcase", "classname", "land_on_helipad.seed_2");
  EXPECT_STREQ(bad.attribute("name").value(), "touchdown_error_m");
  EXPECT_EQ(bad.attribute("time").as_double(), 8);
  EXPECT_STREQ(bad.child("failure").attribute("message").value(),
               "touchdown_error_m is 0.31; it must be at most 0.12");
  EXPECT_STREQ(bad.next_sibling("testcase").child("failure").attribute("message").value(),
               "visible_share is 0.5; it must be at least 0.95");
  EXPECT_TRUE(root.find_child_by_attribute("testsuite", "name", "hover <&> \"hold\""));
}

TEST(Junit, AMetricThatAFlightDidNotComeToIsNotReached) {
  Summary none = Example();
  none.passed = false;
  none.criteria = {{"touchdown_error_m", std::numeric_limits<double>::quiet_NaN(), 0.12, false, false}};
  const std::string xml = ToJunit({none});
  EXPECT_THAT(xml, HasSubstr("touchdown_error_m was not reached; it must be at most 0.12"));
  EXPECT_THAT(xml, testing::Not(HasSubstr("nan")));
}

TEST(Junit, ARunThatBrokeOffIsAnError) {
  Summary broken = Example();
  broken.complete = broken.passed = false;
  broken.criteria.clear();
  broken.error = "cannot write video.mp4: \x01 full";
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(ToJunit({broken}).c_str()));
  const auto suite = document.child("testsuites").child("testsuite");
  EXPECT_EQ(suite.attribute("errors").as_int(), 1);
  EXPECT_EQ(suite.attribute("failures").as_int(), 0);
  EXPECT_STREQ(suite.child("testcase").child("error").attribute("message").value(),
               "the run broke off: cannot write video.mp4: ? full");
}

TEST(Junit, ARunThatFailedWithoutAFailedCriterionIsAFailureWithItsOutcome) {
  Summary lost = Example();
  lost.passed = false;
  lost.outcome = "target lost";
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(ToJunit({lost}).c_str()));
  const auto suite = document.child("testsuites").child("testsuite");
  EXPECT_EQ(suite.attribute("tests").as_int(), 3);
  EXPECT_EQ(suite.attribute("failures").as_int(), 1);
  EXPECT_THAT(suite.child("testcase").child("failure").attribute("message").value(),
              HasSubstr("target lost"));
}

TEST(Junit, AWholeRunWithoutCriteriaIsOnePassedCase) {
  Summary flight = Example();
  flight.criteria.clear();
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(ToJunit({flight}).c_str()));
  EXPECT_EQ(document.child("testsuites").attribute("tests").as_int(), 1);
  EXPECT_EQ(document.child("testsuites").attribute("failures").as_int(), 0);
}

}  // namespace
}  // namespace kestrel::records
