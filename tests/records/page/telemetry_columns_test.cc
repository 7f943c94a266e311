// SPDX-License-Identifier: Apache-2.0
#include "records/page/telemetry_columns.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace kestrel::records {
namespace {

using Json = nlohmann::json;
using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(TelemetryColumns, NumbersAreThoseOfTheFileLetterByLetter) {
  const TelemetryColumnsJson columns =
      ColumnsOf("t_s,x_m\n0.05,-1.19029404\n0.1,1e-05\n0.15,\n0.2,nan\n0.25,inf\n");
  EXPECT_EQ(columns.json, R"({"t_s":[0.05,0.1,0.15,0.2,0.25],"x_m":[-1.19029404,1e-05,null,null,null]})");
  EXPECT_EQ(columns.rows, 5u);
  EXPECT_THAT(columns.rate_hz, DoubleNear(20, 1e-9));
}

TEST(TelemetryColumns, TextsAreWordsAndWhereTheyStand) {
  EXPECT_EQ(ColumnsOf("phase\nup\n\ndown\nup\n").json,
            R"({"phase":{"words":["up","down"],"at":[0,null,1,0]}})");
  // What JSON has no number for is a text as it stands; so is a column that has both.
  EXPECT_EQ(ColumnsOf("a,b,c,d\n007,1.,.5,1\n1,2,3,one\n").json,
            R"({"a":{"words":["007","1"],"at":[0,1]},"b":{"words":["1.","2"],"at":[0,1]},)"
            R"("c":{"words":[".5","3"],"at":[0,1]},"d":{"words":["1","one"],"at":[0,1]}})");
}

TEST(TelemetryColumns, AnyTextComesBack) {
  const Json json = Json::parse(ColumnsOf("n,outcome\n1,\"a, \"\"b\"\"\nc </script>\"\n2,\"\xff\"\n").json);
  EXPECT_EQ(json["outcome"]["words"][0], "a, \"b\"\nc </script>");
  EXPECT_EQ(json["outcome"]["words"][1], "\xef\xbf\xbd");
  EXPECT_EQ(json["n"], Json::array({1, 2}));
}

TEST(TelemetryColumns, WhatIsWhollyEmptyIsNotThereNorIsALineThatWasCutOff) {
  EXPECT_EQ(ColumnsOf("a,b,c\n1,,2\n3,,4\n5,,").json, R"({"a":[1,3],"c":[2,4]})");
  EXPECT_EQ(ColumnsOf("a,b\n").json, "{}");
}

TEST(TelemetryColumns, WhatIsNoTableIsRefusedWithItsRow) {
  EXPECT_THAT([] { ColumnsOf(""); }, ThrowsMessage<std::runtime_error>(HasSubstr("no first line")));
  EXPECT_THAT([] { ColumnsOf("a,b\n1,2\n3\n"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("row 3 has 1 cells, its first 2")));
}

}  // namespace
}  // namespace kestrel::records
