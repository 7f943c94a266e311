// SPDX-License-Identifier: Apache-2.0
#include "base/yaml/describe_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>

namespace kestrel {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct DescribedPart {
  double length_s = 3;
};
void Fields(FieldVisitor& v, DescribedPart& p) {
  v({"length_s", "how long it lasts"}, p.length_s, 0.1, 100.0);
}

// As a fault, whose keys depend on its type.
struct DescribedCase {
  std::string type;
  double rate_hz = 1, delay_s = 0.5;
  Eigen::Vector2d both{1, 2};
};
void Fields(FieldVisitor& v, DescribedCase& p) {
  v(Required("type"), p.type, {"slow", "delayed"});
  if (p.type == "slow") v("rate_hz", p.rate_hz, 0.0, 5.0);
  if (p.type == "delayed") v("delay_s", p.delay_s, 0.0, 5.0);
  if (p.type == "slow") v("both", p.delay_s, 0.0, 5.0);
  if (p.type == "delayed") v("both", p.both, 0.0, 5.0);
}

struct Described {
  std::string name, backend = "auto";
  std::uint64_t seed = 7;
  int width_px = 640;
  bool turbulence = false;
  Eigen::Vector3d inertia{0.1, 0.2, 0.3};
  std::optional<double> max;
  DescribedPart gusts;
  std::optional<DescribedPart> more;
  std::vector<DescribedPart> list;
  std::map<std::string, DescribedPart> by_name = {{"a", {5}}};
  std::vector<std::string> words;
  std::vector<DescribedCase> cases;
};
void Fields(FieldVisitor& v, Described& p) {
  v(Required("name", "who it is"), p.name);
  v("backend", p.backend, {"auto", "egl"});
  v("seed", p.seed);
  v(Renamed("width_px", "width"), p.width_px, 16, 4096);
  v("turbulence", p.turbulence);
  v("inertia_kg_m2", p.inertia, 0.0, 1.0);
  v("max", p.max, -1e9, 1e9);
  v("gusts", p.gusts);
  v("more", p.more);
  v("list", p.list);
  v("by_name", p.by_name);
  v("words", p.words);
  v("cases", p.cases);
}

FieldDescription Of(const std::string& key) {
  for (const FieldDescription& each : Describe(Described{}))
    if (each.key == key) return each;
  ADD_FAILURE() << key;
  return {};
}

TEST(DescribeFields, AKeyHasItsMeaningItsFormerNameAndWhetherItMustBeGiven) {
  EXPECT_EQ(Of("name").meaning, "who it is");
  EXPECT_TRUE(Of("name").required);
  EXPECT_FALSE(Of("seed").required);
  EXPECT_EQ(Of("width_px").former, "width");
  EXPECT_EQ(Of("seed").meaning, "");
}

TEST(DescribeFields, ItsTypeIsSaidInWords) {
  EXPECT_EQ(TypeText(Of("name")), "text");
  EXPECT_EQ(TypeText(Of("backend")), "one of auto, egl");
  EXPECT_EQ(TypeText(Of("seed")), "integer from 0");
  EXPECT_EQ(TypeText(Of("width_px")), "integer from 16 to 4096");
  EXPECT_EQ(TypeText(Of("turbulence")), "true or false");
  EXPECT_EQ(TypeText(Of("inertia_kg_m2")), "list of 3 numbers from 0 to 1");
  EXPECT_EQ(TypeText(Of("max")), "number, or null");
  EXPECT_EQ(TypeText(Of("gusts")), "map");
  EXPECT_EQ(TypeText(Of("more")), "map, or null");
  EXPECT_EQ(TypeText(Of("list")), "list of maps");
  EXPECT_EQ(TypeText(Of("by_name")), "map of maps by names");
  EXPECT_EQ(TypeText(Of("words")), "list of texts");
}

TEST(DescribeFields, ItsDefaultIsWhatYamlWouldHave) {
  EXPECT_EQ(Of("backend").value, "auto");
  EXPECT_EQ(Of("seed").value, "7");
  EXPECT_EQ(Of("inertia_kg_m2").value, "[0.1, 0.2, 0.3]");
  EXPECT_EQ(Of("max").value, "null");
  EXPECT_EQ(Of("more").value, "null");
  EXPECT_EQ(Of("list").value, "[]");
  EXPECT_EQ(Of("gusts").value, "");
}

TEST(DescribeFields, WhatMayBeThereIsDescribedThoughItIsNot) {
  for (const char* key : {"gusts", "more", "list", "by_name"}) {
    const FieldDescription field = Of(key);
    ASSERT_EQ(field.fields.size(), 1u) << key;
    EXPECT_EQ(field.fields.front().meaning, "how long it lasts") << key;
    EXPECT_EQ(field.fields.front().value, field.key == "by_name" ? "5" : "3") << key;
  }
  EXPECT_THAT(Of("seed").fields, IsEmpty());
}

TEST(DescribeFields, KeysThatDependOnAnotherAreAllThere) {
  const std::vector<FieldDescription> fields = Of("cases").fields;
  std::vector<std::string> keys;
  for (const FieldDescription& each : fields) keys.push_back(each.key);
  EXPECT_THAT(keys, ElementsAre("type", "rate_hz", "both", "delay_s"));
  EXPECT_EQ(fields[0].value, "\"\"");
  EXPECT_EQ(fields[2].kind, FieldKind::kAny);
}

}  // namespace
}  // namespace kestrel
