// SPDX-License-Identifier: Apache-2.0
#include "campaign/report/html_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "campaign/report/page_data.h"
#include "campaign/report/trajectory.h"
#include "tests/campaign/landing_campaign.h"
#include "tests/support/browser.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

// Of this process alone; it stays, for a look at the pictures, where TEST_TMPDIR asks for it.
fs::path Scratch() {
  return fs::path(testing::TempDir()) /
         (std::getenv("TEST_TMPDIR") ? "kestrel_report" : fmt::format("kestrel_report_{}", getpid()));
}

fs::path Folder(const std::string& name) {
  const fs::path folder = Scratch() / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

class Cleanup : public testing::Environment {
  void TearDown() override {
    if (!std::getenv("TEST_TMPDIR")) fs::remove_all(Scratch());
  }
};
[[maybe_unused]] const auto* const kCleanup = testing::AddGlobalTestEnvironment(new Cleanup);

void Write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

TEST(PageData, KeepsEveryBitAndEndsNoScript) {
  const fs::path folder = Folder("bits");
  ReportSubject subject = LandingCampaign(20, folder);
  RunResult& run = subject.results[3];
  run.status = RunStatus::kCrashed;
  run.outcome = "</script><!-- \xff";
  run.metrics["touchdown_error_m"] = 0.1 + 0.2;
  run.metrics["touchdown_s"] = std::numeric_limits<double>::infinity();
  run.metrics.erase("rest_error_m");
  const std::string text = PageData(subject, folder);
  EXPECT_THAT(text, Not(HasSubstr("<")));
  const Json data = Json::parse(text);
  const Json& read = data["runs"][3];
  EXPECT_EQ(read["outcome"], "</script><!-- \xef\xbf\xbd");
  const std::vector<std::string> metrics = data["metrics"];
  const auto value = [&](const std::string& name) -> const Json& {
    return read["metrics"][std::find(metrics.begin(), metrics.end(), name) - metrics.begin()];
  };
  EXPECT_EQ(value("touchdown_error_m").get<double>(), 0.1 + 0.2);
  EXPECT_TRUE(value("touchdown_s").is_null());
  EXPECT_TRUE(value("rest_error_m").is_null());
  EXPECT_EQ(data["limits"]["touchdown_error_m"]["max"], 0.12);
  EXPECT_EQ(data["summary"]["rows"], 20);
}

// Records lie beside the page, and are found there again when both were moved.
TEST(PageData, LinksRecordsFromThePage) {
  const fs::path folder = Folder("links");
  ReportSubject subject = LandingCampaign(4, folder);
  RunResult& run = subject.results[2];
  Write(folder / "recordings" / "2" / "video.mp4", "film");
  EXPECT_EQ(Json::parse(PageData(subject, folder))["runs"][2]["video"], "./recordings/2/video.mp4");
  run.execution.recording = "results/campaigns/elsewhere/recordings/2";
  const Json moved = Json::parse(PageData(subject, folder));
  EXPECT_EQ(moved["runs"][2]["video"], "./recordings/2/video.mp4");
  fs::remove_all(folder / "recordings" / "2");
  EXPECT_FALSE(Json::parse(PageData(subject, folder))["runs"][2].contains("video"));
}

TEST(Trajectory, HasEndsAndNoHalfLines) {
  const fs::path file = Folder("trajectory") / "telemetry.csv";
  std::string text = "t_s,truth_y_m,truth_x_m,phase,truth_z_m\n";
  for (int k = 0; k <= 1000; ++k) text += fmt::format("{},{},{},go,{}\n", k, 2 * k, 3 * k, -4 * k);
  Write(file, text + "1001,2002");
  const auto t = ReadTrajectory(file, 11);
  ASSERT_TRUE(t);
  EXPECT_THAT(t->t_s, ElementsAre(0, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000));
  EXPECT_EQ(t->east_m[1], 200);
  EXPECT_EQ(t->north_m[1], 300);
  EXPECT_EQ(t->height_m[1], 400);
  Write(file, "t_s,truth_x_m\n1,2\n");
  EXPECT_FALSE(ReadTrajectory(file, 11));
  EXPECT_FALSE(ReadTrajectory(file.string() + "x", 11));
}

TEST(HtmlReport, HoldsItsLibraryWithItsLicenceAndNamesNothingElsewhere) {
  const fs::path folder = Folder("whole");
  const std::string page = HtmlReport(LandingCampaign(30, folder), folder);
  const auto has = [&](const char* text) { return page.find(text) != std::string::npos; };
  EXPECT_TRUE(has("Released under the MIT License"));
  EXPECT_TRUE(has("permission notice"));
  for (const char* fetched : {"<link rel=\"stylesheet", "src=\"http", "@import", "url(http"})
    EXPECT_FALSE(has(fetched)) << fetched;
}

// What follows is looked at in Chromium, without a screen.
class ReportInBrowser : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!Browser::Missing().empty()) return;
    folder_ = Folder("page");
    ReportSubject subject = LandingCampaign(1000, folder_);
    Write(folder_ / "report.html", HtmlReport(subject, folder_));
    subject.tuning = HoverTuning();
    subject.tuning->verdict = "The tuned gains are better.";
    Write(folder_ / "tuning.html", HtmlReport(subject, folder_));
    browser_ = std::make_unique<Browser>(folder_ / "browser", Browser::WebGl::kNone);
  }
  static void TearDownTestSuite() { browser_.reset(); }

  void SetUp() override {
    if (!Browser::Missing().empty()) GTEST_SKIP() << Browser::Missing();
  }
  static void Open(const char* page) {
    browser_->PreferDark(false);
    browser_->Resize(1280, 900);
    browser_->Open(folder_ / page);
  }
  static Json Run(const std::string& script) { return browser_->Run(script); }
  // What the window shows.
  static cv::Mat Picture(const std::string& name) {
    const fs::path file = folder_ / (name + ".png");
    browser_->SavePicture(file);
    cv::Mat image = cv::imread(file.string());
    EXPECT_FALSE(image.empty());
    return image;
  }
  // Charts answer with the next picture of the window, not at once.
  static bool Comes(const std::string& condition) {
    for (const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
         std::chrono::steady_clock::now() < end;)
      if (Run("return Boolean(" + condition + ")") == true) return true;
    return false;
  }
  // Scrolls to a chart's point and clicks on it.
  static void ClickPoint(const std::string& chart, int dataset, int index) {
    const Json at =
        Run(fmt::format("const c = charts['{}']; c.canvas.scrollIntoView({{block: 'center'}}); const b = "
                        "c.canvas.getBoundingClientRect(), "
                        "p = c.getDatasetMeta({}).data[{}]; return [b.left + p.x, b.top + p.y];",
                        chart, dataset, index));
    browser_->ClickAt(at[0], at[1]);
  }

  static void SaysHowManyPassedWithTheInterval();
  static void DrawsAnyParameterAgainstAnyMetric();
  static void ShowsTheRunOfAClickedPointWithTheCommandThatFliesItAgain();
  static void SortsAndFiltersTheTable();
  static void FiltersByAClickOnHowRunsEnded();
  static void ShowsVideosOfWorstRuns();
  static void TakesForWorstWhatTheCriterionKeepsFrom();
  static void WritesQuartersAsTheyAre();
  static void SpeaksOfTheIndicesThatItDraws();
  static void DrawsEveryChartInLightAndDarkAndOnAPhone();
  static void ShowsWhatThereIsOfAlmostNothing();
  static void PrintsOnPaper();
  static void DrawsTheConvergenceOfATuning();

  static inline fs::path folder_;
  static inline std::unique_ptr<Browser> browser_;
};

void ReportInBrowser::SaysHowManyPassedWithTheInterval() {
  const Json summary = Run("return data.summary");
  const double share = summary["success"]["value"];
  EXPECT_EQ(Run("return document.getElementById('share').textContent"), fmt::format("{:.1f} %", 100 * share));
  EXPECT_THAT(Run("return document.querySelector('.interval').textContent").get<std::string>(),
              HasSubstr(fmt::format("{:.1f} % to {:.1f} %", 100 * summary["success"]["low"].get<double>(),
                                    100 * summary["success"]["high"].get<double>())));
  EXPECT_EQ(Run("return document.querySelector('#thresholds tbody').rows.length"), 2);
  EXPECT_EQ(Run("return document.title"), "landing_dispersion – Kestrel");
}

void ReportInBrowser::DrawsAnyParameterAgainstAnyMetric() {
  browser_->Choose("#scatter-x", "wind.mean_m_s");
  browser_->Choose("#scatter-y", "touchdown_tilt_deg");
  const Json shown =
      Run("return charts['scatter-chart'].data.datasets[1].data.every(p => p.run.status === 'passed' && "
          "p.x === Number(p.run.values[data.keys.indexOf('wind.mean_m_s')]) && "
          "p.y === p.run.metrics[data.metrics.indexOf('touchdown_tilt_deg')])");
  EXPECT_EQ(shown, true);
  // Each run is one point, the ones without the metric too.
  EXPECT_EQ(Run("return charts['scatter-chart'].data.datasets.reduce((n, d) => n + d.data.filter(p => "
                "p.run).length, 0)"),
            1000);
  browser_->Choose("#scatter-x", "world");
  EXPECT_EQ(Run("return charts['scatter-chart'].scales.x.ticks.map(t => t.label).filter(Boolean)"),
            Json({"autumn_clear", "summer_sun", "winter_cloudy"}));
  browser_->Click("#scatter-log");
  EXPECT_EQ(Run("return charts['scatter-chart'].scales.y.type"), "logarithmic");
}

void ReportInBrowser::ShowsTheRunOfAClickedPointWithTheCommandThatFliesItAgain() {
  browser_->Choose("#scatter-x", "image.latency_s");
  const Json row = Run("return charts['scatter-chart'].data.datasets[0].data[0].run.row");
  ClickPoint("scatter-chart", 0, 0);
  ASSERT_TRUE(Comes("!document.getElementById('run').hidden"));
  EXPECT_EQ(Run("return document.getElementById('run-title').textContent"),
            fmt::format("Run {}", row.get<int>()));
  EXPECT_EQ(Run("return document.querySelector('#run code').textContent"),
            fmt::format("./kestrel campaign replay landing_dispersion {}", row.get<int>()));
  EXPECT_THAT(Run("return document.getElementById('run').textContent").get<std::string>(),
              Not(HasSubstr("null")));
  EXPECT_THAT(Run("return document.querySelector('#run td.missed').textContent").get<std::string>(),
              HasSubstr(" m"));
  browser_->Click("#run .command button");
  EXPECT_TRUE(Comes("document.querySelector('#run .command button').textContent === 'Copied'"));
  browser_->Type("#run", "\uE00C");  // Escape
  EXPECT_EQ(Run("return document.getElementById('run').hidden"), true);
  // With keys alone: the first point from the left, the next, its run.
  browser_->Type("#touchdown-chart", "\uE014\uE014\uE007");
  const Json second =
      Run("return charts['touchdown-chart'].data.datasets.flatMap(d => d.data).sort((a, b) => a.x - "
          "b.x)[1].run.row");
  EXPECT_EQ(Run("return document.getElementById('run-title').textContent"),
            fmt::format("Run {}", second.get<int>()));
}

void ReportInBrowser::SortsAndFiltersTheTable() {
  const auto first = [] { return Run("return document.querySelector('#runs-table tbody tr').dataset.row"); };
  const auto extreme = [](const char* least) {
    return Run(
        fmt::format("const at = data.metrics.indexOf('touchdown_error_m'); const has = data.runs.filter(r => "
                    "r.metrics[at] !== null);"
                    "return String(has.reduce((a, b) => ({}) ? b : a).row)",
                    least));
  };
  EXPECT_EQ(first(), "0");
  browser_->Click("[data-sort=touchdown_error_m]");
  EXPECT_EQ(first(), extreme("b.metrics[at] < a.metrics[at]"));
  browser_->Click("[data-sort=touchdown_error_m]");
  EXPECT_EQ(first(), extreme("b.metrics[at] > a.metrics[at]"));
  EXPECT_EQ(Run("return document.querySelector('[aria-sort=descending]').title"), "touchdown_error_m");

  browser_->Choose("#runs-status", "not passed");
  const int failed = Run("return data.summary.runs - data.summary.passed");
  EXPECT_EQ(Run("return sortedRuns().length"), failed);
  EXPECT_EQ(Run("return [...document.querySelectorAll('#runs-table .badge.passed')].length"), 0);
  browser_->Choose("#runs-status", "all");
  browser_->Type("#runs-filter", "wind.mean_m_s>4 touchdown_error_m<=0.05 summer");
  const Json kept =
      Run("const w = data.keys.indexOf('wind.mean_m_s'), m = data.metrics.indexOf('touchdown_error_m'); "
          "return data.runs.filter(r => "
          "Number(r.values[w]) > 4 && r.metrics[m] !== null && r.metrics[m] <= 0.05 && "
          "r.values.includes('summer_sun')).length");
  EXPECT_GT(kept, 20);
  EXPECT_EQ(Run("return sortedRuns().length"), kept);
}

void ReportInBrowser::FiltersByAClickOnHowRunsEnded() {
  EXPECT_EQ(
      Run("const b = [...document.querySelectorAll('#outcomes button')].find(b => "
          "b.textContent.startsWith('signal 11'));"
          "b.click(); return [...document.querySelectorAll('#runs-table tbody tr')].map(r => r.dataset.row)"),
      Json({"412"}));
  EXPECT_THAT(Run("return document.getElementById('runs-count').textContent").get<std::string>(),
              StartsWith("1 of 1,000 runs"));
  browser_->Click("#runs-table tbody tr .link");
  EXPECT_THAT(Run("return document.querySelector('#run pre').textContent").get<std::string>(),
              HasSubstr("</script><script>alert"));
}

void ReportInBrowser::ShowsVideosOfWorstRuns() {
  const Json video = Run("return document.querySelector('#worst-list video')?.getAttribute('src') ?? null");
  ASSERT_TRUE(video.is_string());
  EXPECT_THAT(video.get<std::string>(), StartsWith("./recordings/"));
  EXPECT_TRUE(Comes("document.querySelector('#worst-list video').videoWidth === 320"));
  // It shows a picture before it is played.
  EXPECT_TRUE(Comes("document.querySelector('#worst-list video').currentTime > 0"));
  EXPECT_TRUE(Comes("document.querySelector('#worst-list video').readyState >= 2"));
}

void ReportInBrowser::TakesForWorstWhatTheCriterionKeepsFrom() {
  Run("data.limits.fix_share = {min: 0.9}");
  browser_->Choose("#worst-metric", "fix_share");
  EXPECT_EQ(Run("return document.getElementById('worst-order').value"), "min");
  browser_->Choose("#worst-metric", "touchdown_error_m");
  EXPECT_EQ(Run("return document.getElementById('worst-order').value"), "max");
}

void ReportInBrowser::WritesQuartersAsTheyAre() {
  EXPECT_EQ(Run("const chart = new Chart(document.body.appendChild(document.createElement('canvas')), {type: "
                "'scatter', data: {datasets: "
                "[]}, options: {scales: {x: axis('', {min: 0, max: 1, ticks: {stepSize: 0.25}})}}}); "
                "return chart.scales.x.ticks.map((t) => t.label)"),
            Json({"0", "0.25", "0.5", "0.75", "1"}));
}

void ReportInBrowser::SpeaksOfTheIndicesThatItDraws() {
  const auto note = [] {
    return Run("return document.getElementById('effects-note').textContent").get<std::string>();
  };
  EXPECT_THAT(note(), HasSubstr("Sobol"));
  Run("summary.effects.forEach((each) => delete each.first_order); drawEffects()");
  EXPECT_EQ(Run("return document.querySelectorAll('#effects-charts canvas').length"), 1);
  EXPECT_THAT(note(), Not(HasSubstr("Sobol")));
}

void ReportInBrowser::DrawsEveryChartInLightAndDarkAndOnAPhone() {
  const std::string empty =
      "return Object.entries(charts).filter(([, c]) => { const blank = document.createElement('canvas'); "
      "[blank.width, blank.height] = [c.canvas.width, c.canvas.height]; "
      "return c.canvas.toDataURL() === blank.toDataURL(); }).map(([n]) => n)";
  browser_->Click("#distributions-more summary");
  EXPECT_TRUE(Comes("Object.keys(charts).length >= 12 + 2 + 1 + 1 + 2"));  // drawn once it is open
  EXPECT_EQ(Run(empty), Json::array());
  browser_->Click("input[value=ecdf]");
  EXPECT_EQ(Run("return charts['distribution-touchdown_error_m'].config.type"), "line");
  EXPECT_EQ(Run(empty), Json::array());
  browser_->Click("input[value=histogram]");
  browser_->Click("#distributions-more summary");
  Run("scrollTo(0, 0)");
  const cv::Mat light = Picture("light");
  browser_->PreferDark(true);
  const cv::Mat dark = Picture("dark");
  EXPECT_GT(cv::mean(light)[0], 200);
  EXPECT_LT(cv::mean(dark)[0], 70);
  browser_->PreferDark(false);
  browser_->Resize(390, 844);
  EXPECT_TRUE(Comes("document.documentElement.scrollWidth === 390"));  // nothing sticks out
  EXPECT_EQ(Run("return [...document.querySelectorAll('#thresholds tbody td')].filter((td) => "
                "td.getBoundingClientRect().right > 390).map((td) => td.textContent)"),
            Json::array());
  Picture("phone");
  browser_->Click("#worst-list .link");
  Picture("phone_run");
  browser_->Resize(1280, 900);
  Picture("run");
}

// A campaign that has just begun, and one whose only run crashed.
void ReportInBrowser::ShowsWhatThereIsOfAlmostNothing() {
  for (const std::size_t runs : {0u, 1u}) {
    ReportSubject subject = LandingCampaign(20, folder_ / "little");
    subject.results.resize(runs);
    for (RunResult& run : subject.results)
      run.status = RunStatus::kCrashed, run.metrics.clear(), run.execution.recording = "";
    subject.summary = Summarise(subject.identity, subject.results);
    Write(folder_ / "little.html", HtmlReport(subject, folder_));
    Open("little.html");
    EXPECT_EQ(Run("return document.querySelector('#runs-table tbody').rows.length"), runs);
    EXPECT_EQ(Run("return [...document.querySelectorAll('nav a')].map(a => a.textContent)"),
              Json({"Success", "All runs", "Files"}));
    EXPECT_THAT(Run("return document.getElementById('facts').textContent").get<std::string>(),
                HasSubstr(fmt::format("{} of 20 runs done", runs)));
  }
}

void ReportInBrowser::PrintsOnPaper() {
  const std::string pdf = browser_->Print();
  EXPECT_THAT(pdf, StartsWith("%PDF-"));
  Write(folder_ / "report.pdf", pdf);
}

void ReportInBrowser::DrawsTheConvergenceOfATuning() {
  Open("tuning.html");
  EXPECT_EQ(Run("return document.getElementById('kind').textContent"), "Kestrel tuning");
  EXPECT_EQ(
      Run("return charts['tuning-chart'].data.datasets.filter(d => !d.alone).map(d => d.label)"),
      Json({"CMA-ES", "cross-entropy", "random search", "gains it started from, where no search saw them"}));
  EXPECT_EQ(Run("return document.getElementById('tuning-verdict').textContent"),
            "The tuned gains are better.");
  EXPECT_EQ(Run("return document.querySelector('nav a').textContent"), "Tuning");
  // The median of the five repetitions after the last flight.
  const Json median =
      Run("const all = data.tuning.searches.filter(s => s.method === 'CMA-ES').map(s => "
          "s.cost.at(-1)).sort((a, b) => a - b);"
          "const d = charts['tuning-chart'].data.datasets.find(d => d.label === 'CMA-ES').data; return "
          "[d.at(-1).y, all[2], d.at(-1).x]");
  EXPECT_EQ(median[0], median[1]);
  EXPECT_EQ(median[2], 500);
  const Json held_out =
      Run("return [...document.querySelectorAll('#tuning-held-out tbody tr')].map(tr => "
          "[...tr.children].slice(0, 2).map(td => td.textContent))");
  EXPECT_EQ(held_out,
            Json::parse(R"([["CMA-ES", "0.73"], ["cross-entropy", "1.23"], ["random search", "2.63"]])"));
  Run("document.getElementById('tuning').scrollIntoView()");
  Picture("tuning");
}

// All with one browser: to start one takes longer than to look.
TEST_F(ReportInBrowser, ShowsAndAnswersWithoutComplaintAndWithoutANetwork) {
  constexpr std::pair<const char*, void (*)()> kLooks[] = {
      {"SaysHowManyPassedWithTheInterval", SaysHowManyPassedWithTheInterval},
      {"DrawsAnyParameterAgainstAnyMetric", DrawsAnyParameterAgainstAnyMetric},
      {"ShowsTheRunOfAClickedPointWithTheCommandThatFliesItAgain",
       ShowsTheRunOfAClickedPointWithTheCommandThatFliesItAgain},
      {"SortsAndFiltersTheTable", SortsAndFiltersTheTable},
      {"FiltersByAClickOnHowRunsEnded", FiltersByAClickOnHowRunsEnded},
      {"ShowsVideosOfWorstRuns", ShowsVideosOfWorstRuns},
      {"TakesForWorstWhatTheCriterionKeepsFrom", TakesForWorstWhatTheCriterionKeepsFrom},
      {"WritesQuartersAsTheyAre", WritesQuartersAsTheyAre},
      {"SpeaksOfTheIndicesThatItDraws", SpeaksOfTheIndicesThatItDraws},
      {"DrawsEveryChartInLightAndDarkAndOnAPhone", DrawsEveryChartInLightAndDarkAndOnAPhone},
      {"ShowsWhatThereIsOfAlmostNothing", ShowsWhatThereIsOfAlmostNothing},
      {"PrintsOnPaper", PrintsOnPaper},
      {"DrawsTheConvergenceOfATuning", DrawsTheConvergenceOfATuning},
  };
  for (const auto& [name, look] : kLooks) {
    SCOPED_TRACE(name);
    Open("report.html");
    look();
    EXPECT_THAT(browser_->Complaints(), IsEmpty());
    EXPECT_THAT(browser_->Requests(),
                Each(testing::AnyOf(StartsWith("file:///"), StartsWith("data:"), StartsWith("blob:"))));
  }
}

}  // namespace
}  // namespace kestrel::campaign
