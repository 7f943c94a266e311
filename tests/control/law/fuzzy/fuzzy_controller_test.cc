// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_controller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/yaml/yaml_fields.h"
#include "control/law/fuzzy/fuzzy_height.h"
#include "control/law/fuzzy/fuzzy_rule.h"

namespace kestrel::control {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST(Rule, IsReadInWords) {
  const ParsedRule parsed = ParseRule("if error is high  and rate is falling then descent is slow");
  ASSERT_TRUE(parsed.rule);
  EXPECT_EQ(*parsed.rule, (FuzzyRule{{{"error", "high"}, {"rate", "falling"}}, {{"descent", "slow"}}}));
}

TEST(Rule, SaysWhereItStopsBeingOne) {
  const char* const table[][2] = {
      {"", "ends where 'if' should stand"},
      {"when error is high", "has 'when' where 'if' should stand"},
      {"if error high then descent is slow", "has 'high' where 'is' should stand"},
      {"if error is then descent is slow", "has 'then' where the name of a set should stand"},
      {"if error is high or rate is falling then descent is slow",
       "has 'or' where 'and' or 'then' should stand"},
      {"if error is high", "ends where 'and' or 'then' should stand"},
      {"if error is high then descent is", "ends where the name of a set should stand"},
      {"if error is high then descent is slow with 0.5", "has 'with' where 'and' or the end should stand"},
  };
  for (const auto& [text, wrong] : table) {
    EXPECT_FALSE(ParseRule(text).rule) << text;
    EXPECT_EQ(ParseRule(text).wrong, wrong) << text;
  }
}

std::vector<std::string> MistakesOf(const FuzzyController& controller) {
  Mistakes mistakes;
  CheckController(controller, "fuzzy", Place("f.yaml", 3), mistakes);
  return mistakes.Texts();
}

TEST(Controller, OfHeightHasNoMistakes) { EXPECT_THAT(MistakesOf(HeightController()), IsEmpty()); }

TEST(Controller, ReadsBackAsItIsWritten) {
  const FuzzyController written = HeightController();
  const std::string yaml = ToYaml(written);
  Mistakes mistakes;
  FuzzyController read;
  Read(ParseConfig(yaml, "f.yaml", {}, mistakes), read, mistakes);
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  EXPECT_EQ(ToYaml(read), yaml);
  EXPECT_EQ(read.rules, written.rules);
  EXPECT_EQ(read.inputs.at("error").sets.at("low").corners,
            written.inputs.at("error").sets.at("low").corners);
}

TEST(Controller, NamesInRulesThatAreNotThereGetTheNearest) {
  FuzzyController c = HeightController();
  c.rules[0] = "if eror is near and rate is rising then descent is slow";
  c.rules[1] = "if error is neer and rate is still then descent is creeping";
  c.rules[2] = "if error is near and rate is sinking then descend is slow";
  c.rules[3] = "if descent is slow then error is near";
  EXPECT_THAT(MistakesOf(c),
              ElementsAre("f.yaml:3: fuzzy.rules.0: 'eror' is not an input; did you mean 'error'?",
                          "f.yaml:3: fuzzy.rules.1: 'error' has no set 'neer'; did you mean 'near'?",
                          "f.yaml:3: fuzzy.rules.2: 'descend' is not an output; did you mean 'descent'?",
                          "f.yaml:3: fuzzy.rules.3: 'descent' is not an input; valid: error, rate",
                          "f.yaml:3: fuzzy.rules.3: 'error' is not an output; valid: descent"));
}

TEST(Controller, WhatIsNoRuleIsShownWithWhatWouldBe) {
  FuzzyController c = HeightController();
  c.rules.push_back("error is high");
  EXPECT_THAT(
      MistakesOf(c),
      ElementsAre("f.yaml:3: fuzzy.rules.16: 'error is high' has 'error' where 'if' should stand; valid: "
                  "if INPUT is SET and INPUT is SET then OUTPUT is SET"));
}

TEST(Controller, CornersOutOfOrderAreRefused) {
  FuzzyController c = HeightController();
  c.inputs["error"].sets["low"].corners = {0.1, 0.5, 0.25, 0.5};
  EXPECT_THAT(MistakesOf(c),
              ElementsAre("f.yaml:3: fuzzy.inputs.error.sets.low.corners: [0.1, 0.5, 0.25, 0.5] "
                          "are out of order; valid: each at least as great as the one before"));
}

TEST(Controller, EveryPlaceOfAnInputsRangeIsCovered) {
  FuzzyController c = HeightController();
  c.inputs["error"].sets["middle"].corners = {0.5, 0.6, 0.6, 0.7};  // touches its neighbours at best
  c.inputs["error"].sets["high"].corners = {0.8, 0.9, 0.9, 0.95};
  EXPECT_THAT(MistakesOf(c), ElementsAre(AllOf(HasSubstr("fuzzy.inputs.error.sets: no set covers"),
                                               HasSubstr("valid: sets that cover all from 0 to 1"))));
  c = HeightController();
  c.inputs["error"].sets["middle"].corners = {0.5, 0.6, 0.6, 0.9};
  EXPECT_THAT(MistakesOf(c), ElementsAre(HasSubstr("no set covers 0.5;")));
}

TEST(Controller, RulesSayWhatEveryOutputIsWhateverTheInputs) {
  FuzzyController c = HeightController();
  c.rules.erase(c.rules.begin() + 6);  // low and sinking
  EXPECT_THAT(MistakesOf(c),
              ElementsAre("f.yaml:3: fuzzy.rules: at error = 0.25, rate = 0.4 none says what "
                          "'descent' is; add one, as 'if error is low and rate is sinking then "
                          "descent is brisk'"));
  c.rules.push_back("if error is low then descent is slow");
  EXPECT_THAT(MistakesOf(c), IsEmpty());
}

TEST(Controller, AnEmptyOneIsRefusedInAllItsParts) {
  EXPECT_THAT(MistakesOf({}),
              UnorderedElementsAre(HasSubstr("fuzzy.inputs: there is none"),
                                   HasSubstr("fuzzy.outputs: there is none"),
                                   HasSubstr("fuzzy.rules: there is no rule; valid: at least")));
}

TEST(Controller, RangesSetsAndNamesThatCannotBeAreRefused) {
  FuzzyController c = HeightController();
  c.inputs["rate"].low = 2;
  c.outputs["descent"].sets["too fast"] = {{2, 3, 3, 4}};
  c.outputs["then"];
  EXPECT_THAT(MistakesOf(c),
              UnorderedElementsAre(HasSubstr("fuzzy.inputs.rate.low: 2 is not below high = 1"),
                                   HasSubstr("sets.too fast: 'too fast' is no name"),
                                   HasSubstr("sets.too fast.corners: the set has no part of the range"),
                                   HasSubstr("fuzzy.outputs.then: 'then' is no name"),
                                   HasSubstr("fuzzy.outputs.then.sets: there is none")));
}

}  // namespace
}  // namespace kestrel::control
