// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/tracked.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <utility>

#include "base/yaml/yaml_fields.h"
#include "geometry/tait_bryan.h"
#include "mission/helipad_pilot.h"
#include "vision/drawn_colours.h"
#include "vision/landmark/pad_drawing.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::app {

namespace {

constexpr double kMinCornerAngle = 0.05;  // sine: at less, three of four corners lie on a line
constexpr std::array kPoseNames = {"x", "y", "z", "rx", "ry", "rz"};

cv::Mat Grey(const cv::Mat& image) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

std::string EmptyCells(int count) { return std::string(static_cast<std::size_t>(count), ','); }

void CheckQuadrangle(const Corners& c, Mistakes& mistakes) {
  int clockwise = 0, counter = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d a = c[(k + 1) % 4] - c[k], b = c[(k + 2) % 4] - c[(k + 1) % 4];
    const double turn = (a.x() * b.y() - a.y() * b.x()) / std::max(a.norm() * b.norm(), 1e-12);
    if (std::abs(turn) < kMinCornerAngle)
      return mistakes.Add("--corners", "", "three of the four lie on a line",
                          "valid: the corners of a quadrangle");
    ++(turn > 0 ? clockwise : counter);
  }
  const char* const order = "valid: top left, top right, bottom right, bottom left of the landmark's picture";
  if (clockwise > 0 && counter > 0)
    mistakes.Add("--corners", "", "their sides cross, or turn inwards", order);
  if (clockwise == 0)
    mistakes.Add("--corners", "", "they go round the wrong way, as of a picture in a mirror", order);
}

}  // namespace

std::optional<Corners> ReadCorners(const std::vector<std::string>& texts, const std::optional<cv::Size>& size,
                                   Mistakes& mistakes) {
  if (texts.empty()) return std::nullopt;
  const std::size_t before = mistakes.all().size();
  Corners corners;
  if (texts.size() != corners.size()) {
    mistakes.Add("--corners", "", fmt::format("there are {}", texts.size()), "valid: four, such as 10,20");
    return std::nullopt;
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    std::istringstream text(texts[i]);
    char comma = 0, more = 0;
    Eigen::Vector2d& c = corners[i];
    if (!(text >> c.x() >> comma >> c.y()) || comma != ',' || text >> more || !c.allFinite()) {
      mistakes.Add("--corners", "", fmt::format("'{}' is no pixel", texts[i]),
                   "valid: two numbers, such as 10,20");
    } else if (size && !(c.x() >= -0.5 && c.y() >= -0.5 && c.x() <= size->width - 0.5 &&
                         c.y() <= size->height - 0.5)) {
      mistakes.Add("--corners", "", fmt::format("{} lies outside the image", texts[i]),
                   fmt::format("valid: 0,0 to {},{}", size->width - 1, size->height - 1));
    }
  }
  if (mistakes.all().size() == before) CheckQuadrangle(corners, mistakes);
  return mistakes.all().size() == before ? std::optional(corners) : std::nullopt;
}

TrackedLandmark::TrackedLandmark(vision::PadReference reference, const vision::CameraModel& camera,
                                 const std::optional<Corners>& corners, Mistakes& mistakes)
    : camera_(camera),
      view_(mission::TrackersCamera(camera).value()),
      tracker_(std::move(reference), view_, {}) {
  if (!std::holds_alternative<vision::Pinhole>(camera))
    to_view_ = vision::MakeViewTable(vision::PerspectiveView{view_}, camera);
  if (!corners) return;
  std::vector<vision::PointPair> pairs;
  const std::vector<Eigen::Vector2d> outline = tracker_.reference().Outline();
  for (std::size_t k = 0; k < corners->size(); ++k) {
    const auto ray = vision::Ray(camera, (*corners)[k]);
    const auto at = ray ? view_.Project(*ray) : std::nullopt;
    if (at) pairs.push_back({outline[k], *at});
  }
  const auto H_w = vision::FitHomography(pairs);
  if (H_w) X_CT_begin_ = vision::PoseFromHomography(*H_w, view_);
  if (!X_CT_begin_)
    mistakes.Add("--corners", "", "no flat landmark before this camera has its corners there",
                 "valid: top left, top right, bottom right, bottom left of the landmark's picture");
}

std::string TrackedLandmark::Columns() {
  std::string columns = "state,x_m,y_m,z_m,yaw_deg,pitch_deg,roll_deg,inliers,residual_px,visible";
  for (std::size_t i = 0; i < kPoseNames.size(); ++i) {
    for (std::size_t k = i; k < kPoseNames.size(); ++k) {
      const char* const unit = k < 3 ? "m2" : i < 3 ? "m_rad" : "rad2";
      columns += fmt::format(",cov_{}_{}_{}", kPoseNames[i], kPoseNames[k], unit);
    }
  }
  return columns;
}

bool TrackedLandmark::Track(const cv::Mat& image) {
  cv::Mat grey = Grey(image);
  if (to_view_) grey = vision::Look(*to_view_, grey);
  seen_ = tracker_.Track(grey, std::exchange(X_CT_begin_, std::nullopt));
  return seen_.has_value();
}

std::string TrackedLandmark::Row() const {
  if (!seen_) return "lost" + EmptyCells(30);
  const TaitBryan angles = TaitBryanFromRotation(seen_->X_CT.R.toRotationMatrix());
  const Eigen::Vector3d& p = seen_->X_CT.p;
  std::string row = fmt::format("{},{:.5f},{:.5f},{:.5f},{:.4f},{:.4f},{:.4f},{},{:.3f},{:.3f}",
                                seen_->found ? "found" : "tracked", p.x(), p.y(), p.z(), Degrees(angles.yaw),
                                Degrees(angles.pitch), Degrees(angles.roll), seen_->inliers,
                                seen_->residual_px, seen_->visible);
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index k = i; k < 6; ++k) row += fmt::format(",{:.4e}", seen_->covariance(i, k));
  return row;
}

std::string TrackedLandmark::Sentence() const {
  if (!seen_) return "the landmark is not in the image, or shows too little of itself to be told";
  const TaitBryan angles = TaitBryanFromRotation(seen_->X_CT.R.toRotationMatrix());
  const Eigen::Vector3d &p = seen_->X_CT.p, sigma = seen_->covariance.diagonal().head<3>().cwiseSqrt();
  return fmt::format(
      "x {:+.4f} +- {:.4f} m, y {:+.4f} +- {:.4f} m, z {:.4f} +- {:.4f} m (one standard deviation), yaw "
      "{:.2f}, "
      "pitch {:.2f}, roll {:.2f} deg; {} inliers, {:.2f} px",
      p.x(), sigma.x(), p.y(), sigma.y(), p.z(), sigma.z(), Degrees(angles.yaw), Degrees(angles.pitch),
      Degrees(angles.roll), seen_->inliers, seen_->residual_px);
}

void TrackedLandmark::Draw(cv::Mat& bgr) const {
  vision::DrawPoints(bgr, camera_, view_, tracker_.tracked_points(), 2, vision::kPointColour);
  if (!seen_) return;
  vision::DrawPoints(bgr, camera_, view_, tracker_.inlier_points(), 3, vision::kFixColour);
  vision::DrawOutlineAndAxes(bgr, camera_, seen_->X_CT, tracker_.reference().Outline());
}

std::vector<mission::Caption> TrackedLandmark::Captions() const {
  if (!seen_) return {{"lost", true}};
  const Eigen::Vector3d& p = seen_->X_CT.p;
  return {{fmt::format("x {:+.3f}  y {:+.3f}  z {:.3f} m", p.x(), p.y(), p.z())},
          {fmt::format("{} inliers, {:.2f} px", seen_->inliers, seen_->residual_px)}};
}

namespace {

// Where the ball's centre is, and how well that is known. The cone's covariance is of its axis, a unit vector, and
// its half-angle; distance = radius / sin(half-angle).
struct Place {
  Eigen::Vector3d p_CT;
  Eigen::Matrix3d covariance;
};
Place PlaceOf(const vision::OutlineCone& cone, const Eigen::Matrix4d& covariance, double diameter_m) {
  const double distance = diameter_m / 2 / std::sin(cone.half_angle);
  Eigen::Matrix<double, 3, 4> J;
  J << distance * Eigen::Matrix3d::Identity(), -distance / std::tan(cone.half_angle) * cone.axis;
  return {distance * cone.axis, J * covariance * J.transpose()};
}

}  // namespace

BallParameters ReadBall(const std::vector<std::string>& words, Mistakes& mistakes) {
  std::vector<std::string> settings = words;
  bool has_hue = false, has_diameter = false;
  for (std::string& word : settings) {
    if (word.starts_with("hue=")) word.insert(3, "_deg");
    has_hue = has_hue || word.starts_with("hue_deg=");
    has_diameter = has_diameter || word.starts_with("diameter_m=");
  }
  BallParameters ball;
  Mistakes own;
  Read(ParseConfig("{}", "--ball", settings, own), ball, own);
  if (!has_hue || !has_diameter)
    mistakes.Add("--ball", "", fmt::format("no {}", has_hue ? "diameter_m" : "hue"),
                 "valid: hue=DEGREES diameter_m=METRES, such as hue=0 diameter_m=0.5 of a red one");
  if (own.empty() && ball.colour.min_value >= ball.colour.max_value)
    own.Add("--ball", "min_value", "not below max_value: no pixel can match");
  for (const Diagnostic& each : own.all()) mistakes.Add("--ball", each.key, each.what, each.remedy);
  return ball;
}

TrackedBall::TrackedBall(const BallParameters& ball, const vision::CameraModel& camera)
    : camera_(camera), diameter_m_(ball.diameter_m), tracker_(vision::ColourModel(ball.colour), camera, {}) {}

std::string TrackedBall::Columns() {
  std::string columns = "state,x_m,y_m,z_m,outline,residual_px";
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = i; k < 3; ++k) columns += fmt::format(",cov_{}_{}_m2", kPoseNames[i], kPoseNames[k]);
  return columns;
}

bool TrackedBall::Track(const cv::Mat& bgr) {
  seen_ = tracker_.Track(bgr);
  return seen_->cone.has_value();
}

std::string TrackedBall::Row() const {
  std::string row = vision::NameOf(seen_->track.state);
  if (!seen_->cone) return row + EmptyCells(11);
  const auto [p, covariance] = PlaceOf(*seen_->cone, seen_->fit->covariance, diameter_m_);
  row += fmt::format(",{:.4f},{:.4f},{:.4f},{:.3f},{:.3f}", p.x(), p.y(), p.z(), seen_->fit->outline,
                     seen_->fit->residual_px);
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index k = i; k < 3; ++k) row += fmt::format(",{:.4e}", covariance(i, k));
  return row;
}

std::string TrackedBall::Sentence() const {
  if (!seen_->cone) return fmt::format("no ball is measured: {}", vision::NameOf(seen_->track.state));
  const auto [p, covariance] = PlaceOf(*seen_->cone, seen_->fit->covariance, diameter_m_);
  const Eigen::Vector3d sigma = covariance.diagonal().cwiseSqrt();
  return fmt::format(
      "x {:+.3f} +- {:.3f} m, y {:+.3f} +- {:.3f} m, z {:.3f} +- {:.3f} m (one standard deviation); {:.0f} % "
      "of its "
      "outline",
      p.x(), sigma.x(), p.y(), sigma.y(), p.z(), sigma.z(), 100 * seen_->fit->outline);
}

void TrackedBall::Draw(cv::Mat& bgr) const {
  if (!seen_->cone) return;
  std::vector<cv::Point> outline;
  for (const Eigen::Vector2d& p : vision::DrawOutline(camera_, *seen_->cone, 90))
    outline.emplace_back(static_cast<int>(std::lround(16 * p.x())),
                         static_cast<int>(std::lround(16 * p.y())));
  cv::polylines(bgr, outline, true, vision::kFixColour, 2, cv::LINE_AA, 4);
}

std::vector<mission::Caption> TrackedBall::Captions() const {
  if (!seen_->cone) return {{vision::NameOf(seen_->track.state), true}};
  return {{Sentence()}};
}

}  // namespace kestrel::app
