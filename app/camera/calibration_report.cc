// SPDX-License-Identifier: Apache-2.0
#include "app/camera/calibration_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "base/file/files.h"
#include "geometry/tait_bryan.h"
#include "records/plot/gnuplot.h"
#include "vision/calibration/coverage.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

const char* UnitOf(const std::string& parameter) {
  return parameter.size() == 2 && (parameter[0] == 'f' || parameter[0] == 'c') ? "px" : "";
}

std::string ParameterTable(const vision::Calibration& c) {
  const std::vector<std::string> names = vision::ParameterNames(c.camera);
  const Eigen::VectorXd all = vision::Parameters(c.camera);
  std::string text;
  for (std::size_t i = 0; i < c.free.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(c.free[i])];
    const double sigma = c.sigma[static_cast<Eigen::Index>(i)];
    // As many digits as the deviation has: two of it.
    const int digits =
        std::clamp(1 - static_cast<int>(std::floor(std::log10(std::max(sigma, 1e-12)))), 0, 12);
    text += fmt::format("  {:<6}{:>16.{}f}  +- {:<12.{}f} {}\n", name, all[c.free[i]], digits, sigma, digits,
                        UnitOf(name));
  }
  return text;
}

std::string ImageTable(const vision::Calibration& c) {
  std::size_t width = 5;
  for (const vision::CalibratedView& view : c.views) width = std::max(width, view.name.size());
  std::string text = fmt::format("  {:<{}}  corners  used  rms px\n", "image", width);
  for (const vision::CalibratedView& view : c.views) {
    if (!view.left_out.empty()) {
      text += fmt::format("  {:<{}}  left out: {}\n", view.name, width, view.left_out);
      continue;
    }
    const auto used =
        std::count_if(view.corners.begin(), view.corners.end(), [](const auto& r) { return r.used; });
    text += fmt::format("  {:<{}}  {:>7}  {:>4}  {:.4f}\n", view.name, width, view.corners.size(), used,
                        view.rms_px);
  }
  return text;
}

// Each used corner a row: its place, its error, its distance from the principal point, the number of its
// view.
std::string CornerData(const vision::Calibration& c) {
  const Eigen::VectorXd all = vision::Parameters(c.camera);
  std::string text = "$corners << END\n";
  int number = 0;
  for (const vision::CalibratedView& view : c.views) {
    ++number;
    for (const vision::CornerResidual& r : view.corners) {
      if (!r.used) continue;
      text += fmt::format("{:.2f} {:.2f} {:.6g} {:.6g} {:.2f} {}\n", r.pixel.x(), r.pixel.y(), r.error_px.x(),
                          r.error_px.y(), (r.pixel - all.segment<2>(2)).norm(), number);
    }
  }
  return text + "END\n";
}

constexpr const char* kStyle =
    "set border 3 lc rgb '#444444'\nset tics nomirror out scale 0.6\nset grid lc rgb '#dddddd' lt 1 lw 1\n"
    "set key off\n";

void DrawResiduals(const fs::path& file, const vision::Calibration& c) {
  double reach = 0;
  for (const vision::CalibratedView& view : c.views) {
    for (const vision::CornerResidual& r : view.corners) {
      if (r.used) reach = std::max(reach, r.error_px.cwiseAbs().maxCoeff());
    }
  }
  reach *= 1.1;
  records::DrawPng(
      file, 1300, 620,
      CornerData(c) + kStyle +
          fmt::format("set multiplot layout 1,2 title {} noenhanced font ',14'\n"
                      "set palette defined (0 '#0072B2', 0.5 '#009E73', 1 '#D55E00')\n"
                      "set cblabel 'distance from the centre (px)'\nset colorbox\n"
                      "set size square\nset xrange [{:.3g}:{:.3g}]\nset yrange [{:.3g}:{:.3g}]\n"
                      "set xlabel 'error along u (px)'\nset ylabel 'error along v (px)'\n"
                      "set xtics rotate by -45\n"
                      "plot $corners using 3:4:5 with points pt 7 ps 0.4 lc palette\n"
                      "unset colorbox\nset size nosquare\nset xtics norotate\n"
                      "set xrange [0:*]\nset yrange [0:*]\n"
                      "set xlabel 'distance from the centre (px)'\nset ylabel 'error (px)'\n"
                      "plot $corners using 5:(sqrt($3**2+$4**2)):5 with points pt 7 ps 0.4 lc palette\n"
                      "unset multiplot",
                      records::GnuplotQuoted(
                          fmt::format("Residuals of the {} camera: {:.4f} px rms, {} corners",
                                      vision::NameOf(c.camera), c.rms_px, c.corners - c.corners_not_used)),
                      -reach, reach, -reach, reach));
}

void DrawCoverage(const fs::path& file, const vision::Calibration& c, std::span<const cv::Mat> images) {
  const vision::Coverage coverage = vision::CoverageOf(c, images);
  const double width = vision::WidthPx(c.camera), height = vision::HeightPx(c.camera);
  std::string cells;
  int object = 0;
  for (int row = 0; row < coverage.rows; ++row) {
    for (int col = 0; col < coverage.cols; ++col) {
      const std::size_t i = static_cast<std::size_t>(row * coverage.cols + col);
      const char* colour = coverage.corners[i] > 0 ? "#cfe8dc" : coverage.in_lens[i] ? "#f7d9c4" : "#eeeeee";
      cells += fmt::format(
          "set object {} rectangle from {:.2f},{:.2f} to {:.2f},{:.2f} fc rgb '{}' fs solid border rgb "
          "'white' "
          "behind\n",
          ++object, col * width / coverage.cols - 0.5, row * height / coverage.rows - 0.5,
          (col + 1) * width / coverage.cols - 0.5, (row + 1) * height / coverage.rows - 0.5, colour);
    }
  }
  records::DrawPng(
      file, 1000, static_cast<int>(1000 * height / width) + 90,
      CornerData(c) + kStyle + cells +
          fmt::format("set title {} noenhanced\nunset grid\nset size ratio -1\nset xrange [-0.5:{:.1f}]\n"
                      "set yrange [{:.1f}:-0.5]\nset xlabel 'u (px)'\nset ylabel 'v (px)'\nunset colorbox\n"
                      "set palette defined (0 '#0072B2', 0.33 '#009E73', 0.66 '#CC79A7', 1 '#D55E00')\n"
                      "plot $corners using 1:2:6 with points pt 7 ps 0.35 lc palette",
                      records::GnuplotQuoted(
                          fmt::format("Corners cover {:.0f} % of the image's cells within the lens "
                                      "(orange: none there; colours of corners: images)",
                                      100 * coverage.share)),
                      width - 0.5, height - 0.5));
}

// The board as the calibration sees it: the lines of its corners, and each corner's error.
cv::Mat Overlay(const cv::Mat& image, const vision::Calibration& c, const vision::CalibratedView& view,
                const vision::Board& board) {
  constexpr double kLonger = 100;  // errors are thousandths of a pixel
  const int scale = std::clamp(1600 / std::max(image.cols, image.rows), 1, 3);
  cv::Mat shown;
  cv::resize(image, shown, {}, scale, scale, cv::INTER_CUBIC);
  cv::cvtColor(shown, shown, cv::COLOR_GRAY2BGR);
  constexpr int kShift = 4;  // of a pixel, sixteenths
  const auto point = [&](const Vector2d& uv) {
    return cv::Point(static_cast<int>(std::lround(((uv.x() + 0.5) * scale - 0.5) * (1 << kShift))),
                     static_cast<int>(std::lround(((uv.y() + 0.5) * scale - 0.5) * (1 << kShift))));
  };
  const cv::Scalar line_colour(200, 160, 0), seen(0, 200, 0), wild(0, 0, 255), error_colour(0, 90, 255);
  const std::vector<Vector2d> places = vision::Corners(board);
  const Eigen::Vector2i grid = vision::CornerGrid(board);
  const auto line = [&](const Vector2d& from, const Vector2d& to) {
    constexpr int kPieces = 64;
    std::vector<cv::Point> run;
    const auto flush = [&] {
      if (run.size() > 1) cv::polylines(shown, run, false, line_colour, 1, cv::LINE_AA, kShift);
      run.clear();
    };
    for (int i = 0; i <= kPieces; ++i) {
      const Vector2d p = from + (to - from) * i / kPieces;
      const auto uv = vision::Project(c.camera, *view.X_CT * Eigen::Vector3d(p.x(), p.y(), 0));
      if (!uv || uv->norm() > 1e4) {
        flush();
      } else {
        run.push_back(point(*uv));
      }
    }
    flush();
  };
  const auto place = [&](int col, int row) { return places[static_cast<std::size_t>(row * grid.x() + col)]; };
  for (int row = 0; row < grid.y(); ++row) line(place(0, row), place(grid.x() - 1, row));
  for (int col = 0; col < grid.x(); ++col) line(place(col, 0), place(col, grid.y() - 1));
  for (const vision::CornerResidual& r : view.corners) {
    cv::circle(shown, point(r.pixel), (3 * scale) << (kShift - 1), r.used ? seen : wild, 1, cv::LINE_AA,
               kShift);
    if (r.used)
      cv::line(shown, point(r.pixel), point(r.pixel + kLonger * r.error_px), error_colour, 1, cv::LINE_AA,
               kShift);
  }
  const std::string text = fmt::format("{:.4f} px rms; errors {:g} x as long", view.rms_px, kLonger);
  cv::putText(shown, text, {8, shown.rows - 10}, cv::FONT_HERSHEY_SIMPLEX, 0.3 + 0.15 * scale, {0, 0, 0}, 3,
              cv::LINE_AA);
  cv::putText(shown, text, {8, shown.rows - 10}, cv::FONT_HERSHEY_SIMPLEX, 0.3 + 0.15 * scale,
              {255, 255, 255}, 1, cv::LINE_AA);
  return shown;
}

// The worst of the used views, the one in the middle, the best; their numbers.
std::vector<std::size_t> Examples(const vision::Calibration& c) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < c.views.size(); ++i) {
    if (c.views[i].left_out.empty()) used.push_back(i);
  }
  std::stable_sort(used.begin(), used.end(),
                   [&](std::size_t a, std::size_t b) { return c.views[a].rms_px > c.views[b].rms_px; });
  std::vector<std::size_t> some;
  for (const std::size_t i : {std::size_t{0}, used.size() / 2, used.size() - 1}) {
    if (std::find(some.begin(), some.end(), used[i]) == some.end()) some.push_back(used[i]);
  }
  return some;
}

}  // namespace

std::string CalibrationReport(const vision::Calibration& c, const vision::Board& board,
                              std::span<const cv::Mat> images) {
  const auto used =
      std::count_if(c.views.begin(), c.views.end(), [](const auto& view) { return view.left_out.empty(); });
  const vision::Coverage coverage = vision::CoverageOf(c, images);
  std::string text = fmt::format(
      "{} camera of {} x {} pixels, from {} of {} images of the {}\n"
      "  residual {:.4f} px rms over {} corners\n{}"
      "  corners seen to {:.1f} deg from the axis, in {:.0f} % of the image's cells within the lens\n"
      "  a known ray is seen where it is to {:.3g} px at worst (one standard deviation), a turn of the "
      "camera aside\n",
      vision::NameOf(c.camera), vision::WidthPx(c.camera), vision::HeightPx(c.camera), used, c.views.size(),
      vision::Describe(board), c.rms_px, c.corners - c.corners_not_used, ParameterTable(c),
      Degrees(c.max_angle_seen_rad), 100 * coverage.share, c.worst_uncertainty_px);
  for (const std::string& note : c.notes) text += fmt::format("  note: {}\n", note);
  return text;
}

void WriteCalibration(const fs::path& folder, const vision::Calibration& c, const vision::Board& board,
                      std::span<const cv::Mat> images) {
  WriteFile(folder / "report.txt", CalibrationReport(c, board, images) + ImageTable(c));
  DrawResiduals(folder / "residuals.png", c);
  DrawCoverage(folder / "coverage.png", c, images);
  std::set<std::string> names;
  for (const std::size_t i : Examples(c)) {
    std::string name = "overlay_" + fs::path(c.views[i].name).stem().string();
    while (!names.insert(name).second) name += "_";
    std::vector<std::uint8_t> png;
    cv::imencode(".png", Overlay(images[i], c, c.views[i], board), png);
    WriteFile(folder / (name + ".png"),
              std::string_view(reinterpret_cast<const char*>(png.data()), png.size()));
  }
  WriteFile(folder / "camchain.yaml", vision::ToKalibr(c.camera));
}

}  // namespace kestrel::app
