// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/bench_horizon_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/file/files.h"
#include "records/plot/gnuplot.h"
#include "vision/horizon/horizon_drawing.h"

namespace kestrel::bench {
namespace {

constexpr const char* kTitles[] = {"each image alone", "with \"down\" and height expected"};
constexpr const char* kLook =
    "set border 3 lc rgb '#444444'\nset tics nomirror out scale 0.6\nset grid lc rgb '#dddddd' lt 1 lw 1\n";

// Along the top of a picture of several panels: gnuplot's own keys are no wider than one of them.
std::string Legend(const std::vector<std::pair<std::string, std::string>>& titles_and_colours) {
  std::string text;
  double x = 0.055;
  for (const auto& [title, colour] : titles_and_colours) {
    text += fmt::format(
        "set label '■' at screen {:.3f}, 0.938 tc rgb '{}'\nset label {} at screen {:.3f}, 0.938 "
        "noenhanced\n",
        x, colour, records::GnuplotQuoted(title), x + 0.01);
    x += 0.026 + 0.0045 * static_cast<double>(title.size());
  }
  return text;
}

struct Axis {
  const char *label, *settings;
  bool logarithmic;
  double low, high;
  double (*of)(const JudgedStill&);
};

const Axis kAxes[] = {
    {"height (m)", "set logscale x\nset xrange [2:500]\nset xtics (2,6,20,60,200,500)\n", true, 2, 500,
     [](const JudgedStill& s) { return s.still.height_m; }},
    {"tilt (°)", "unset logscale x\nset xrange [0:60]\nset xtics 15\n", false, 0, 60,
     [](const JudgedStill& s) { return s.tilt_deg; }},
    {"ridge above the horizontal (°)", "unset logscale x\nset xrange [0:10]\nset xtics 2\n", false, 0, 10,
     [](const JudgedStill& s) { return s.ridge_deg; }},
    {"sight through the haze (km)", "set logscale x\nset xrange [2:105]\nset xtics (2,5,10,20,50,100)\n",
     true, 2, 105, [](const JudgedStill& s) { return s.landscape.parameters.haze_m / 1000; }},
};

// Median and 95th percentile over slices of an axis.
std::string Slices(const std::vector<JudgedStill>& all, Way way, const Axis& axis, const std::string& block) {
  constexpr int kSlices = 8;
  constexpr std::size_t kLeast = 10;  // answers of a slice that has percentiles
  std::vector<double> errors[kSlices];
  for (const JudgedStill& s : all) {
    if (!s.answers[way].fix()) continue;
    const double x = axis.of(s);
    const double u = axis.logarithmic ? std::log(x / axis.low) / std::log(axis.high / axis.low)
                                      : (x - axis.low) / (axis.high - axis.low);
    const int k = static_cast<int>(std::clamp(kSlices * u, 0.0, kSlices - 1.0));
    errors[k].push_back(s.answers[way].error_deg);
  }
  std::string text = block + " << END_OF_SLICES\n";
  for (int k = 0; k < kSlices; ++k) {
    auto& e = errors[k];
    if (e.size() < kLeast) continue;
    std::sort(e.begin(), e.end());
    const double u = (k + 0.5) / kSlices;
    const double x = axis.logarithmic ? axis.low * std::pow(axis.high / axis.low, u)
                                      : axis.low + u * (axis.high - axis.low);
    text += fmt::format("{:.5g} {:.5g} {:.5g}\n", x, e[e.size() / 2], e[e.size() * 95 / 100]);
  }
  return text + "END_OF_SLICES\n";
}

void DrawErrors(const std::filesystem::path& file, const std::vector<JudgedStill>& all) {
  std::string data, plots;
  for (const Way way : {kAlone, kExpecting}) {
    data += fmt::format("$stills{} << END_OF_STILLS\n", static_cast<int>(way));
    for (const JudgedStill& s : all) {
      if (!s.answers[way].fix()) continue;
      for (const Axis& axis : kAxes) data += fmt::format("{:.5g} ", axis.of(s));
      data += fmt::format("{:.5g} {:d}\n", s.answers[way].error_deg, s.answers[way].Outlier());
    }
    data += "END_OF_STILLS\n";
    for (std::size_t a = 0; a < std::size(kAxes); ++a) {
      const std::string slices = fmt::format("$slices{}{}", static_cast<int>(way), a);
      data += Slices(all, way, kAxes[a], slices);
      plots += fmt::format("{}set xlabel '{}'\n", kAxes[a].settings, kAxes[a].label);
      plots += a == 0 ? fmt::format("set ylabel {}\nset format y '%g'\n",
                                    records::GnuplotQuoted(fmt::format("error (°), {}", kTitles[way])))
                      : std::string("set ylabel ''\nset format y ''\n");
      plots += fmt::format(
          "plot $stills{0} using {1}:($6 > 0 ? NaN : $5) with points pt 7 ps 0.22 lc rgb '#9DB7CC', "
          "'' using {1}:($6 > 0 ? $5 : NaN) with points pt 7 ps 0.7 lc rgb '#D55E00', "
          "{2} using 1:3 with linespoints lw 2 pt 7 ps 0.5 lc rgb '#0072B2', "
          "'' using 1:2 with linespoints lw 2 pt 7 ps 0.5 lc rgb '#222222', "
          "1.5 with lines dt (6,4) lc rgb '#888888'\nunset label\n",
          static_cast<int>(way), a + 1, slices);
    }
  }
  records::DrawPng(
      file, 1800, 950,
      data + kLook +
          "set multiplot layout 2,4 title 'Error of \"down\" by the skyline' font ',15' margins "
          "0.055,0.985,0.075,0.90 spacing 0.02,0.12\nset logscale y\nset yrange [0.01:100]\nset ytics "
          "(0.01,0.03,0.1,0.3,1,3,10,30,100)\nunset key\n" +
          Legend({{"a still", "#9DB7CC"},
                  {"median", "#222222"},
                  {"95th percentile", "#0072B2"},
                  {"over 5°, given as a fix", "#D55E00"}}) +
          plots + "unset multiplot\n");
}

// Outcomes in the order of the stack.
struct Outcome {
  std::string title, colour;
  std::function<bool(const Answer&)> of;
};

std::vector<Outcome> Outcomes() {
  const auto within = [](double from_deg, double until_deg) {
    return [=](const Answer& a) { return a.fix() && a.error_deg >= from_deg && a.error_deg < until_deg; };
  };
  const auto says = [](const char* reason) { return [=](const Answer& a) { return a.result == reason; }; };
  std::vector<Outcome> outcomes = {{"error below 0.5°", "#0072B2", within(0, 0.5)},
                                   {"to 1.5°", "#56B4E9", within(0.5, 1.5)},
                                   {"to 5°", "#F0E442", within(1.5, 5)},
                                   {"over 5°", "#D55E00", within(5, 360)}};
  for (const auto& [reason, colour] : {std::pair{"uneven_skyline", "#BBBBBB"},
                                       {"too_little_skyline", "#999999"},
                                       {"ambiguous", "#CC79A7"},
                                       {"no_sky", "#6B8E4E"},
                                       {"no_ground", "#A6CEE3"},
                                       {"implausible", "#E69F00"}}) {
    outcomes.push_back({reason, colour, says(reason)});
  }
  outcomes.push_back({"another reason", "#444444", [=](const Answer& a) {
                        return std::none_of(outcomes.begin(), outcomes.end(),
                                            [&](const Outcome& o) { return o.of(a); });
                      }});
  return outcomes;
}

void DrawOutcomes(const std::filesystem::path& file, const std::vector<JudgedStill>& all) {
  const std::vector<Outcome> outcomes = Outcomes();
  const std::vector<Factor> factors = Factors();
  std::string data, plots;
  for (const Way way : {kAlone, kExpecting}) {
    for (std::size_t f = 0; f < factors.size(); ++f) {
      const Factor& factor = factors[f];
      const std::string block = fmt::format("$outcomes{}{}", static_cast<int>(way), f);
      data += block + " << END_OF_OUTCOMES\n";
      for (std::size_t r = 0; r < factor.ranges.size(); ++r) {
        std::vector<int> counts(outcomes.size());
        int stills = 0;
        for (const JudgedStill& s : all) {
          if (factor.of(s) != static_cast<int>(r)) continue;
          ++stills;
          for (std::size_t o = 0; o < outcomes.size(); ++o) counts[o] += outcomes[o].of(s.answers[way]);
        }
        data += '"' + factor.ranges[r] + '"';
        for (const int n : counts) data += fmt::format(" {:.3f}", 100.0 * n / std::max(stills, 1));
        data += '\n';
      }
      data += "END_OF_OUTCOMES\n";
      plots += fmt::format("set title {} offset 0,-0.6\n", records::GnuplotQuoted(factor.name));
      plots += f == 0 ? fmt::format("set ylabel {}\nset format y '%g'\n",
                                    records::GnuplotQuoted(fmt::format("stills (%), {}", kTitles[way])))
                      : std::string("set ylabel ''\nset format y ''\n");
      plots += "plot ";
      for (std::size_t o = 0; o < outcomes.size(); ++o)
        plots += fmt::format("{}{} using {}:xtic(1) lc rgb '{}'", o ? ", " : "", o ? "''" : block, o + 2,
                             outcomes[o].colour);
      plots += "\nunset label\n";
    }
  }
  std::vector<std::pair<std::string, std::string>> legend;
  for (const Outcome& o : outcomes) legend.push_back({o.title, o.colour});
  records::DrawPng(
      file, 1800, 950,
      data + kLook +
          "set multiplot layout 2,6 title 'What became of the stills' font ',15' margins "
          "0.055,0.985,0.13,0.86 spacing 0.02,0.22\nset style data histograms\nset style histogram "
          "rowstacked\nset style fill solid noborder\nset boxwidth 0.85\nset yrange [0:100]\nset xtics "
          "rotate by 40 right noenhanced\nunset key\n" +
          Legend(legend) + plots + "unset multiplot\n");
}

void DrawNormalisedErrors(const std::filesystem::path& file, const std::vector<JudgedStill>& all) {
  constexpr double kMost = 5;
  constexpr int kBins = 50;
  std::string data, plots;
  for (const Way way : {kAlone, kExpecting}) {
    std::vector<int> counts(kBins);
    int n = 0;
    for (const JudgedStill& s : all) {
      const Answer& a = s.answers[way];
      if (!a.fix()) continue;
      for (const double u : {a.roll_error_deg / a.roll_sigma_deg, a.pitch_error_deg / a.pitch_sigma_deg}) {
        const double at = kBins * (u + kMost) / (2 * kMost);
        ++counts[static_cast<std::size_t>(std::clamp(at, 0.0, kBins - 1.0))];
        ++n;
      }
    }
    data += fmt::format("$deviations{} << END_OF_DEVIATIONS\n", static_cast<int>(way));
    for (int k = 0; k < kBins; ++k)
      data += fmt::format("{:.4g} {:.5g}\n", -kMost + 2 * kMost * (k + 0.5) / kBins,
                          counts[static_cast<std::size_t>(k)] * kBins / (2 * kMost * std::max(n, 1)));
    data += "END_OF_DEVIATIONS\n";
    plots += fmt::format(
        "set title {}\nplot $deviations{} using 1:2 with boxes fs solid 0.6 noborder lc rgb '#0072B2' title "
        "'roll and pitch', exp(-x*x/2)/sqrt(2*pi) with lines lw 2 lc rgb '#D55E00' title 'normal'\n",
        records::GnuplotQuoted(kTitles[way]), static_cast<int>(way));
  }
  records::DrawPng(
      file, 1200, 500,
      data + kLook +
          "set multiplot layout 1,2 margins 0.06,0.98,0.13,0.90 spacing 0.06\nset samples 400\nset xrange "
          "[-5:5]\nset yrange [0:*]\nset xlabel 'error in stated deviations (the ends hold what lies "
          "beyond)'\n" +
          plots + "unset multiplot\n");
}

}  // namespace

void DrawHorizonBench(const std::filesystem::path& folder, const std::vector<JudgedStill>& all) {
  DrawErrors(folder / "errors.png", all);
  DrawOutcomes(folder / "outcomes.png", all);
  DrawNormalisedErrors(folder / "normalised_errors.png", all);
}

cv::Mat DrawStill(const cv::Mat& image, const vision::CameraModel& camera, const Pose& X_BC,
                  const JudgedStill& still, std::size_t index, Way way, const vision::SkylineResult& result) {
  cv::Mat drawn = vision::DrawHorizon(image, camera, X_BC.R.toRotationMatrix(), result, {});
  const sim::HorizonTruth truth = sim::HorizonOf(still.X_NB * X_BC);
  vision::DrawSmallCircle(drawn, camera, -truth.up_C, -truth.dip_rad, {255, 255, 255});
  const Answer& a = still.answers[way];
  const std::string lines[] = {fmt::format("still {}, {}: {}", index, kWays[way],
                                           a.fix() ? fmt::format("{:.2f} deg off", a.error_deg) : a.result),
                               fmt::format("{}, sight {:.1f} km, {:.0f} m, tilt {:.0f}, ridge {:.1f}",
                                           still.landscape.world, still.landscape.parameters.haze_m / 1000,
                                           still.still.height_m, still.tilt_deg, still.ridge_deg)};
  int y = 18;
  for (const std::string& line : lines) {
    for (const auto& [colour, thickness] :
         {std::pair{cv::Scalar(0, 0, 0), 4}, {cv::Scalar(255, 255, 255), 1}})
      cv::putText(drawn, line, {150, y}, cv::FONT_HERSHEY_SIMPLEX, 0.5, colour, thickness, cv::LINE_AA);
    y += 20;
  }
  return drawn;
}

void WriteSheet(const std::filesystem::path& file, const std::vector<cv::Mat>& pictures) {
  if (pictures.empty()) return;
  constexpr int kColumns = 3;
  const int w = pictures[0].cols, h = pictures[0].rows;
  const int rows = (static_cast<int>(pictures.size()) + kColumns - 1) / kColumns;
  cv::Mat sheet = cv::Mat::zeros(rows * h, kColumns * w, CV_8UC3);
  for (int i = 0; i < static_cast<int>(pictures.size()); ++i)
    pictures[static_cast<std::size_t>(i)].copyTo(sheet(cv::Rect(i % kColumns * w, i / kColumns * h, w, h)));
  std::vector<uchar> bytes;
  cv::imencode(".jpg", sheet, bytes, {cv::IMWRITE_JPEG_QUALITY, 88});
  WriteFile(file, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace kestrel::bench
