// SPDX-License-Identifier: Apache-2.0
#include "app/reproduce/image_drawings.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "geometry/tait_bryan.h"
#include "records/plot/gnuplot.h"
#include "vision/camera/views.h"
#include "vision/horizon/baseline/skyline_baseline.h"
#include "vision/write_image.h"

namespace kestrel::app {
namespace {

constexpr double kPx_per_deg = 2;  // of the appearance images, as in the flights
constexpr int kSphere_px = 480;
constexpr double kPerspective_deg = 90;  // field of the perspective view

cv::Mat Coloured(const cv::Mat& grey) {
  cv::Mat bgr;
  cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

struct Seen {
  cv::Mat image;
  vision::BaselineAttitude attitude;
};

// Of the image in the middle, or the next in which the method finds something.
Seen SeeHorizon(const std::vector<cv::Mat>& images, const vision::CameraModel& camera, const Pose& X_BC) {
  const vision::SkylineBaseline baseline(camera, X_BC.R.toRotationMatrix());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const cv::Mat& image = images[(images.size() / 2 + i) % images.size()];
    if (const auto attitude = baseline.Measure(image)) return {image, *attitude};
  }
  throw std::runtime_error("the thesis's method finds no horizon in any image");
}

cv::Mat WithEllipse(const Seen& seen) {
  cv::Mat drawn = seen.image.clone();
  cv::ellipse(drawn, seen.attitude.ellipse, {255, 0, 0}, 2, cv::LINE_AA);
  return drawn;
}

struct Turned {
  cv::Mat first, second;  // appearance images
};

Turned MostTurned(const std::vector<cv::Mat>& images, const vision::CameraModel& camera, const Pose& X_BC) {
  const vision::CompassBaseline compass(camera,
                                        vision::GroundRing(camera, X_BC.R.toRotationMatrix(), kPx_per_deg));
  Turned most;
  int farthest = -1;
  for (std::size_t i = 0; i + 1 < images.size(); ++i) {
    const cv::Mat a = compass.Unwrap(images[i]), b = compass.Unwrap(images[i + 1]);
    const int shift = std::abs(vision::CompassBaseline::BestShift(a, b));
    if (shift > farthest) farthest = shift, most = {a, b};
  }
  if (farthest < 0) throw std::runtime_error("there are no two images in a row");
  return most;
}

// One above the other, with a grid, and where a column of the first is found in the second.
cv::Mat DrawTurned(const Turned& turned) {
  const int shift = vision::CompassBaseline::BestShift(turned.first, turned.second);
  std::vector<cv::Mat> rows;
  constexpr int kScale = 3, kGrid = 20;
  for (const cv::Mat& each : {turned.first, turned.second}) {
    cv::Mat large;
    cv::resize(each, large, {}, kScale, kScale, cv::INTER_NEAREST);
    for (int x = 0; x < each.cols; x += kGrid)
      cv::line(large, {x * kScale, 0}, {x * kScale, large.rows}, {255, 255, 255}, 1);
    for (int y = 0; y < each.rows; y += kGrid)
      cv::line(large, {0, y * kScale}, {large.cols, y * kScale}, {255, 255, 255}, 1);
    const int column = each.cols / 2 + (rows.empty() ? 0 : shift);
    cv::rectangle(large, cv::Rect((column - kGrid / 2) * kScale, 0, kGrid * kScale, large.rows), {0, 0, 255},
                  2);
    if (!rows.empty()) rows.emplace_back(8, large.cols, CV_8UC3, cv::Scalar::all(255));
    rows.push_back(large);
  }
  cv::Mat sheet;
  cv::vconcat(rows, sheet);
  return sheet;
}

void PlotDistance(const Turned& turned, const std::filesystem::path& png) {
  std::string script = "$distance << END\n";
  const int reach = turned.first.cols / 4;
  for (int shift = -reach; shift <= reach; ++shift)
    script += fmt::format("{} {:.6g}\n", shift,
                          vision::CompassBaseline::Distance(turned.first, turned.second, shift));
  records::DrawPng(
      png, 900, 450,
      script +
          "END\nset grid\nset xlabel 'shift of the second image (columns)'\nset ylabel 'distance per "
          "pixel (grey levels)'\nunset key\nplot $distance with linespoints pt 7 ps 0.4 lc rgb "
          "'#0060c0'\n");
}

// The image in the middle, the same on the unit sphere, and as a perspective camera would have it.
cv::Mat Views(const std::vector<cv::Mat>& images, const vision::CameraModel& camera) {
  if (images.empty()) throw std::runtime_error("there are no images");
  const cv::Mat& image = images[images.size() / 2];
  const auto pinhole = vision::CentralPinhole(camera, Radians(kPerspective_deg));
  if (!pinhole) throw std::runtime_error("the lens does not see its own axis");
  // From aside, so that the sphere is seen to be one.
  const vision::SpherePicture sphere{image.rows, image.rows,
                                     vision::ViewRotation(Radians(35), Radians(-20), 0)};
  std::vector<cv::Mat> views = {image};
  for (const vision::View& view : {vision::View(sphere), vision::View(vision::PerspectiveView{*pinhole})}) {
    const cv::Mat seen = vision::Look(vision::MakeViewTable(view, camera), image);
    views.emplace_back();
    cv::resize(seen, views.back(), {image.rows * seen.cols / seen.rows, image.rows}, 0, 0, cv::INTER_AREA);
  }
  cv::Mat sheet;
  cv::hconcat(views, sheet);
  return sheet;
}

}  // namespace

void DrawFromImages(const std::string& what, const std::vector<cv::Mat>& images,
                    const vision::CameraModel& camera, const Pose& X_BC, const std::filesystem::path& png) {
  if (what == "views") return vision::WriteImage(png, Views(images, camera));
  if (what == "distance") return PlotDistance(MostTurned(images, camera, X_BC), png);
  if (what == "unwrapped") return vision::WriteImage(png, DrawTurned(MostTurned(images, camera, X_BC)));
  const Seen seen = SeeHorizon(images, camera, X_BC);
  cv::Mat drawn;
  if (what == "segmentation") {
    const std::vector<cv::Mat> steps = {seen.image, Coloured(vision::SkyWeight(seen.image)),
                                        Coloured(seen.attitude.segments), Coloured(seen.attitude.ground)};
    cv::hconcat(steps, drawn);
  } else if (what == "sphere") {
    // From aside and a little above, so that the horizon is a circle across the sphere.
    const vision::SpherePicture sphere{kSphere_px, kSphere_px, vision::ViewRotation(0, Radians(-70), 0)};
    drawn = vision::Look(vision::MakeViewTable(vision::View(sphere), camera), WithEllipse(seen));
    cv::hconcat(std::vector<cv::Mat>{WithEllipse(seen), drawn}, drawn);
  } else {
    drawn = WithEllipse(seen);
  }
  vision::WriteImage(png, drawn);
}

}  // namespace kestrel::app
