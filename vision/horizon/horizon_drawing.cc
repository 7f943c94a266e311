// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/horizon_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "geometry/tait_bryan.h"
#include "vision/drawn_colours.h"
#include "vision/horizon/band_sampler.h"

namespace kestrel::vision {

namespace {

const cv::Scalar kSkyBlue(235, 175, 90), kGroundBrown(40, 80, 120), kWhite(255, 255, 255),
    kYellow(0, 230, 255);

RollPitch AnglesOf(const Eigen::Matrix3d& R_BC, const SkylineFix& fix) {
  return RollPitchFromDown(R_BC * fix.down_C, R_BC * fix.covariance * R_BC.transpose());
}

}  // namespace

void DrawSmallCircle(cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& down_C,
                     double elevation, const cv::Scalar& colour, int thickness) {
  const Horizontal h = HorizontalAbout(down_C, down_C.unitOrthogonal());
  std::optional<Eigen::Vector2d> last;
  for (int i = 0; i <= 720; ++i) {
    const auto uv = Project(camera, h.Direction(i * M_PI / 360, elevation));
    if (uv && last && (*uv - *last).norm() < 0.2 * image.cols)
      cv::line(image, cv::Point2d(last->x(), last->y()), cv::Point2d(uv->x(), uv->y()), colour, thickness,
               cv::LINE_AA);
    last = uv;
  }
}

void DrawSkyline(cv::Mat& image, const CameraModel& camera, const SkylineFix& fix) {
  DrawSmallCircle(image, camera, fix.down_C, -fix.dip, kFixColour);
  for (const SkylineRay& p : fix.points) {
    const auto uv = Project(camera, p.ray_C);
    if (!uv) continue;
    const cv::Scalar colour = kFixColour * (0.15 + 0.85 * p.weight);
    cv::circle(image, cv::Point2d(uv->x(), uv->y()), 2, colour, cv::FILLED, cv::LINE_AA);
  }
}

void DrawArtificialHorizon(cv::Mat& image, cv::Point centre, int radius, const RollPitch& attitude,
                           const cv::Scalar& ring) {
  const cv::Rect all(0, 0, image.cols, image.rows),
      disc(centre.x - radius, centre.y - radius, 2 * radius, 2 * radius);
  if ((disc & all) != disc) return;
  cv::Mat view = image(disc);
  const double per_rad = radius / Radians(45), c = std::cos(attitude.roll), s = std::sin(attitude.roll);
  for (int y = 0; y < view.rows; ++y)
    for (int x = 0; x < view.cols; ++x) {
      const double u = x - radius, v = y - radius;
      if (u * u + v * v > static_cast<double>(radius) * radius) continue;
      // Below the line of the horizon in the picture, which stands against the roll and falls with the pitch.
      const bool ground = s * u + c * v > attitude.pitch * per_rad;
      const cv::Scalar& colour = ground ? kGroundBrown : kSkyBlue;
      for (int k = 0; k < 3; ++k) view.at<cv::Vec3b>(y, x)[k] = cv::saturate_cast<uchar>(colour[k]);
    }
  for (int deg = -40; deg <= 40; deg += 10) {
    const double away = (attitude.pitch - Radians(deg)) * per_rad, half = deg == 0 ? radius : radius / 4.0;
    const cv::Point2d middle(radius + s * away, radius + c * away), along(c * half, -s * half);
    if (cv::norm(middle - cv::Point2d(radius, radius)) + (deg == 0 ? 0 : half) > radius) continue;
    const double reach = deg == 0 ? std::sqrt(std::max(0.0, 1 - away * away / (1.0 * radius * radius))) : 1;
    cv::line(view, middle - along * reach, middle + along * reach, kWhite, 1, cv::LINE_AA);
  }
  const cv::Point mid(radius, radius);
  cv::line(view, mid - cv::Point(radius / 2, 0), mid - cv::Point(radius / 6, 0), kYellow, 2, cv::LINE_AA);
  cv::line(view, mid + cv::Point(radius / 6, 0), mid + cv::Point(radius / 2, 0), kYellow, 2, cv::LINE_AA);
  cv::circle(view, mid, radius - 1, ring, 2, cv::LINE_AA);
}

void DrawCompassStrip(cv::Mat& image, cv::Rect place, double heading) {
  if ((place & cv::Rect(0, 0, image.cols, image.rows)) != place) return;
  cv::rectangle(image, place, cv::Scalar(30, 30, 30), cv::FILLED);
  const double centre = Degrees(heading), per_deg = place.width / 120.0;
  for (int mark = static_cast<int>(std::ceil((centre - 60) / 10)) * 10; mark <= centre + 60; mark += 10) {
    const int x = place.x + static_cast<int>(std::lround((mark - centre + 60) * per_deg));
    const bool long_mark = mark % 30 == 0;
    cv::line(image, {x, place.y}, {x, place.y + (long_mark ? 8 : 4)}, kWhite, 1);
    const int shown = ((mark % 360) + 360) % 360;
    if (long_mark && x > place.x + 12 && x < place.x + place.width - 24)
      cv::putText(image, fmt::format("{}", shown), {x - 10, place.y + place.height - 4},
                  cv::FONT_HERSHEY_SIMPLEX, 0.35, kWhite, 1, cv::LINE_AA);
  }
  const int middle = place.x + place.width / 2;
  cv::line(image, {middle, place.y}, {middle, place.y + place.height}, kYellow, 1);
}

cv::Mat DrawHorizon(const cv::Mat& image, const CameraModel& camera, const Eigen::Matrix3d& R_BC,
                    const SkylineResult& skyline, const std::optional<CompassResult>& compass) {
  cv::Mat out;
  if (image.channels() == 1)
    cv::cvtColor(image, out, cv::COLOR_GRAY2BGR);
  else
    out = image.clone();
  if (const auto* fix = std::get_if<SkylineFix>(&skyline)) {
    DrawSkyline(out, camera, *fix);
    DrawArtificialHorizon(out, {kHorizonMiddle_px, kHorizonMiddle_px}, kHorizonRadius_px,
                          AnglesOf(R_BC, *fix), kFixColour);
  }
  const auto* heading = compass ? std::get_if<CompassHeading>(&*compass) : nullptr;
  if (heading) DrawCompassStrip(out, {out.cols / 2 - 110, 6, 220, 26}, heading->turned);
  return out;
}

std::vector<std::string> HorizonWords(const Eigen::Matrix3d& R_BC, const SkylineResult& skyline,
                                      const std::optional<CompassResult>& compass) {
  std::vector<std::string> words;
  if (const auto* fix = std::get_if<SkylineFix>(&skyline)) {
    const RollPitch angles = AnglesOf(R_BC, *fix);
    words.push_back(fmt::format("roll {:.2f} +- {:.2f}  pitch {:.2f} +- {:.2f} deg", Degrees(angles.roll),
                                Degrees(std::sqrt(angles.covariance(0, 0))), Degrees(angles.pitch),
                                Degrees(std::sqrt(angles.covariance(1, 1)))));
  } else {
    words.push_back(fmt::format("no attitude: {}", NameOf(std::get<NoSkyline>(skyline))));
  }
  if (!compass) return words;
  if (const auto* heading = std::get_if<CompassHeading>(&*compass))
    words.push_back(fmt::format("turned {:.2f} +- {:.2f} deg, keyframe {}, likeness {:.2f}",
                                Degrees(heading->turned), Degrees(std::sqrt(heading->variance)),
                                heading->keyframe, heading->likeness));
  else
    words.push_back(fmt::format("no heading: {}", NameOf(std::get<NoHeading>(*compass))));
  return words;
}

}  // namespace kestrel::vision
