// SPDX-License-Identifier: Apache-2.0
// The page of a flight, looked at in Chromium without a screen.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "base/file/files.h"
#include "records/page/flight_data.h"
#include "records/page/flight_page.h"
#include "tests/support/browser.h"
#include "tests/support/shell.h"

namespace kestrel::records {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr const char* kMarkup = "</script><img src=x onerror=document.hit=1>&\"'";
// WebDriver's names of keys.
constexpr const char *kEnd = "\uE010", *kHome = "\uE011", *kLeft = "\uE012";

class FlightPageInBrowser : public testing::Test {
 protected:
  // Two seconds of a landing, and of another one without a video.
  static void SetUpTestSuite() {
    if (!Browser::Missing().empty()) return;
    std::string name = (fs::temp_directory_path() / "kestrel_page_XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
    const std::string run = std::string(KESTREL_PROGRAM) + " run landing --quiet --set duration_s=2 ";
    const std::string second = run + "--seed 2 --no-video --out b & ";  // both at once
    const Ended ended = Shell(folder_, second + run + "--out a; [ $? -le 1 ] && wait");
    ASSERT_EQ(ended.status, 0) << ended.err;  // 1 of the flight: it does not pass in that time
    flight_ = Json::parse(FlightData(folder_ / "a"));
    WriteFile(folder_ / "both.html", FlightPage(folder_ / "a", folder_ / "b"));
    browser_ = std::make_unique<Browser>(folder_ / "browser", Browser::WebGl::kSoftware);
  }
  static void TearDownTestSuite() {
    browser_.reset();
    fs::remove_all(folder_);
  }
  void SetUp() override {
    if (!Browser::Missing().empty()) GTEST_SKIP() << Browser::Missing();
  }

  static Json Run(const std::string& script) { return browser_->Run(script); }
  static bool Comes(const std::string& condition) {
    for (const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
         std::chrono::steady_clock::now() < end;)
      if (Run("return Boolean(" + condition + ")") == true) return true;
    return false;
  }
  static void Open(const fs::path& page) {
    browser_->PreferDark(false);
    browser_->Resize(1280, 900);
    browser_->Open(folder_ / page);
    ASSERT_TRUE(Comes("performance.getEntriesByName('media').length")) << page;
    EXPECT_EQ(Run("return performance.getEntriesByName('usable')[0].startTime < "
                  "performance.getEntriesByName('media')[0].startTime"),
              true);
  }
  static void Press(const std::string& keys) { browser_->Type("body", keys); }
  static std::string Text(const std::string& css) {
    return Run(fmt::format("return document.querySelector(\"{}\").textContent", css));
  }
  static double Value(const char* column, int row) { return flight_["columns"][column][row]; }
  static double Mean(const std::string& name) {
    browser_->SavePicture(folder_ / (name + ".png"));
    return cv::mean(cv::imread((folder_ / (name + ".png")).string()))[0];
  }
  static void NothingSticksOut() {
    browser_->Resize(390, 844);
    EXPECT_TRUE(Comes("document.documentElement.scrollWidth === 390"));
    EXPECT_EQ(Run("return [...document.querySelectorAll('main *')].filter((e) => !e.closest('.scroll *, "
                  "#phases, .out-of-sight') && e.getBoundingClientRect().right > 391).map((e) => "
                  "e.outerHTML.slice(0, 80))"),
              Json::array());
  }
  // Everything shows this row, once the search in the video has ended.
  static void Shows(int row) {
    SCOPED_TRACE(fmt::format("row {}", row));
    EXPECT_EQ(Text("#now"), fmt::format("{:.2f} s", Value("t_s", row)));
    EXPECT_EQ(Text("[data-quantity=x] .series b"),
              Run(fmt::format("return minus(({}).toFixed(3))", Value("truth_x_m", row))));
    // The middle of a screen's pixel of the cursor lies on the time of the axis.
    EXPECT_EQ(
        Run(fmt::format("const p = plots.get('x'); return Math.abs(p.chart.scales.x.getPixelForValue({}) - "
                        "new DOMMatrix(getComputedStyle(p.cursor).transform).e) < 1",
                        Value("t_s", row))),
        true);
    // In the scene x is north, y up, and its node's axes are north, west, up.
    EXPECT_EQ(Run(fmt::format(
                  "const {{x, y, z}} = sceneView.models[0].aircraft.position; return Math.hypot(x - {}, "
                  "y + {}, z + {}) < 1e-6",
                  Value("truth_x_m", row), Value("truth_y_m", row), Value("truth_z_m", row))),
              true);
    const std::string current =
        Run("return document.querySelector('.event[aria-current] .when').textContent");
    EXPECT_LE(std::stod(current), Value("t_s", row) + 1e-9);
    EXPECT_TRUE(Comes("!document.querySelector('video').seeking"));
    EXPECT_EQ(FrameOfVideo(), row);
  }
  // Which of its frames the video's element shows, by OpenCV.
  static int FrameOfVideo() {
    constexpr int kWidth = 160, kHeight = 120;
    const std::vector<int> shown = Run(fmt::format(
        "const c = document.createElement('canvas'), [w, h] = [{}, {}]; [c.width, c.height] = [w, h]; const "
        "pen = c.getContext('2d'); pen.drawImage(document.querySelector('video'), 0, 0, w, h); return "
        "[...pen.getImageData(0, 0, w, h).data].filter((_, i) => i % 4 === 1)",
        kWidth, kHeight));
    const cv::Mat wanted = cv::Mat(shown, true).reshape(1, kHeight);
    cv::VideoCapture video((folder_ / "a" / "video.mp4").string());
    cv::Mat image, small, green;
    int nearest = -1;
    double least = 1e300;
    for (int i = 0; video.read(image); ++i) {
      cv::resize(image, small, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
      cv::extractChannel(small, green, 1);
      green.convertTo(green, CV_32S);
      if (const double off = cv::norm(green, wanted, cv::NORM_L1); off < least) least = off, nearest = i;
    }
    return nearest;
  }

  static void ShowsOneInstantInAll();
  static void LeadsToEvents();
  static void ObeysKeys();
  static void Plays();
  static void DrawsPlotsThatArePicked();
  static void IsLightDarkAndOnAPhone();
  static void LaysTwoFlightsOverEachOther();
  static void ShowsAFlightWithoutAVideo();
  static void ShowsWhatThereIsOfABrokenFlight();
  static void WritesNamesWithMarkupAsText();

  static inline fs::path folder_;
  static inline Json flight_;
  static inline std::unique_ptr<Browser> browser_;
};

void FlightPageInBrowser::ShowsOneInstantInAll() {
  Run("clock.seek(1.02)");  // between rows: of them the earlier one, in space in between
  EXPECT_TRUE(Comes("document.getElementById('now').textContent === '1.02 s'"));
  browser_->Click("#frame-on");
  EXPECT_TRUE(Comes("document.getElementById('now').textContent === '1.05 s'"));
  Shows(20);
  browser_->Click("#frame-back");
  EXPECT_TRUE(Comes("document.getElementById('now').textContent === '1.00 s'"));
  Shows(19);
  // By a click into a plot, and onto the time line.
  const Json at =
      Run("const p = plots.get('height'); p.canvas.scrollIntoView({block: 'center'}); const b = "
          "p.canvas.getBoundingClientRect(); return [b.left + p.chart.scales.x.getPixelForValue(0.5), b.top "
          "+ 50]");
  browser_->ClickAt(at[0], at[1]);
  EXPECT_TRUE(Comes("Math.abs(clock.t_s - 0.5) < 0.01"));
  const Json line = Run(
      "const b = document.getElementById('time').getBoundingClientRect(); return [b.left + 0.8 * b.width, "
      "b.top + b.height / 2]");
  browser_->ClickAt(line[0], line[1]);
  EXPECT_TRUE(Comes("Math.abs(clock.t_s - clock.begin_s - 0.8 * (clock.end_s - clock.begin_s)) < 0.05"));
}

void FlightPageInBrowser::LeadsToEvents() {
  const int last = static_cast<int>(flight_["events"].size()) - 1;
  for (const int i : {last, 1}) {
    const double t_s = flight_["events"][i]["t_s"];
    browser_->Click(fmt::format("#events-list li:nth-child({}) button", i + 1));
    EXPECT_TRUE(Comes(fmt::format("Math.abs(clock.t_s - {}) < 1e-9", t_s)));
    EXPECT_TRUE(Comes(fmt::format("document.getElementById('now').textContent === '{:.2f} s'", t_s)));
  }
  Press(kHome);
  browser_->Click("#event-after");
  EXPECT_EQ(Run("return clock.t_s === allEvents().map(({t_s}) => t_s).find((t_s) => t_s > clock.begin_s + "
                "1e-3)"),
            true);
}

void FlightPageInBrowser::ObeysKeys() {
  Press(kEnd);
  EXPECT_EQ(Run("return clock.t_s"), Value("t_s", static_cast<int>(flight_["columns"]["t_s"].size()) - 1));
  Press(kLeft);
  EXPECT_EQ(Run("return Math.abs(clock.end_s - 1 - clock.t_s) < 1e-9"), true);
  Press("5");
  EXPECT_EQ(Run("return Math.abs((clock.begin_s + clock.end_s) / 2 - clock.t_s) < 1e-9"), true);
  Press(std::string(kHome) + "..,");
  EXPECT_EQ(Run("return clock.t_s"), Value("t_s", 1));
  Press("--");
  EXPECT_EQ(Run("return [clock.rate, document.getElementById('rate').value]"), Json({0.25, "0.25"}));
  // Where one chooses, keys belong to that.
  browser_->Type("#rate", "8");
  EXPECT_EQ(Run("return [clock.rate, clock.t_s]"), Json({8, Value("t_s", 1)}));
}

void FlightPageInBrowser::Plays() {
  browser_->Choose("#rate", "0.5");
  Press(std::string(kHome) + " ");
  EXPECT_TRUE(Comes("clock.t_s > clock.begin_s + 0.3 && !document.querySelector('video').paused"));
  EXPECT_EQ(Run("return document.querySelector('video').playbackRate"), 0.5);
  Press(" ");
  EXPECT_EQ(Run("return clock.playing"), false);
  const int row = Run("return clock.step(0), flight.rowAt(clock.t_s)");
  EXPECT_TRUE(Comes("document.querySelector('video').paused && !clock.due"));
  Shows(row);
  browser_->Choose("#rate", "8");
  Press(" ");
  EXPECT_TRUE(Comes("!clock.playing && clock.t_s === clock.end_s"));  // it stops by itself
}

void FlightPageInBrowser::DrawsPlotsThatArePicked() {
  const std::string pixels =
      "(() => {{ const p = plots.get('{}'); if (!p?.chart) return 0; const d = p.canvas.getContext('2d')"
      ".getImageData(0, 0, p.canvas.width, p.canvas.height).data; return d.filter((v, i) => i % 4 === 3 && "
      "v).length; }})()";
  browser_->Click("#choose summary");
  browser_->Click("#picker input[value=truth_roll_deg]");
  Run("plots.get('truth_roll_deg').element.scrollIntoView()");
  EXPECT_TRUE(Comes(fmt::format(fmt::runtime(pixels + " > 1000"), "truth_roll_deg")));
  browser_->Click("[data-quantity=truth_roll_deg] .away");
  EXPECT_EQ(Run("return [plots.has('truth_roll_deg'), "
                "document.querySelector('#picker input[value=truth_roll_deg]').checked]"),
            Json({false, false}));
  // A series is put away by its name.
  Run("plots.get('x').element.scrollIntoView({block: 'center'})");
  EXPECT_TRUE(Comes("plots.get('x').chart"));
  const Json all = Run("return plots.get('x').chart.data.datasets.length");
  browser_->Click("[data-quantity=x] .series");
  EXPECT_EQ(Run("return plots.get('x').chart.data.datasets.length"), all.get<int>() - 1);
}

void FlightPageInBrowser::IsLightDarkAndOnAPhone() {
  Run("scrollTo(0, 0)");
  EXPECT_GT(Mean("light"), 200);
  browser_->PreferDark(true);
  EXPECT_TRUE(Comes("theme.dark"));
  EXPECT_LT(Mean("dark"), 70);
  browser_->Click("#theme");
  EXPECT_EQ(Run("return theme.dark"), false);
  NothingSticksOut();
  // A name of a criterion is not broken within a word.
  EXPECT_EQ(
      Run("return [...document.querySelectorAll('.criteria th code')].filter((e) => "
          "e.getClientRects().length !== 1 || e.scrollWidth > e.clientWidth).map((e) => e.textContent)"),
      Json::array());
}

void FlightPageInBrowser::LaysTwoFlightsOverEachOther() {
  Open("both.html");
  Press("5");
  EXPECT_EQ(Run("return plots.get('x').series.map(({kind}) => kind)"),
            Json({"truth", "estimate", "fix", "second"}));
  EXPECT_TRUE(Comes("sceneView.models.length === 2 && sceneView.models[1].holder?.visible"));
  // Each is where its telemetry has it, once it is drawn.
  EXPECT_TRUE(
      Comes("flights.every((f, i) => { const p = sceneView.models[i].aircraft.position, row = "
            "f.rowAt(clock.t_s), next = Math.min(row + 1, f.rows - 1); const near = (at, name, sign) => "
            "[row, next].some((r) => Math.abs(sign * f.value(name, r) - at) < 0.05); return "
            "near(p.x, 'truth_x_m', 1) && near(p.y, 'truth_y_m', -1) && near(p.z, 'truth_z_m', -1); })"));
  EXPECT_EQ(Run("return ['A', 'B'].map((l) => document.getElementById(`verdict-${l}`).hidden)"),
            Json({false, false}));
  EXPECT_EQ(Run("return [...document.querySelectorAll('figure figcaption')].map((e) => e.textContent)"),
            Json({"On board, run A", "In space"}));
  EXPECT_EQ(
      Run("return [...new Set([...document.querySelectorAll('.event .letter')].map((e) => e.textContent))]"),
      Json({"A", "B"}));
  NothingSticksOut();
}

void FlightPageInBrowser::ShowsAFlightWithoutAVideo() {
  Open("b/report.html");
  Press("5");
  EXPECT_EQ(Run("return document.querySelector('video')"), nullptr);
  EXPECT_TRUE(Comes("sceneView.models.length && !sceneView.models[0].bare"));
  EXPECT_TRUE(Comes("document.getElementById('now').textContent !== seconds(clock.begin_s)"));
}

// As a cut of power leaves it.
void FlightPageInBrowser::ShowsWhatThereIsOfABrokenFlight() {
  const fs::path broken = folder_ / "broken";
  fs::create_directory(broken);
  for (const char* name : {"page.json", "scene.glb"}) fs::copy(folder_ / "a" / name, broken / name);
  const std::string rows = Content(folder_ / "a" / "telemetry.csv"),
                    log = Content(folder_ / "a" / "events.log");
  WriteFile(broken / "telemetry.csv.part", rows.substr(0, rows.size() / 2));
  WriteFile(broken / "events.log.part", log.substr(0, log.size() / 2));
  WriteFile(broken / "report.html", FlightPage(broken));
  Open("broken/report.html");
  EXPECT_EQ(Text("#verdict-A .badge"), "broken off");
  EXPECT_EQ(Run("return flight.rows > 10 && clock.end_s < 1.5"), true);
  Press(kEnd);
  EXPECT_TRUE(Comes("document.getElementById('now').textContent === seconds(flight.end_s)"));
}

void FlightPageInBrowser::WritesNamesWithMarkupAsText() {
  const fs::path evil = folder_ / "evil";
  fs::create_directory(evil);
  Json page = Json::parse(Content(folder_ / "a" / "page.json"));
  page["title"] = page["wanted"] = kMarkup;
  WriteFile(evil / "page.json", page.dump());
  WriteFile(evil / "telemetry.csv", std::string("t_s,phase,<b>x</b>\n0,<b>go</b>,1\n1,<b>go</b>,2\n"));
  WriteFile(evil / "events.log", fmt::format("    0.000 s  phase: {0}\n    0.500 s  {0}: x\n", kMarkup));
  WriteFile(evil / "report.html", FlightPage(evil));
  Open("evil/report.html");
  EXPECT_EQ(Text("#name"), kMarkup);
  EXPECT_EQ(Text("#wanted"), kMarkup);
  EXPECT_THAT(Text("#events-list"), HasSubstr(kMarkup));
  EXPECT_EQ(Run("return [document.hit ?? 0, document.querySelectorAll('main img').length]"), Json({0, 0}));
}

// All with one browser: to start one takes longer than to look.
TEST_F(FlightPageInBrowser, ShowsAndAnswersWithoutComplaintAndWithoutANetwork) {
  constexpr std::pair<const char*, void (*)()> kLooks[] = {
      {"ShowsOneInstantInAll", ShowsOneInstantInAll},
      {"LeadsToEvents", LeadsToEvents},
      {"ObeysKeys", ObeysKeys},
      {"Plays", Plays},
      {"DrawsPlotsThatArePicked", DrawsPlotsThatArePicked},
      {"IsLightDarkAndOnAPhone", IsLightDarkAndOnAPhone},
      {"LaysTwoFlightsOverEachOther", LaysTwoFlightsOverEachOther},
      {"ShowsAFlightWithoutAVideo", ShowsAFlightWithoutAVideo},
      {"ShowsWhatThereIsOfABrokenFlight", ShowsWhatThereIsOfABrokenFlight},
      {"WritesNamesWithMarkupAsText", WritesNamesWithMarkupAsText},
  };
  Open("a/report.html");
  for (const auto& [name, look] : kLooks) {
    SCOPED_TRACE(name);
    look();
    EXPECT_THAT(browser_->Complaints(), IsEmpty());
    EXPECT_THAT(browser_->Requests(),
                Each(testing::AnyOf(StartsWith("file:///"), StartsWith("data:"), StartsWith("blob:"))));
  }
}

TEST_F(FlightPageInBrowser, WithoutWebGlSaysSoAndShowsAllElse) {
  browser_ = std::make_unique<Browser>(folder_ / "browser", Browser::WebGl::kNone);
  Open("a/report.html");
  EXPECT_THAT(Text("#scene-pane"), HasSubstr("cannot draw in three dimensions"));
  Press("5.");
  EXPECT_TRUE(Comes("!document.querySelector('video').seeking && !clock.due"));
  EXPECT_EQ(FrameOfVideo(), Run("return flight.rowAt(clock.t_s)"));
  EXPECT_EQ(Text("#now"), Run("return seconds(clock.t_s)"));
  EXPECT_THAT(browser_->Complaints(), IsEmpty());
}

}  // namespace
}  // namespace kestrel::records
