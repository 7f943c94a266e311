// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/mosaic_judgement.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>
#include <vector>

#include "base/random.h"
#include "vision/enhance/motion/ray_rotation.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPoints = 200;
constexpr int kPatch_px = 15, kLooked_px = 40;  // of a patch half; as far as it is looked for
const Vector2d kMiddle(319.5, 239.5);

struct Seen {
  int image = -1;
  Vector2d uv = Vector2d::Zero();
};

// By the image in whose middle it is, of those that are in the mosaic.
template <class Pixel>
Seen SeenBest(int images, const vision::Mosaic& mosaic, const Pixel& pixel) {
  Seen best;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < images; ++i) {
    if (!mosaic.M_WC(i)) continue;
    const auto uv = pixel(i);
    if (!uv || !vision::InImage({640, 480}, *uv) || (*uv - kMiddle).norm() >= nearest) continue;
    nearest = (*uv - kMiddle).norm();
    best = {i, *uv};
  }
  return best;
}

double Rms(const std::vector<double>& errors) {
  double squares = 0;
  for (const double e : errors) squares += e * e;
  return errors.empty() ? std::numeric_limits<double>::infinity()
                        : std::sqrt(squares / static_cast<double>(errors.size()));
}

// Where in the picture the drawing has a point: where it correlates best, and from there by its gradient. No pyramid,
// whose coarse levels take the black around a mosaic for a part of it.
std::optional<cv::Point2f> FoundIn(const cv::Mat& picture, const cv::Mat& drawing, const cv::Point2f& point) {
  const auto around = [&](int half_px) {
    return cv::Rect(cvRound(point.x) - half_px, cvRound(point.y) - half_px, 2 * half_px + 1,
                    2 * half_px + 1) &
           cv::Rect({0, 0}, drawing.size());
  };
  const cv::Rect patch = around(kPatch_px), looked = around(kPatch_px + kLooked_px);
  cv::Mat correlation;
  cv::matchTemplate(picture(looked), drawing(patch), correlation, cv::TM_CCOEFF_NORMED);
  double most = 0;
  cv::Point at;
  cv::minMaxLoc(correlation, nullptr, &most, nullptr, &at);
  if (most < 0.5) return std::nullopt;
  const cv::Point moved = looked.tl() + at - patch.tl();
  const std::vector<cv::Point2f> from = {point};
  std::vector<cv::Point2f> to = {point + cv::Point2f(moved)};
  std::vector<std::uint8_t> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(drawing, picture, from, to, status, error, {21, 21}, 0,
                           {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01},
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  if (!status[0] || cv::norm(to[0] - point - cv::Point2f(moved)) > 2) return std::nullopt;
  return to[0];
}

}  // namespace

SurveyErrors JudgeSurvey(const DrawnSurvey& survey, const vision::Mosaic& mosaic,
                         const vision::MosaicPicture& picture, bool without_poses, std::uint64_t seed,
                         cv::Mat* drawn) {
  const double px_per_m = kMosaicCamera.fx / DrawnSurvey::kHeight_m;
  RandomStream random(seed, "ground points");
  std::vector<vision::PointPair> pairs;  // from the surface to the orthographic drawing
  for (int tries = 0; static_cast<int>(pairs.size()) < kPoints && tries < 20 * kPoints; ++tries) {
    const Vector2d place(random.Uniform(-1, 1) * survey.half_north_m(),
                         random.Uniform(-1, 1) * survey.half_east_m());
    const Seen seen = SeenBest(survey.images(), mosaic, [&](int i) {
      return kMosaicCamera.Project(survey.X_NC(i).Inverse() * Vector3d(place.x(), place.y(), 0));
    });
    if (seen.image < 0) continue;
    pairs.push_back({*mosaic.PlaceOf(seen.image, seen.uv), survey.InOrthographic(place, px_per_m)});
  }
  Matrix3d ortho_from_ground;
  ortho_from_ground << 0, px_per_m, survey.half_east_m() * px_per_m, -px_per_m, 0,
      survey.half_north_m() * px_per_m, 0, 0, 1;
  const auto ground = mosaic.GroundFromSurface();
  const auto fitted = vision::FitHomography(pairs);
  SurveyErrors errors;
  errors.placed_px = errors.picture_px = std::numeric_limits<double>::infinity();
  if (without_poses ? !fitted : !ground) return errors;
  const Matrix3d H = without_poses ? *fitted : Matrix3d(ortho_from_ground * *ground);
  std::vector<double> placed;
  for (const vision::PointPair& pair : pairs)
    placed.push_back((vision::Transfer(H, pair.from) - pair.to).norm());
  errors.placed_px = Rms(placed);

  // The picture against the drawing: corners of the one are looked for in the other.
  const cv::Mat ortho = survey.Orthographic(px_per_m);
  Matrix3d surface;
  surface << picture.scale, 0, picture.origin.x(), 0, picture.scale, picture.origin.y(), 0, 0, 1;
  cv::Mat map, as_ortho, shown;
  cv::eigen2cv(Matrix3d(H * surface), map);
  cv::warpPerspective(picture.image, as_ortho, map, ortho.size(), cv::INTER_LINEAR);
  cv::warpPerspective(picture.shown, shown, map, ortho.size(), cv::INTER_NEAREST);
  // Of whole patches, also where it is off.
  cv::rectangle(shown, cv::Rect({0, 0}, shown.size()), 0, 1);
  cv::erode(shown, shown, cv::Mat(), {-1, -1}, 2 * kPatch_px);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(ortho, corners, kPoints, 0.01, 80, shown);
  std::vector<double> in_picture;
  for (const cv::Point2f& corner : corners) {
    const auto found = FoundIn(as_ortho, ortho, corner);
    errors.points += found.has_value();
    in_picture.push_back(found ? cv::norm(*found - corner) : kLooked_px);
  }
  errors.picture_px = Rms(in_picture);
  if (drawn) *drawn = as_ortho;
  return errors;
}

TurnErrors JudgeTurn(const DrawnTurn& turn, const vision::Mosaic& mosaic, std::uint64_t seed) {
  using std::numbers::pi;
  TurnErrors errors;
  errors.closure_deg = errors.direction_deg = 180;
  RandomStream random(seed, "directions");
  std::vector<vision::RayPair> pairs;
  const auto pixel_in = [&](int i, const Vector3d& w) {
    return kMosaicCamera.Project(turn.R_WC(i).transpose() * w);
  };
  for (int tries = 0; static_cast<int>(pairs.size()) < kPoints && tries < 20 * kPoints; ++tries) {
    const double azimuth = random.Uniform(-pi, pi), elevation = random.Uniform(-0.4, 0.1);
    const Vector3d w(std::sin(azimuth) * std::cos(elevation), -std::sin(elevation),
                     std::cos(azimuth) * std::cos(elevation));
    const Seen seen = SeenBest(turn.images(), mosaic, [&](int i) { return pixel_in(i, w); });
    if (seen.image < 0) continue;
    pairs.push_back({(*mosaic.M_WC(seen.image) * *kMosaicCamera.Ray(seen.uv)).normalized(), w});
  }
  const int last = turn.images() - 1;
  if (pairs.size() < 10 || !mosaic.M_WC(0) || !mosaic.M_WC(last)) return errors;
  const auto off = vision::FitRotation(pairs);
  if (!off) return errors;
  std::vector<double> angles;
  const auto angle = [](const Vector3d& a, const Vector3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
  };
  for (const vision::RayPair& pair : pairs) angles.push_back(angle(pair.to, *off * pair.from) * 180 / pi);
  errors.direction_deg = Rms(angles);
  // What is in the middle between both.
  const Vector3d w = (turn.R_WC(0).col(2) + turn.R_WC(last).col(2)).normalized();
  errors.closure_deg = angle(*mosaic.M_WC(0) * *kMosaicCamera.Ray(*pixel_in(0, w)),
                             *mosaic.M_WC(last) * *kMosaicCamera.Ray(*pixel_in(last, w))) *
                       180 / pi;
  return errors;
}

}  // namespace kestrel::bench
