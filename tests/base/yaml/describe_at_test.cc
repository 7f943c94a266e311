// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/describe_fields.h"
#include "base/yaml/yaml_fields.h"
#include "base/yaml/yaml_nodes.h"

namespace kestrel {
namespace {

struct Part {
  std::string kind = "plain";
  double length_m = 1.5;
};
void Fields(FieldVisitor& v, Part& p) {
  v({"kind", "what it is"}, p.kind, {"plain", "fancy"});
  v({"length_m", "length of it"}, p.length_m, 0.0, 3.0);
}

struct Whole {
  Eigen::Vector3d place{1, 2, 3};
  Part own;
  std::vector<Part> parts{{"plain", 1}, {"fancy", 2}};
  std::map<std::string, Part> named{{"left", {"plain", 0.25}}};
  std::optional<Part> spare;
};
void Fields(FieldVisitor& v, Whole& w) {
  v({"place", "where it is"}, w.place, -9.0, 9.0);
  v({"own", "its own"}, w.own);
  v({"parts", "its parts"}, w.parts);
  v({"named", "its parts by names"}, w.named);
  v({"spare", "one more"}, w.spare);
}

std::optional<FieldDescription> At(const std::string& path) {
  Whole whole;
  return DescribeAt([&](FieldVisitor& v) { Fields(v, whole); }, path);
}

TEST(DescribeAt, FindsWhatAPathNamesWithItsMeaningRangeAndValue) {
  const struct {
    const char *path, *meaning, *value;
    std::optional<double> low;
  } kCases[] = {
      {"place", "where it is", "[1, 2, 3]", -9.0},
      {"place.1", "where it is", "2", -9.0},
      {"own.length_m", "length of it", "1.5", 0.0},
      {"own.kind", "what it is", "\"plain\"", std::nullopt},
      {"parts.1.length_m", "length of it", "2", 0.0},
      {"parts", "its parts",
       "[{\"kind\": \"plain\", \"length_m\": 1}, {\"kind\": \"fancy\", \"length_m\": 2}]", std::nullopt},
      {"named.left.length_m", "length of it", "0.25", 0.0},
      {"spare", "one more", "null", std::nullopt}};
  for (const auto& c : kCases) {
    const auto found = At(c.path);
    ASSERT_TRUE(found) << c.path;
    EXPECT_EQ(found->meaning, c.meaning) << c.path;
    EXPECT_EQ(found->value, c.value) << c.path;
    EXPECT_EQ(found->low, c.low) << c.path;
  }
}

TEST(DescribeAt, FindsNothingWhereThereIsNothing) {
  for (const char* path : {"", "lenght", "own.length", "own.length_m.0", "place.3", "parts.2.kind", "parts.1",
                           "parts.one.kind", "named.right.kind", "spare.kind", "place.", ".place"})
    EXPECT_FALSE(At(path)) << path;
}

TEST(FlowText, IsJsonThatMeansTheSame) {
  const auto flow = [](const std::string& yaml) {
    return FlowText(ReadNodes(yaml, [](int) { return Place(); }));
  };
  EXPECT_EQ(flow("{a: [1, -2.5e3, true, off, '3', null], \"b c\": {}}"),
            "{\"a\": [1, -2.5e3, true, \"off\", \"3\", null], \"b c\": {}}");
  for (const char* yaml :
       {".5", "+3", "007", "1.", "-", "1e", "\"a\\\"b\\\\c\\x07\"", "no: 'it''s'", "[]", "~"}) {
    const std::string text = flow(yaml);
    EXPECT_TRUE(nlohmann::json::accept(text)) << text;
    EXPECT_EQ(flow(text), text) << yaml;
  }
}

}  // namespace
}  // namespace kestrel
