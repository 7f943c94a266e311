// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/results_csv.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <limits>

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;

// By the grammar of RFC 4180.
std::vector<std::vector<std::string>> Read(const std::string& text) {
  std::vector<std::vector<std::string>> lines(1);
  std::string cell;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quoted) {
      if (text[i] != '"')
        cell += text[i];
      else if (i + 1 < text.size() && text[i + 1] == '"')
        cell += text[i++];
      else
        quoted = false;
    } else if (text[i] == '"') {
      quoted = true;
    } else if (text[i] == ',' || text[i] == '\r') {
      lines.back().push_back(std::exchange(cell, {}));
      if (text[i] == '\r') {
        EXPECT_EQ(text[++i], '\n');
        lines.emplace_back();
      }
    } else {
      cell += text[i];
    }
  }
  EXPECT_TRUE(lines.back().empty());  // the last line has an end too
  lines.pop_back();
  return lines;
}

TEST(ResultsCsv, HasALineForEachRunAndItsNumbersToTheLastBit) {
  const SampleTable table{{"seed", "wind.mean_m_s", "start.offset_m"},
                          {{"7", "1.5", "[0, 1]"}, {"8", "0.1", "[2, 3]"}}};
  RunResult first, second;
  first.row = 0, first.status = RunStatus::kTimedOut, first.outcome = "said \"no\",\r\nthen nothing";
  first.metrics = {{"b", std::numeric_limits<double>::quiet_NaN()},
                   {"c", -std::numeric_limits<double>::infinity()}};
  second.row = 1, second.status = RunStatus::kPassed, second.outcome = "landed";
  second.metrics = {{"a", 0.1 + 0.2}, {"b", 5e-324}, {"c", 1.0 / 3}};
  second.state_hash = "0123456789abcdef", second.image_hash = "fedcba9876543210";
  const std::string text = ToCsv(table, {second, first});
  EXPECT_EQ(text, ToCsv(table, {first, second}));
  const auto lines = Read(text);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_THAT(lines[0], ElementsAre("row", "seed", "wind.mean_m_s", "start.offset_m", "status", "outcome",
                                    "a", "b", "c", "state_hash", "image_hash"));
  EXPECT_THAT(lines[1],
              ElementsAre("0", "7", "1.5", "[0, 1]", "timed out", first.outcome, "", "nan", "-inf", "", ""));
  EXPECT_EQ(std::strtod(lines[2][6].c_str(), nullptr), 0.1 + 0.2);
  EXPECT_EQ(std::strtod(lines[2][7].c_str(), nullptr), 5e-324);
  EXPECT_EQ(std::strtod(lines[2][8].c_str(), nullptr), 1.0 / 3);
  EXPECT_EQ(lines[2][9], second.state_hash);
}

// As one that begins with = may call programs.
TEST(ResultsCsv, NoCellIsAFormulaToASpreadsheet) {
  const SampleTable table{{"@key", "b", "c"}, {{"-1.5", "+2e3", "-1+cmd|'/c calc'!A0"}}};
  RunResult run;
  run.outcome = "=HYPERLINK(\"http://x\")";
  const auto lines = Read(ToCsv(table, {run}));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_THAT(lines[0],
              ElementsAre("row", "'@key", "b", "c", "status", "outcome", "state_hash", "image_hash"));
  EXPECT_THAT(lines[1], ElementsAre("0", "-1.5", "+2e3", "'-1+cmd|'/c calc'!A0", "broke off",
                                    "'=HYPERLINK(\"http://x\")", "", ""));
}

}  // namespace
}  // namespace kestrel::campaign
