// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "flight/live/live.h"
#include "tests/support/browser.h"

// The page of a flight that goes on, in Chromium: what it shows of it, and what it asks.
namespace kestrel::flight {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::function<bool()> TwiceMore() {
  return [asked = 0]() mutable { return ++asked < 3; };
}

LiveFlight FlightOf(const std::string& name) {
  LiveFlight flight;
  flight.subject.scenario = flight.subject.title = name;
  flight.subject.rate_hz = 20;
  return flight;
}

class LivePage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (Browser::Missing().empty())
      browser_ = std::make_unique<Browser>(
          testing::TempDir() + "kestrel_live_page_" + std::to_string(getpid()), Browser::WebGl::kNone);
  }
  static void TearDownTestSuite() { browser_.reset(); }
  void SetUp() override {
    if (!Browser::Missing().empty()) GTEST_SKIP() << Browser::Missing();
    ASSERT_TRUE(browser_) << "the browser did not start";
  }

  Live& Begin(LiveFlight flight) {
    LiveOptions options;
    options.server.port = port_;
    options.speed = 0;
    live_.emplace(options);
    const std::string url = live_->url();
    port_ = static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
    live_->Begin(std::move(flight));
    return *live_;
  }
  // The page, once it is told of the flight.
  void Open() {
    browser_->OpenUrl(live_->url());
    ASSERT_TRUE(Comes("live.state === 'flying'"));
    browser_->Complaints();
  }
  void Fly(int rows) {
    for (; rows > 0; --rows) {
      mission::LogRow row;
      row.sequence = flown_++;
      row.now.t_s = row.exposure.t_s = row.estimate.t_s = 0.05 * flown_;
      row.now.X_NB.p = {1, 2, -0.1 * flown_};
      live_->Row(row);
    }
  }
  static nlohmann::json Run(const std::string& script) { return browser_->Run(script); }
  static std::string Text(const std::string& css) {
    return Run("return document.querySelector('" + css + "').textContent");
  }
  static bool Shown(const std::string& css) {
    return Run("return document.querySelector('" + css + "').checkVisibility()");
  }
  // meanwhile: what the flight does.
  static bool Comes(
      const std::string& condition, const std::function<void()>& meanwhile = [] {}) {
    for (const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
         std::chrono::steady_clock::now() < end; meanwhile())
      if (Run("return Boolean(" + condition + ")") == true) return true;
    return false;
  }
  // Whether it is so at last.
  [[nodiscard]] static bool Until(const std::function<bool()>& is) {
    for (int i = 0; i < 2000; ++i) {
      if (is()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  static inline std::unique_ptr<Browser> browser_;
  std::uint16_t port_ = 0;
  std::optional<Live> live_;
  int flown_ = 0;
};

TEST_F(LivePage, ShowsRowsPicturesAndEventsAsTheyCome) {
  Live& live = Begin(FlightOf("landing <b>now</b>"));
  Fly(400);  // before anyone watches
  Open();
  live.Event(0.5, "phase", "descend <script>document.title = 'taken'</script>");
  Fly(1);
  ASSERT_TRUE(Comes("flight.rows === 401 && byId('now').textContent === '20.05 s'"));
  EXPECT_EQ(Text("h1"), "landing <b>now</b>");
  ASSERT_TRUE(Comes("document.querySelectorAll('.event').length === 1"));
  EXPECT_THAT(Text(".event"), HasSubstr("descend <script>"));
  ASSERT_TRUE(Comes("plots.get('height')"));

  EXPECT_TRUE(Comes("byId('video-pane')", [&] {
    if (live.WantsPicture(Picture::kOnBoard))
      live.Show(Picture::kOnBoard, 20, cv::Mat(48, 64, CV_8UC3, cv::Scalar(0, 0, 200)));
  }));
  EXPECT_THAT(Run("const c = document.querySelector('#video-pane canvas');"
                  "return [c.width, c.height, c.getContext('2d').getImageData(9, 9, 1, 1).data[0] > 180]"),
              nlohmann::json::array({64, 48, true}));

  // Who looks back is left there while it goes on.
  Run("clock.seek(2)");
  Fly(50);
  ASSERT_TRUE(Comes("flight.rows === 451"));
  EXPECT_EQ(Run("return clock.t_s"), 2);
  browser_->Click("#newest");
  EXPECT_TRUE(Comes("byId('now').textContent === '22.55 s'"));
  EXPECT_THAT(browser_->Complaints(), IsEmpty());
}

TEST_F(LivePage, PausesStepsAndSetsTheSpeed) {
  Live& live = Begin(FlightOf("hover"));
  Open();
  const auto held = [&] { return !live.Wait(1, TwiceMore()); };
  browser_->Click("#live-pause");
  ASSERT_TRUE(Until(held));
  ASSERT_TRUE(Comes("byId('live-pause').textContent === 'Fly on'"));
  EXPECT_EQ(Text("#live-badge"), "paused");
  browser_->Click("#live-step");
  ASSERT_TRUE(Until([&] { return !held(); }));
  EXPECT_TRUE(held());
  browser_->Click("#live-pause");
  ASSERT_TRUE(Until([&] { return !held(); }));
  browser_->Choose("#live-speed", "0.25");
  EXPECT_TRUE(Comes("live.speed === 0.25", [&] { live.Wait(1, TwiceMore()); }));
  EXPECT_THAT(browser_->Complaints(), IsEmpty());
}

TEST_F(LivePage, ChangesWhatTheScenarioLetsAndSaysWhatIsRefused) {
  LiveFlight flight = FlightOf("hover");
  flight.subject.changeable = {
      {"wind.mean_m_s", "mean wind", "3", 0, 10, {}},
      {"sensors.faults", "faults", "[]", {}, {}, {"[]", R"([{"type":"off","instance":1}])"}},
      {"flight.yaw_deg", "heading", "0", {}, {}, {}}};
  std::vector<std::string> changes;
  flight.change = [&](const std::string& key, const std::string& value) {
    changes.push_back(key + "=" + value);
    return key == "flight.yaw_deg" ? LiveAnswer{"not <i>now</i>", 1, ""}
                                   : LiveAnswer{"", 1, "kestrel run changed.yaml"};
  };
  Live& live = Begin(std::move(flight));
  Open();
  browser_->Click("#live-more summary");
  browser_->Run(
      "const slider = document.querySelector('[data-key=\"wind.mean_m_s\"] [type=range]');"
      "slider.value = 6.5; slider.dispatchEvent(new Event('input'))");
  ASSERT_TRUE(Until([&] { return live.Wait(0, TwiceMore()), changes.size() == 1; }));
  browser_->Click("[data-key=\"sensors.faults\"] button:last-child");
  ASSERT_TRUE(Until([&] { return live.Wait(0, TwiceMore()), changes.size() == 2; }));
  ASSERT_TRUE(Comes(
      "document.querySelector('[data-key=\"sensors.faults\"] [aria-pressed=true]').textContent === '1 off'"));
  browser_->Run(
      "const field = document.querySelector('[data-key=\"flight.yaw_deg\"] input');"
      "field.value = 400; field.dispatchEvent(new Event('change'))");
  ASSERT_TRUE(Until([&] { return live.Wait(0, TwiceMore()), changes.size() == 3; }));
  ASSERT_TRUE(Comes("byId('live-refused').textContent"));
  EXPECT_EQ(Text("[data-key=\"flight.yaw_deg\"] #live-refused"), "Refused: not <i>now</i>");
  EXPECT_THAT(Text("#verdict-A"), HasSubstr("kestrel run changed.yaml"));
  EXPECT_EQ(Run("return document.querySelector('[data-key=\"flight.yaw_deg\"] input').value"), "0");
  EXPECT_EQ(Run("return document.querySelector('[data-key=\"wind.mean_m_s\"] [type=number]').value"), "6.5");
  EXPECT_THAT(changes, ElementsAre("wind.mean_m_s=6.5", R"(sensors.faults=[{"instance":1,"type":"off"}])",
                                   "flight.yaw_deg=400"));
  browser_->Click("#live-pause");
  EXPECT_EQ(Text("#live-refused"), "");
  browser_->Run(
      "const field = document.querySelector('[data-key=\"wind.mean_m_s\"] [type=number]');"
      "field.value = ''; field.dispatchEvent(new Event('change'))");
  EXPECT_EQ(Text("[data-key=\"wind.mean_m_s\"] #live-refused"), "Refused: that is no number");
  EXPECT_EQ(Run("return document.querySelector('[data-key=\"wind.mean_m_s\"] [type=number]').value"), "6.5");
}

TEST_F(LivePage, OffersNothingWhereOneOnlyWatches) {
  LiveFlight flight = FlightOf("fly");
  flight.refusals = {.pace = "a real aircraft is only watched", .change = "a real aircraft is only watched"};
  flight.subject.changeable = {{"wind.mean_m_s", "mean wind", "3", 0, 10, {}}};
  Begin(std::move(flight));
  Open();
  EXPECT_EQ(Text("#live-only"), "A real aircraft is only watched.");
  EXPECT_FALSE(Shown("#live-pace"));
  EXPECT_FALSE(Shown("#live-more"));
}

TEST_F(LivePage, ComesBackAfterALossAndGoesToTheNextFlightAfterTheVerdict) {
  Begin(FlightOf("landing"));
  Open();
  Fly(3);
  ASSERT_TRUE(Comes("flight.rows === 3"));
  Run("window.same = true");
  live_.reset();
  ASSERT_TRUE(Comes("byId('live-badge').textContent === 'lost'"));
  EXPECT_TRUE(Run("return byId('live-pause').matches(':disabled')"));
  Live& live = Begin(FlightOf("landing"));
  Fly(5);
  ASSERT_TRUE(Comes("live.state === 'flying' && flight.rows === 5"));
  EXPECT_TRUE(Run("return window.same === true"));

  records::Summary summary;
  summary.outcome = "landed";
  summary.complete = summary.passed = true;
  summary.criteria = {{"rest_error_m", 0.01, 0.15, false, true}};
  live.End(summary);
  ASSERT_TRUE(Comes("live.state === 'ended'"));
  EXPECT_THAT(Text("#verdict-A"), HasSubstr("passed"));
  EXPECT_THAT(Text("#verdict-A"), HasSubstr("landed"));
  EXPECT_EQ(Run("return document.querySelectorAll('[data-criterion]').length"), 1);
  EXPECT_FALSE(Shown("#live-pace"));

  live.Begin(FlightOf("follow"));
  ASSERT_TRUE(Comes("window.same === undefined && live.state === 'flying'"));
  EXPECT_EQ(Text("h1"), "follow");
  EXPECT_EQ(Run("return flight.rows"), 0);
}

}  // namespace
}  // namespace kestrel::flight
