// SPDX-License-Identifier: Apache-2.0
#include "flight/live/live.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/diagnostics.h"
#include "base/ros/cdr.h"
#include "base/ros/messages.h"
#include "base/ros/schemas.h"
#include "base/ros/sensor_messages.h"
#include "flight/live/rate_limit.h"
#include "tests/support/live_client.h"

// The server as a program of others meets it: by Beast's client, on loopback. What it times by is a clock of the test's;
// only that something comes at all is waited for.
namespace kestrel::flight {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using nlohmann::json;
using testing::HasSubstr;

const auto kGoOn = [] { return true; };
std::function<bool()> TwiceMore() {
  return [asked = 0]() mutable { return ++asked < 3; };
}

LiveFlight FlightOf(const std::string& name) {
  LiveFlight flight;
  flight.subject.scenario = name;
  flight.subject.title = name;
  flight.messages.emplace();
  return flight;
}

mission::LogRow RowAt(std::int64_t sequence) {
  mission::LogRow row;
  row.sequence = sequence;
  row.now.t_s = row.exposure.t_s = row.estimate.t_s = static_cast<double>(sequence) / 32;
  row.now.X_NB.p = {1, 2, -3};
  return row;
}

using Client = LiveClient;

class LiveFlights : public testing::Test {
 protected:
  LiveFlights() {
    options_.server.port = 0;
    options_.speed = 0;
    options_.now_s = [this] { return now_s_.load(); };
  }
  Live& Begin(const std::string& name = "landing") {
    live_.emplace(options_);
    live_->Begin(FlightOf(name));
    return *live_;
  }
  std::uint16_t port() const {
    const std::string url = live_->url();
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }
  // Flies frames, the clock going on by a frame's time each.
  void Fly(int frames) {
    for (int i = 0; i < frames; ++i) {
      now_s_ = now_s_ + 1 / 32.0;
      live_->Row(RowAt(flown_++));
      if (live_->WantsPicture(Picture::kOnBoard)) {
        live_->Show(Picture::kOnBoard, static_cast<double>(flown_) / 32,
                    cv::Mat(48, 64, CV_8UC3, cv::Scalar(9)));
        ++shown_;
      }
      live_->Wait(static_cast<double>(flown_) / 32, kGoOn);
    }
  }
  // Whether it is held after a frame, at last.
  [[nodiscard]] bool Pauses(double t_s) {
    for (int i = 0; i < 5000; ++i) {
      if (!live_->Wait(t_s, TwiceMore())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  template <class Is>
  [[nodiscard]] bool Comes(const Is& is) {
    for (int i = 0; i < 5000; ++i) {
      now_s_ = now_s_ + 0.02;
      live_->Wait(0, kGoOn);
      if (is()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  std::string Get(const std::string& target, const std::string& more = "") {
    Client client(port());
    client.Raw("GET " + target + " HTTP/1.1\r\nHost: " + client.host() + "\r\n" + more + "\r\n");
    return client.RawAnswer();
  }

  std::atomic<double> now_s_ = 100;
  LiveOptions options_;
  std::optional<Live> live_;
  int flown_ = 0, shown_ = 0;
};

TEST_F(LiveFlights, ThePageIsThatOfAFlightThatGoesOn) {
  Begin();
  ASSERT_TRUE(Comes([&] { return Get("/").starts_with("HTTP/1.1 200"); }));
  const std::string page = Get("/");
  EXPECT_THAT(page, HasSubstr("\"live\":true"));
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy"));
  EXPECT_THAT(Get("/nowhere"), HasSubstr("404"));
  EXPECT_THAT(Get("/live"), HasSubstr("404"));
}

TEST_F(LiveFlights, AViewerWhoComesLateHasEveryRow) {
  Begin();
  Fly(700);
  Client late(port());
  ASSERT_TRUE(late.Join("/live"));
  EXPECT_EQ(late.HearOp("flight")["scenario"], "landing");
  const json names = late.HearOp("columns")["names"];
  EXPECT_EQ(names[1], "t_s");
  std::vector<int> sequence;
  while (sequence.size() < 700) {
    const json message = late.HearOp("rows");
    ASSERT_TRUE(message.is_object());
    for (const json& row : message["rows"]) {
      ASSERT_EQ(row.size(), names.size());
      sequence.push_back(row[0]);
    }
  }
  for (int i = 0; i < 700; ++i) ASSERT_EQ(sequence[static_cast<std::size_t>(i)], i);
}

TEST_F(LiveFlights, PicturesAreDrawnForWhoWatchesAlone) {
  Begin();
  Fly(64);
  EXPECT_EQ(shown_, 0);
  Client viewer(port());
  ASSERT_TRUE(viewer.Join("/live"));
  ASSERT_TRUE(Comes([&] { return live_->WantsPicture(Picture::kOnBoard); }));
  Fly(1);
  EXPECT_EQ(shown_, 1);
  std::string picture;
  while (!viewer.binary()) picture = viewer.Hear();
  ASSERT_GT(picture.size(), 9u);
  EXPECT_EQ(picture[0], 1);
  const std::vector<unsigned char> jpeg(picture.begin() + 9, picture.end());
  EXPECT_EQ(cv::imdecode(jpeg, cv::IMREAD_COLOR).size(), cv::Size(64, 48));
}

TEST_F(LiveFlights, PausesStepsAndGoesOnAsViewersAsk) {
  Live& live = Begin();
  Client viewer(port());
  ASSERT_TRUE(viewer.Join("/live"));
  viewer.Say(R"({"op":"pause"})");
  ASSERT_TRUE(Pauses(1));
  json state = viewer.HearOp("state");
  while (state.is_object() && state["paused"] != true) state = viewer.HearOp("state");
  EXPECT_EQ(state["real_time_factor"], 0);
  // Paused, it waits, and only a step lets one frame pass.
  viewer.Say(R"({"op":"step"})");
  EXPECT_TRUE(live.Wait(1, kGoOn));
  EXPECT_FALSE(live.Wait(2, TwiceMore()));
  viewer.Say(R"({"op":"resume"})");
  EXPECT_TRUE(live.Wait(2, kGoOn));
  EXPECT_TRUE(live.Wait(3, TwiceMore()));
}

TEST_F(LiveFlights, AChangeIsMadeOnTheFlightsThreadAndToldToAll) {
  live_.emplace(options_);
  LiveFlight flight = FlightOf("hover");
  const std::thread::id own = std::this_thread::get_id();
  std::vector<std::string> changes;
  flight.change = [&](const std::string& key, const std::string& value) {
    EXPECT_EQ(std::this_thread::get_id(), own);
    changes.push_back(key + "=" + value);
    return key == "wind.mean_m_s" ? LiveAnswer{"", 1.5, ""}
                                  : LiveAnswer{"'" + key + "' is not declared changeable", 1.5, ""};
  };
  live_->Begin(flight);
  Client one(port()), other(port());
  ASSERT_TRUE(one.Join("/live") && other.Join("/live"));
  one.Say(R"({"op":"change","key":"seed","value":3})");
  one.Say(R"({"op":"change","key":"wind.mean_m_s","value":4})");
  ASSERT_TRUE(Comes([&] { return changes.size() == 2; }));
  EXPECT_EQ(changes[1], "wind.mean_m_s=4");
  EXPECT_THAT(std::string(one.HearOp("refused")["why"]), HasSubstr("not declared"));
  for (Client* each : {&one, &other}) {
    const json changed = each->HearOp("changed");
    EXPECT_EQ(changed["key"], "wind.mean_m_s");
    EXPECT_EQ(changed["value"], 4);
    EXPECT_EQ(changed["t_s"], 1.5);
  }
}

TEST_F(LiveFlights, TheEndIsToldAndTheNextFlightFollows) {
  Live& live = Begin();
  Client viewer(port());
  ASSERT_TRUE(viewer.Join("/live"));
  records::Summary summary;
  summary.outcome = "landed";
  summary.passed = summary.complete = true;
  live.End(summary);
  const json end = viewer.HearOp("end");
  EXPECT_EQ(end["outcome"], "landed");
  EXPECT_EQ(end["passed"], true);
  live.Begin(FlightOf("follow"));
  EXPECT_EQ(viewer.HearOp("flight")["scenario"], "follow");
}

TEST_F(LiveFlights, WithNobodyThereTheEndIsTheEnd) {
  Live& live = Begin();
  live.End({});
  EXPECT_TRUE(live.Linger([] { return ADD_FAILURE() << "it waits for nobody", false; }));
}

TEST_F(LiveFlights, APortThatIsInUseIsSaidWithARemedy) {
  Begin();
  LiveOptions second = options_;
  second.server.port = port();
  try {
    Live again(second);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("in use"));
    EXPECT_THAT(e.what(), HasSubstr("--live 0"));
  }
  second.server.address = "somewhere";
  EXPECT_THROW(Live{second}, InputError);
}

TEST_F(LiveFlights, ForeignPagesAndNamesAreRefused) {
  Begin();
  for (const auto& [origin, host] :
       std::initializer_list<std::pair<const char*, const char*>>{{"http://evil.example", ""},
                                                                  {"null", ""},
                                                                  {"http://evil.example:1", "evil.example:1"},
                                                                  {"", "evil.example"}}) {
    Client foreign(port());
    EXPECT_FALSE(foreign.Join("/live", "", origin, host)) << origin << host;
    EXPECT_EQ(foreign.status(), 403u);
    Client foxglove(port());
    EXPECT_FALSE(foxglove.Join("/", "foxglove.websocket.v1", origin, host));
    EXPECT_EQ(foxglove.status(), 403u);
  }
  Client own(port());
  EXPECT_TRUE(own.Join("/live", "", "http://" + own.host()));
}

TEST_F(LiveFlights, OpenToOthersItAsksForTheToken) {
  options_.server.address = "0.0.0.0";
  live_.emplace(options_);
  live_->Begin(FlightOf("landing"));
  const std::string url = live_->url(), token = url.substr(url.find("?token="));
  ASSERT_EQ(token.size(), 7u + 32u);
  const auto port = static_cast<std::uint16_t>(std::stoi(url.substr(url.find(':', 6) + 1)));
  for (const char* wrong : {"/live", "/live?token=", "/live?token=0123456789abcdef0123456789abcdef"}) {
    Client client(port);
    EXPECT_FALSE(client.Join(wrong));
    EXPECT_EQ(client.status(), 403u);
  }
  Client client(port);
  EXPECT_TRUE(client.Join("/live" + token));
}

TEST_F(LiveFlights, GarbageIsRefusedAndTheFlightGoesOn) {
  Begin();
  for (const std::string& garbage :
       {std::string(1000, '\0'), std::string("\x16\x03\x01\x02"), std::string("GET / HTTP/9.9\r\n\r\n"),
        "GET /" + std::string(100000, 'a') + " HTTP/1.1\r\n\r\n",
        std::string("DELETE / HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        std::string("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n")}) {
    Client client(port());
    client.Raw(garbage + "\r\n\r\n");
    const std::string answer = client.RawAnswer();
    EXPECT_THAT(answer, testing::AnyOf(HasSubstr("HTTP/1.1 4"), testing::IsEmpty()));
    Fly(1);
  }
  Client viewer(port());
  ASSERT_TRUE(viewer.Join("/live"));
  viewer.Say("{{{{");
  EXPECT_THAT(std::string(viewer.HearOp("refused")["why"]), HasSubstr("JSON"));
  viewer.Say(R"({"op":"eject"})");
  EXPECT_THAT(std::string(viewer.HearOp("refused")["why"]), HasSubstr("eject"));
  viewer.Say("\x01\x02", true);
  EXPECT_THAT(std::string(viewer.HearOp("refused")["why"]), HasSubstr("binary"));
}

TEST_F(LiveFlights, AHugeMessageEndsItsViewerAlone) {
  Begin();
  Client huge(port()), other(port());
  ASSERT_TRUE(huge.Join("/live") && other.Join("/live"));
  try {
    huge.Say(std::string(1 << 20, 'x'));
  } catch (const boost::system::system_error&) {  // it may be closed before all has been said
  }
  while (!huge.Hear().empty()) {}
  Fly(1);
  EXPECT_FALSE(other.HearOp("rows").empty());
}

TEST_F(LiveFlights, AFloodIsToldToStopAndPutOut) {
  Begin();
  Client flood(port()), other(port());
  ASSERT_TRUE(flood.Join("/live") && other.Join("/live"));
  const auto say = [&flood](int times) {
    for (int i = 0; i < times; ++i) flood.Say(R"({"op":"resume"})");
  };
  say(static_cast<int>(RateLimit::kAtOnce) + 1);
  EXPECT_THAT(flood.HearOp("refused").dump(), HasSubstr("too many"));
  try {
    say(2 * RateLimit::kPatience);
  } catch (const boost::system::system_error&) {  // it may be closed before all has been said
  }
  while (!flood.Hear().empty()) {}
  Fly(1);
  EXPECT_FALSE(other.HearOp("rows").empty());
}

TEST_F(LiveFlights, AHalfRequestAndAHalfFrameHoldNobodyUp) {
  Begin();
  Client half(port()), frame(port()), other(port());
  half.Raw("GET / HT");
  ASSERT_TRUE(frame.Join("/live") && other.Join("/live"));
  frame.Raw("\x81\xfe");  // of a text of some length that is not said
  Fly(1);
  EXPECT_FALSE(other.HearOp("rows").empty());
  now_s_ = now_s_ + 60;
  EXPECT_EQ(half.RawAnswer(), "");  // it was closed
}

TEST_F(LiveFlights, HalfRequestsHoweverManyKeepNobodyOut) {
  Begin();
  std::vector<std::unique_ptr<Client>> half;
  for (int i = 0; i < 200; ++i) {
    half.push_back(std::make_unique<Client>(port()));
    half.back()->Raw("GET / HT");
  }
  Client viewer(port());
  ASSERT_TRUE(viewer.Join("/live"));
  EXPECT_EQ(viewer.HearOp("flight")["scenario"], "landing");
}

TEST_F(LiveFlights, AFrozenViewerIsDroppedAndCostsNoPictures) {
  Begin();
  Client frozen(port(), 4096);
  ASSERT_TRUE(frozen.Join("/live"));
  ASSERT_TRUE(Comes([&] { return live_->viewers() == 1; }));
  // It reads nothing, and this is more than is held between, so that it stays under way.
  live_->Event(0, "phase", std::string(8 << 20, 'x'));
  const cv::Mat noise(480, 640, CV_8UC3);
  cv::randu(noise, 0, 255);
  int drawn = 0;
  for (int i = 0; i < 400; ++i) {
    now_s_ = now_s_ + 0.1 / 32;  // all in all not long enough to be dropped
    if (live_->WantsPicture(Picture::kOnBoard)) live_->Show(Picture::kOnBoard, i, noise), ++drawn;
    live_->Row(RowAt(i));
    std::this_thread::yield();
  }
  EXPECT_GE(drawn, 1);
  EXPECT_LE(drawn, 2);  // one is not taken; another may be asked for before that is known
  EXPECT_EQ(live_->viewers(), 1);
  EXPECT_TRUE(Comes([&] { return live_->viewers() == 0; }));
  EXPECT_GT(now_s_, 100 + options_.server.frozen_s);
}

// As the protocol has it; against @foxglove/ws-protocol in tests/peers/foxglove.
TEST_F(LiveFlights, FoxglovesClientsGetWhatTheySubscribeTo) {
  Begin();
  Client client(port());
  ASSERT_TRUE(client.Join("/", "foxglove.sdk.v1, foxglove.websocket.v1"));
  EXPECT_EQ(client.chosen(), "foxglove.sdk.v1");
  EXPECT_EQ(client.HearOp("serverInfo")["capabilities"], json::array({"time"}));
  ASSERT_TRUE(Comes([&] { return live_->WantsImage(); }));
  live_->Row(RowAt(32), cv::Mat(48, 64, CV_8UC1, cv::Scalar(7)));
  std::map<std::string, json> channels;
  while (!channels.contains("/camera/main/annotations")) {
    const json message = client.HearOp("advertise");
    ASSERT_TRUE(message.is_object());
    for (const json& each : message["channels"]) channels[each["topic"]] = each;
  }
  const json& truth = channels.at("/truth");
  EXPECT_EQ(truth["encoding"], "cdr");
  EXPECT_EQ(truth["schemaEncoding"], "ros2msg");
  EXPECT_EQ(truth["schemaName"], "nav_msgs/msg/Odometry");
  EXPECT_EQ(truth["schema"], ros::SchemaOf("nav_msgs/msg/Odometry"));

  const json image = channels.at("/camera/main/image_raw/compressed");
  client.Say(json{
      {"op", "subscribe"},
      {"subscriptions", {{{"id", 5}, {"channelId", truth["id"]}}, {{"id", 6}, {"channelId", image["id"]}}}}}
                 .dump());
  std::map<std::uint32_t, std::string> of;
  while (of.size() < 2) {  // the newest, at once
    const std::string message = client.Hear();
    ASSERT_FALSE(message.empty());
    if (!client.binary() || message[0] != 1) continue;
    std::uint32_t id = 0;
    std::uint64_t t_ns = 0;
    std::memcpy(&id, &message[1], 4);
    std::memcpy(&t_ns, &message[5], 8);
    EXPECT_EQ(t_ns, 1'000'000'000u);
    of[id] = message.substr(13);
  }
  const auto odometry = ros::FromCdr<ros::Odometry>(of.at(5));
  EXPECT_EQ(odometry.pose.translation.x, 2);  // east of N's (1, 2, -3)
  EXPECT_EQ(odometry.pose.translation.z, 3);
  const auto picture = ros::FromCdr<ros::CompressedImage>(of.at(6));
  EXPECT_EQ(cv::imdecode(picture.data, cv::IMREAD_UNCHANGED).size(), cv::Size(64, 48));

  client.Say(R"({"op":"unsubscribe","subscriptionIds":[5,6]})");
  for (const char* wrong : {"{", R"({"op":"setParameters"})", R"({"op":"subscribe"})",
                            R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":999}]})",
                            R"({"op":"unsubscribe","subscriptionIds":[77]})"}) {
    client.Say(wrong);
    EXPECT_EQ(client.HearOp("status")["level"], 2) << wrong;
  }
}

}  // namespace
}  // namespace kestrel::flight
