// SPDX-License-Identifier: Apache-2.0
#include "flight/live/feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "flight/live/rate_limit.h"

namespace kestrel::flight {
namespace {

using nlohmann::json;

Feed FeedOf(int rows) {
  Feed feed;
  feed.Begin({{"scenario", "landing"}, {"columns", json::object()}}, "sequence,t_s,phase");
  for (int i = 0; i < rows; ++i) feed.AddRow(std::to_string(i) + "," + std::to_string(i / 32.0) + ",search");
  return feed;
}

// All that a viewer at a place is told now; pictures by their length.
std::vector<json> All(Feed& feed, Feed::Place& place) {
  std::vector<json> all;
  while (const auto message = feed.Next(place))
    all.push_back(message->binary ? json(message->bytes->size()) : json::parse(*message->bytes));
  return all;
}

TEST(LiveFeed, ALineOfTheTableIsARowOfJson) {
  EXPECT_EQ(json::parse(RowJson("3,0.125,,search,\"a, \"\"b\"\"\",nan,inf,-inf,-1e-05,1")),
            json::parse(R"([3, 0.125, null, "search", "a, \"b\"", null, null, null, -1e-05, 1])"));
  EXPECT_EQ(RowJson(""), "[null]");
  EXPECT_EQ(json::parse(RowJson("\xff,+1,0x10,.5,1.,01,1e999,true,<script>")),
            json::parse(R"(["\ufffd", "+1", "0x10", ".5", "1.", "01", "1e999", "true", "<script>"])"));
}

TEST(LiveFeed, WhoComesLateIsToldAllThatWas) {
  Feed feed = FeedOf(1000);
  feed.AddEvent(1, "phase", "search");
  feed.SetState(false, 1, 1);
  feed.AddChange("wind.mean_m_s", "4.5", 2, "kestrel run changed.yaml");
  Feed::Place late;
  std::vector<double> numbers;
  std::vector<std::string> ops;
  for (const json& each : All(feed, late)) {
    if (ops.empty() || ops.back() != each["op"]) ops.push_back(each["op"]);
    if (each["op"] == "rows")
      for (const json& row : each["rows"]) numbers.push_back(row[0]);
    EXPECT_FALSE(each.contains("columns"));
    EXPECT_EQ(each.value("value", 4.5), 4.5);
    EXPECT_EQ(each["op"] == "changed" ? each["again"] : "kestrel run changed.yaml",
              "kestrel run changed.yaml");
  }
  EXPECT_THAT(ops, testing::ElementsAre("flight", "columns", "rows", "event", "changed", "state"));
  ASSERT_EQ(numbers.size(), 1000u);
  EXPECT_TRUE(std::ranges::is_sorted(numbers));
  EXPECT_TRUE(All(feed, late).empty());
}

TEST(LiveFeed, OfPicturesAndStatesASlowViewerGetsTheLatestAndOfRowsAll) {
  Feed feed = FeedOf(0);
  Feed::Place slow;
  All(feed, slow);
  for (int i = 0; i < 100; ++i) {
    feed.AddRow("1,2,x");
    feed.SetState(false, i, 0);
    feed.AddPicture(Picture::kOnBoard, i, std::string(static_cast<std::size_t>(i), 'j'));
  }
  EXPECT_FALSE(feed.picture_taken(Picture::kOnBoard));
  const std::vector<json> all = All(feed, slow);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0]["rows"].size(), 100u);
  EXPECT_EQ(all[1]["speed"], 99);
  EXPECT_EQ(all[2], 1 + 8 + 99);
  EXPECT_TRUE(feed.picture_taken(Picture::kOnBoard));
}

TEST(LiveFeed, APictureHasItsKindAndItsTimeBeforeIt) {
  Feed feed = FeedOf(0);
  Feed::Place place;
  All(feed, place);
  feed.AddPicture(Picture::kView, 1.5, "jpeg");
  const auto message = feed.Next(place);
  ASSERT_TRUE(message && message->binary);
  double t_s = 0;
  std::memcpy(&t_s, message->bytes->data() + 1, sizeof t_s);
  EXPECT_EQ(message->bytes->at(0), 2);
  EXPECT_EQ(t_s, 1.5);
  EXPECT_EQ(message->bytes->substr(9), "jpeg");
}

TEST(LiveFeed, AFlightOfHoursTakesNoMoreMemoryThanOneOfMinutes) {
  RowStore store;
  for (int i = 0; i < 300000; ++i) {
    store.Add(std::to_string(i));
    ASSERT_LE(store.From(0).size(), RowStore::kMax);
  }
  const auto rows = store.From(0);
  EXPECT_GT(rows.size(), RowStore::kMax / 4);
  EXPECT_EQ(rows.front().number, 0);
  EXPECT_EQ(rows.back().number, 299999);
  EXPECT_EQ(store.From(300000 - static_cast<std::int64_t>(RowStore::kMax / 4)).size(), RowStore::kMax / 4);
  std::int64_t most = 0;
  for (auto row = rows.begin(); row + 1 != rows.end(); ++row) {
    EXPECT_EQ(row->text, std::to_string(row->number));
    most = std::max(most, (row + 1)->number - row->number);
  }
  EXPECT_LE(most, 300000 / static_cast<std::int64_t>(RowStore::kMax / 4));
}

TEST(LiveFeed, TheNextFlightBeginsAnewForWhoIsThere) {
  Feed feed = FeedOf(10);
  Feed::Place place;
  All(feed, place);
  feed.End({{"passed", true}});
  EXPECT_EQ(All(feed, place).back()["op"], "end");
  feed.Begin({{"scenario", "follow"}}, "t_s");
  feed.AddRow("0");
  const std::vector<json> all = All(feed, place);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0]["scenario"], "follow");
  EXPECT_EQ(all[2]["rows"], json::parse("[[0]]"));
}

TEST(LiveFeed, NamesWithMarkupOrOfNoUtf8AreText) {
  Feed feed;
  feed.Begin({{"scenario", "<script>alert(1)</script>\xff"}}, "a");
  feed.AddEvent(0, "phase", "\xc3\x28");
  Feed::Place place;
  EXPECT_EQ(All(feed, place).size(), 3u);
}

TEST(RateLimit, AFloodIsRefusedAndThenPutOut) {
  RateLimit limit;
  int taken = 0, refused = 0;
  RateLimit::Verdict last = RateLimit::Verdict::kTake;
  for (int i = 0; i < 2000 && last != RateLimit::Verdict::kPutOut; ++i) {
    last = limit.Take(5);
    taken += last == RateLimit::Verdict::kTake;
    refused += last == RateLimit::Verdict::kRefuse;
  }
  EXPECT_EQ(taken, RateLimit::kAtOnce);
  EXPECT_EQ(refused, RateLimit::kPatience);
  EXPECT_EQ(last, RateLimit::Verdict::kPutOut);
}

TEST(RateLimit, WhoIsPatientIsHeardForEver) {
  RateLimit limit;
  for (int i = 0; i < 5000; ++i)
    ASSERT_EQ(limit.Take(i / (RateLimit::kPerSecond - 1)), RateLimit::Verdict::kTake) << i;
}

}  // namespace
}  // namespace kestrel::flight
