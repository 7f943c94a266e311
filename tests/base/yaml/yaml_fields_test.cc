// SPDX-License-Identifier: Apache-2.0
#include "base/yaml/yaml_fields.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <limits>
#include <random>

#include "base/nearest_name.h"
#include "tests/support/diagnostic_texts.h"

namespace kestrel {

struct TestGusts {
  double rate_per_min = 1;
  double length_s = 3;
};
void Fields(FieldVisitor& v, TestGusts& p) {
  v("rate_per_min", p.rate_per_min, 0.0, 60.0);
  v("length_s", p.length_s, 0.1, 100.0);
}

struct TestLimit {
  std::optional<double> max, min;
};
void Fields(FieldVisitor& v, TestLimit& p) {
  v("max", p.max, -1e9, 1e9);
  v("min", p.min, -1e9, 1e9);
}

struct TestRules {
  std::vector<std::string> rules = {"if error is high then descent is fast", "plain", "", "yes"};
  std::vector<std::string> none;
};
void Fields(FieldVisitor& v, TestRules& p) {
  v("rules", p.rules);
  v("none", p.none);
}

struct TestFlight {
  std::string name = "unnamed", backend = "auto";
  std::uint64_t seed = 0;
  double mean_m_s = 1.5;
  int width_px = 640;
  bool turbulence = false;
  Eigen::Vector3d inertia{0.1, 0.2, 0.3};
  Eigen::Vector2d size{1, 2};
  TestGusts gusts;
  std::optional<TestGusts> more;
  std::vector<TestGusts> list;
  std::map<std::string, TestLimit> criteria;
};
void Fields(FieldVisitor& v, TestFlight& p) {
  v(Required("name"), p.name);
  v("backend", p.backend, {"auto", "osmesa", "egl"});
  v("seed", p.seed);
  v("mean_m_s", p.mean_m_s, 0.0, 20.0);
  v("width_px", p.width_px, 16, 4096);
  v("turbulence", p.turbulence);
  v("inertia_kg_m2", p.inertia, 1e-5, 1.0);
  v("size_m", p.size, -10.0, 10.0);
  v("gusts", p.gusts);
  v("more", p.more);
  v("list", p.list);
  v("criteria", p.criteria);
}

namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

struct Result {
  TestFlight flight;
  std::vector<std::string> mistakes;
  std::string shown;  // of all together
};

Result ReadText(const std::string& text, const std::vector<std::string>& overrides = {}) {
  Mistakes mistakes;
  Result result;
  Read(ParseConfig(text, "f.yaml", overrides, mistakes), result.flight, mistakes);
  result.mistakes = mistakes.Texts();
  result.shown = InputError(mistakes.all()).what();
  return result;
}

TEST(FieldWriter, WritesListsOfTextsThatReadBackTheSame) {
  const std::string text = ToYaml(TestRules{});
  EXPECT_EQ(
      text,
      "rules:\n  - \"if error is high then descent is fast\"\n  - plain\n  - \"\"\n  - \"yes\"\nnone: []\n");
  Mistakes mistakes;
  TestRules read{{}, {"one"}};
  Read(ParseConfig(text, "f.yaml", {}, mistakes), read, mistakes);
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  EXPECT_EQ(read.rules, TestRules{}.rules);
  EXPECT_THAT(read.none, IsEmpty());
}

TEST(YamlFields, EveryKindOfFieldIsReadAndDefaultsStayWhereNothingIsSaid) {
  const auto [flight, mistakes, shown] = ReadText(R"(
name: landing
backend: egl
seed: 18446744073709551615
mean_m_s: 4
width_px: 320
turbulence: true
inertia_kg_m2: [1e-2, 0.02, +0.04]
gusts: {rate_per_min: 5}
more:
  length_s: 7
list:
  - {length_s: 1}
  - {rate_per_min: 2, length_s: 2}
criteria:
  touchdown_error_m: {max: 0.12}
  tilt_deg: {min: -3}
)");
  EXPECT_THAT(mistakes, IsEmpty());
  EXPECT_EQ(flight.name, "landing");
  EXPECT_EQ(flight.backend, "egl");
  EXPECT_EQ(flight.seed, 18446744073709551615u);
  EXPECT_EQ(flight.mean_m_s, 4);
  EXPECT_EQ(flight.width_px, 320);
  EXPECT_TRUE(flight.turbulence);
  EXPECT_EQ(flight.inertia, Eigen::Vector3d(0.01, 0.02, 0.04));
  EXPECT_EQ(flight.size, Eigen::Vector2d(1, 2));
  EXPECT_EQ(flight.gusts.rate_per_min, 5);
  EXPECT_EQ(flight.gusts.length_s, 3);
  ASSERT_TRUE(flight.more);
  EXPECT_EQ(flight.more->length_s, 7);
  ASSERT_EQ(flight.list.size(), 2u);
  EXPECT_EQ(flight.list[0].rate_per_min, 1);
  EXPECT_EQ(flight.list[1].length_s, 2);
  ASSERT_EQ(flight.criteria.size(), 2u);
  EXPECT_EQ(flight.criteria.at("touchdown_error_m").max, 0.12);
  EXPECT_FALSE(flight.criteria.at("touchdown_error_m").min);
  EXPECT_EQ(flight.criteria.at("tilt_deg").min, -3);
}

TEST(YamlFields, AllMistakesAreReportedAtOnceWithLineKeyValueAndWhatIsValid) {
  const auto [flight, mistakes, shown] = ReadText(R"(backend: osmes
seed: -1
mean_m_s: 300
width_px: 32.5
turbulence: maybe
inertia_kg_m2: [0.1, 2, 0.1]
size_m: [1, 2, 3]
gusts:
  rate_per_min: fast
  lenght_s: 4
  duty: 3
  rate_per_min: .nan
list:
  - length_s: .inf
  - 5
criteria:
  tilt_deg: {maxi: 1}
)");
  EXPECT_THAT(
      mistakes,
      ElementsAre("f.yaml:1: name: must be given",
                  "f.yaml:1: backend: 'osmes' is not valid; did you mean 'osmesa'? valid: auto, osmesa, egl",
                  "f.yaml:2: seed: '-1' is not valid; valid: a whole number, 0 to 18446744073709551615",
                  "f.yaml:3: mean_m_s: 300 is out of range; valid: 0 to 20",
                  "f.yaml:4: width_px: 32.5 is not a whole number; valid: 16 to 4096",
                  "f.yaml:5: turbulence: 'maybe' is not valid; valid: true, false",
                  "f.yaml:6: inertia_kg_m2.1: 2 is out of range; valid: 1e-05 to 1",
                  "f.yaml:7: size_m: a list of 3 is not valid; valid: a list of 2 numbers, each -10 to 10",
                  "f.yaml:12: gusts.rate_per_min: given twice, first at f.yaml:9",
                  "f.yaml:12: gusts.rate_per_min: .nan is not a finite number; valid: 0 to 60",
                  "f.yaml:10: gusts.lenght_s: unknown key; did you mean 'length_s'?",
                  "f.yaml:11: gusts.duty: unknown key; valid: rate_per_min, length_s",
                  "f.yaml:14: list.0.length_s: .inf is not a finite number; valid: 0.1 to 100",
                  "f.yaml:15: list.1: '5' is not valid; valid: a map of rate_per_min, length_s",
                  "f.yaml:17: criteria.tilt_deg.maxi: unknown key; did you mean 'max'?"));
  EXPECT_EQ(flight.mean_m_s, 1.5);
  EXPECT_EQ(flight.inertia, Eigen::Vector3d(0.1, 0.2, 0.3));
}

TEST(YamlFields, ValuesOfTheWrongTypeAreRefused) {
  const std::string number = " is not a number; valid: 0 to 20";
  for (const auto& [written, shown] : std::vector<std::pair<std::string, std::string>>{{"\"3\"", "'3'"},
                                                                                       {"[3]", "a list of 1"},
                                                                                       {"{a: 3}", "a map"},
                                                                                       {"", "nothing"},
                                                                                       {"0x10", "'0x10'"},
                                                                                       {"3 m", "'3 m'"},
                                                                                       {"true", "'true'"},
                                                                                       {"1,5", "'1,5'"},
                                                                                       {"+-1", "'+-1'"}}) {
    EXPECT_THAT(ReadText("name: a\nmean_m_s: " + written).mistakes,
                ElementsAre("f.yaml:2: mean_m_s: " + shown + number));
  }
  EXPECT_THAT(ReadText("name: a\nmean_m_s: 1e999").mistakes,
              ElementsAre("f.yaml:2: mean_m_s: 1e999 is not a finite number; valid: 0 to 20"));
  EXPECT_THAT(ReadText("name: [a]").mistakes, ElementsAre("f.yaml:1: name: a list of 1 is not a text"));
  EXPECT_THAT(ReadText("name: a\nlist: 3").mistakes, ElementsAre("f.yaml:2: list: '3' is not a list"));
  EXPECT_THAT(ReadText("name: a\ncriteria: [1]").mistakes,
              ElementsAre("f.yaml:2: criteria: a list of 1 is not a map"));
  EXPECT_THAT(ReadText("name: a\ngusts: strong").mistakes,
              ElementsAre("f.yaml:2: gusts: 'strong' is not valid; valid: a map of rate_per_min, length_s"));
  EXPECT_THAT(ReadText("name: a\nseed: 18446744073709551616").mistakes, testing::SizeIs(1));
  EXPECT_THAT(ReadText("name: a\nseed: \"5\"").mistakes, testing::SizeIs(1));
}

TEST(YamlFields, TheEndsOfARangeAreValid) {
  EXPECT_THAT(ReadText("{name: a, mean_m_s: 0, width_px: 4096}").mistakes, IsEmpty());
  EXPECT_THAT(ReadText("{name: a, mean_m_s: 20, width_px: 16}").mistakes, IsEmpty());
  EXPECT_THAT(ReadText("{name: a, mean_m_s: 20.000000000000004, width_px: 15}").mistakes, testing::SizeIs(2));
}

TEST(YamlFields, AFileThatIsNoYamlIsRefusedWithItsLineAndNothingElseIsSaid) {
  EXPECT_THAT(ReadText("name: a\ngusts: {length_s: 3\n").mistakes,
              ElementsAre(StartsWith("f.yaml:3: not valid YAML: ")));
  EXPECT_THAT(ReadText("a: &x [*x]\n").mistakes,
              ElementsAre(HasSubstr("f.yaml:1: not valid YAML: an alias within what it stands for")));
  EXPECT_THAT(ReadText("a: " + std::string(40, '[') + std::string(40, ']')).mistakes,
              ElementsAre(HasSubstr("nested too deeply")));
  EXPECT_THAT(ReadText("name: a\n---\nname: b\n").mistakes, ElementsAre(HasSubstr("more than one document")));
  EXPECT_THAT(ReadText("[1, 2]: a\n").mistakes, ElementsAre(HasSubstr("a key must be a name")));
  EXPECT_THAT(ReadText("name: a\n# W\xe4rme\n").mistakes,
              ElementsAre(HasSubstr("f.yaml:2: it is not in UTF-8")));
  EXPECT_THAT(ReadText("# W\xc3\xa4rme\n").mistakes, ElementsAre(HasSubstr("name: must be given")));
  EXPECT_THAT(ReadText("").mistakes, ElementsAre("f.yaml:1: name: must be given"));
  EXPECT_THAT(ReadText("just words").mistakes, ElementsAre(HasSubstr("f.yaml:1: 'just words' is not valid")));
}

TEST(YamlFields, AnAliasStandsForWhatItsAnchorHolds) {
  const auto [flight, mistakes, shown] = ReadText(
      "name: &n a\ngusts: &g {length_s: 3}\nmore: *g\nlist: [*g, {length_s: 2}]\nseed: &s 5\nwidth_px: 20");
  EXPECT_THAT(mistakes, IsEmpty());
  EXPECT_EQ(flight.gusts.length_s, 3);
  ASSERT_TRUE(flight.more);
  EXPECT_EQ(flight.more->length_s, 3);
  ASSERT_EQ(flight.list.size(), 2u);
  EXPECT_EQ(flight.list[0].length_s, 3);
  EXPECT_THAT(ReadText("name: a\ngusts: &g {\n length: 3}\nmore: *g").mistakes,
              ElementsAre(HasSubstr("f.yaml:3: gusts.length: unknown key"),
                          HasSubstr("f.yaml:3: more.length: unknown key")));
}

// A few lines that stand for a million values, or for gigabytes of text.
TEST(YamlFields, AliasesAreFollowedToABoundedCount) {
  std::string nested = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n",
              texts = nested + "t: &t " + std::string(500'000, 'x') + '\n';
  for (int i = 1; i < 8; ++i) {
    nested += fmt::format(
        "a{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
    texts += fmt::format("t{}: [*t, *t, *t, *t, *t, *t, *t, *t, *t, *t]\n", i);
  }
  EXPECT_THAT(ReadText(nested).mistakes, ElementsAre(AllOf(StartsWith("f.yaml:5: not valid YAML: too much"),
                                                           HasSubstr("valid: up to 50000 keys and values"))));
  EXPECT_THAT(ReadText(texts).mistakes, ElementsAre(HasSubstr("not valid YAML: too much")));
  // As deep as an anchor within an anchor within an anchor can make it.
  std::string deep = "a0: &a0 " + std::string(30, '[') + '1' + std::string(30, ']') + '\n';
  EXPECT_THAT(ReadText(deep + "a1: [[[*a0]]]\n").mistakes,
              ElementsAre(HasSubstr("f.yaml:2: not valid YAML: nested too deeply")));
  std::string list = "list: [1";
  for (int i = 0; i < 60'000; ++i) list += ",1";
  EXPECT_THAT(ReadText(list + "]").mistakes, ElementsAre(HasSubstr("too much")));
}

TEST(YamlFields, OfManyMistakesTheFirstFiftyAreShownAndOfALongOneItsEnds) {
  std::string keys = "name: a\n";
  for (int i = 0; i < 1000; ++i) keys += fmt::format("key{}: 1\n", i);
  EXPECT_THAT(ReadText(keys).mistakes, testing::SizeIs(1000));
  const std::string shown = ReadText(keys).shown;
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 50);
  EXPECT_THAT(shown, AllOf(StartsWith("f.yaml:2: key0: unknown key"), testing::EndsWith("\nand 950 more")));
  const std::string long_one = ReadText("name: a\n? " + std::string(100'000, 'k') + "\n: 1\n").shown;
  EXPECT_LT(long_one.size(), 2100u);
  EXPECT_THAT(long_one,
              AllOf(StartsWith("f.yaml:2: kkk"), HasSubstr(" [...] "), HasSubstr("unknown key; valid: ")));
}

TEST(YamlFields, AMissingFileIsNamedWithTheReason) {
  Mistakes mistakes;
  TestFlight flight;
  Read(LoadConfig("/nowhere/f.yaml", {}, mistakes), flight, mistakes);
  Read(LoadConfig("/", {}, mistakes), flight, mistakes);
  EXPECT_THAT(mistakes.Texts(), ElementsAre("/nowhere/f.yaml: cannot be read: No such file or directory",
                                            "/: is a folder, not a file"));
}

TEST(YamlFields, OverridesReplaceAddAndReachIntoLists) {
  const auto [flight, mistakes, shown] =
      ReadText("name: a\nmean_m_s: 300\nlist: [{length_s: 1}, {length_s: 2}]\nmore: {length_s: 5}",
               {"mean_m_s=3", "gusts.length_s=9", "list.1.length_s=4", "size_m=[3, 4]", "name=x=y",
                "criteria.tilt_deg.max=2", "more=null", "seed=1", "seed=2"});
  EXPECT_THAT(mistakes, IsEmpty());
  EXPECT_EQ(flight.mean_m_s, 3);
  EXPECT_EQ(flight.gusts.length_s, 9);
  ASSERT_EQ(flight.list.size(), 2u);
  EXPECT_EQ(flight.list[0].length_s, 1);
  EXPECT_EQ(flight.list[1].length_s, 4);
  EXPECT_EQ(flight.size, Eigen::Vector2d(3, 4));
  EXPECT_EQ(flight.name, "x=y");
  EXPECT_EQ(flight.criteria.at("tilt_deg").max, 2);
  EXPECT_FALSE(flight.more);
  EXPECT_EQ(flight.seed, 2u);
}

TEST(YamlFields, AnElementOfAVectorTakesAnOverrideThoughTheVectorIsNotGiven) {
  const auto [flight, mistakes, shown] = ReadText("name: a", {"size_m.1=4", "inertia_kg_m2.0=0.5"});
  EXPECT_THAT(mistakes, IsEmpty());
  EXPECT_EQ(flight.size, Eigen::Vector2d(1, 4));
  EXPECT_EQ(flight.inertia, Eigen::Vector3d(0.5, 0.2, 0.3));
  EXPECT_THAT(ReadText("name: a", {"size_m.2=4", "inertia_kg_m2.0=7"}).mistakes,
              ElementsAre("--set inertia_kg_m2.0=7: inertia_kg_m2.0: 7 is out of range; valid: 1e-05 to 1",
                          "--set size_m.2=4: size_m: a map is not valid; valid: a list of 2 numbers, each "
                          "-10 to 10"));
}

struct Listed {
  std::vector<std::string> names = {"as it was"};
  ConfigNode rest;
};
void Fields(FieldVisitor& v, Listed& l) {
  v("names", l.names);
  v("rest", l.rest);
}

TEST(YamlFields, ListsOfTextsAndNodesAsTheyStand) {
  Mistakes mistakes;
  Listed listed;
  Read(ParseConfig("names: [a=1, b]\nrest: {c: [1]}\n", "f.yaml", {}, mistakes), listed, mistakes);
  EXPECT_THAT(listed.names, ElementsAre("a=1", "b"));
  ASSERT_EQ(listed.rest.members.size(), 1u);
  EXPECT_EQ(listed.rest.members[0].key, "c");
  EXPECT_EQ(listed.rest.members[0].node.where.Text(), "f.yaml:2");
  Read(ParseConfig("names: [a, [b]]\n", "f.yaml", {}, mistakes), listed, mistakes);
  Read(ParseConfig("names: a\n", "f.yaml", {}, mistakes), listed, mistakes);
  EXPECT_THAT(mistakes.Texts(), ElementsAre("f.yaml:1: names.1: a list of 1 is not a text",
                                            "f.yaml:1: names: 'a' is not a list"));
}

TEST(YamlFields, MistakesInOverridesNameTheOverride) {
  EXPECT_THAT(ReadText("name: a\nlist: [{length_s: 1}]\nmean_m_s: 3",
                       {"gusts.length_s=300", "gust.length_s=3", "turbulence", "mean_m_s.x=1",
                        "list.3.length_s=2", "backend={", "=3"})
                  .mistakes,
              ElementsAre("--set turbulence: not of the form key.path=value",
                          "--set mean_m_s.x=1: mean_m_s: is a single value: it has no keys below it",
                          "--set list.3.length_s=2: list.3: the list has 1 elements, counted from 0",
                          StartsWith("--set backend={: backend: the value is not valid YAML"),
                          "--set =3: not of the form key.path=value",
                          "--set gusts.length_s=300: gusts.length_s: 300 is out of range; valid: 0.1 to 100",
                          "--set gust.length_s=3: gust: unknown key; did you mean 'gusts'?"));
}

TEST(YamlFields, AnOverrideOfAnAliasLeavesItsAnchorAlone) {
  const auto [flight, mistakes, shown] =
      ReadText("name: a\ngusts: &g {length_s: 5}\nmore: *g", {"more.length_s=8"});
  EXPECT_THAT(mistakes, IsEmpty());
  EXPECT_EQ(flight.gusts.length_s, 5);
  EXPECT_EQ(flight.more->length_s, 8);
}

TEST(YamlFields, TheErrorHoldsEveryMistakeOnALine) {
  Mistakes mistakes;
  EXPECT_NO_THROW(mistakes.ThrowIfAny());
  mistakes.Add("a.yaml:1", "x", "wrong");
  mistakes.Add("b.yaml:2", "", "worse");
  try {
    mistakes.ThrowIfAny();
    FAIL();
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(), "a.yaml:1: x: wrong\nb.yaml:2: worse");
    EXPECT_EQ(Texts(e).size(), 2u);
  }
}

TEST(YamlFields, TheNearestNameIsAGuessOnlyWhenNear) {
  const std::vector<std::string> names = {"latency_s", "rate_hz", "x"};
  EXPECT_EQ(NearestName("latncy_s", names), "latency_s");
  EXPECT_EQ(NearestName("rat", names), std::nullopt);
  EXPECT_EQ(NearestName("ratehz", names), "rate_hz");
  EXPECT_EQ(NearestName("completely", names), std::nullopt);
  EXPECT_EQ(NearestName("", names), "x");
}

TEST(YamlFields, WrittenTextReadsBackToTheSameBits) {
  std::mt19937_64 engine(7);
  int checked = 0;
  for (int i = 0; i < 200; ++i) {
    TestFlight flight;
    const auto bits = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(engine);
    };
    static const std::vector<std::string> kNames = {
        "plain", "with space", "12",   "true", "",     "a: b", "\"q\" \\ \n\t\x01",
        "é#",    "- x",        "null", "~",    "it's", "No"};
    flight.name = kNames[i % kNames.size()];
    flight.seed = engine();
    flight.mean_m_s = bits(0, 20);
    flight.inertia = {bits(1e-5, 1), 1e-5, std::nextafter(1.0, 0.0)};
    flight.size = {-0.0, bits(-1e-300, 1e-300)};
    if (i % 2) flight.more = TestGusts{bits(0, 60), bits(0.1, 100)};
    if (i % 3) flight.list = {{bits(0, 60), 1}, {2, bits(0.1, 100)}};
    flight.criteria[flight.name.empty() ? "b" : flight.name].max = bits(-1e9, 1e9);
    flight.criteria["c"];

    const std::string text = ToYaml(flight);
    const auto [back, mistakes, shown] = ReadText(text);
    ASSERT_THAT(mistakes, IsEmpty()) << text;
    EXPECT_EQ(back.name, flight.name);
    EXPECT_EQ(back.seed, flight.seed);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(back.mean_m_s), std::bit_cast<std::uint64_t>(flight.mean_m_s));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(back.inertia[k], flight.inertia[k]);
    EXPECT_TRUE(std::signbit(back.size[0]));
    EXPECT_EQ(back.size[1], flight.size[1]);
    EXPECT_EQ(back.more.has_value(), flight.more.has_value());
    EXPECT_EQ(back.list.size(), flight.list.size());
    EXPECT_EQ(ToYaml(back), text);
    ++checked;
  }
  EXPECT_EQ(checked, 200);
}

TEST(YamlFields, TheWrittenTextIsReadable) {
  TestFlight flight;
  flight.list = {{}, {2, 4}};
  flight.criteria["tilt_deg"].max = 0.25;
  EXPECT_EQ(ToYaml(flight), R"(name: unnamed
backend: auto
seed: 0
mean_m_s: 1.5
width_px: 640
turbulence: false
inertia_kg_m2: [0.1, 0.2, 0.3]
size_m: [1, 2]
gusts:
  rate_per_min: 1
  length_s: 3
more: null
list:
  - rate_per_min: 1
    length_s: 3
  - rate_per_min: 2
    length_s: 4
criteria:
  tilt_deg:
    max: 0.25
    min: null
)");
}

// Whatever the file is of: nothing that is read from it depends on the sentence.
TEST(Description, IsOfTheFileAndNotOfWhatIsReadFromIt) {
  Mistakes mistakes;
  const Config config = ParseConfig("description: A balloon on a string.\nmean: 2\n", "f.yaml", {}, mistakes);
  EXPECT_EQ(config.description, "A balloon on a string.");
  ASSERT_EQ(config.root.members.size(), 1u);
  EXPECT_EQ(config.root.members[0].key, "mean");
  EXPECT_EQ(ParseConfig("mean: 2\n", "f.yaml", {}, mistakes).description, "");
  EXPECT_TRUE(mistakes.empty());
}

TEST(Description, IsOneLineOfText) {
  for (const std::string given : {"[a, b]", "\"two\\nlines\"", "''", "{a: b}"}) {
    Mistakes mistakes;
    EXPECT_EQ(ParseConfig("a: 1\ndescription: " + given, "f.yaml", {}, mistakes).description, "");
    ASSERT_EQ(mistakes.Texts().size(), 1u) << given;
    EXPECT_THAT(mistakes.Texts()[0], testing::HasSubstr("f.yaml:2: description: "));
    EXPECT_THAT(mistakes.Texts()[0], testing::HasSubstr("valid: a sentence of up to 200 bytes in one line"));
  }
}

}  // namespace
}  // namespace kestrel
