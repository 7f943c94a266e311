// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "vision/landmark/even_light.h"
#include "vision/landmark/look_alike.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

constexpr double kFiner = 1.2;
constexpr int kLevelsOfRegistration = 2;
// Than the image, where the light is evened out: the fine details of a print are blurred from near.
constexpr std::array kCoarser = {1, 2, 4};
constexpr double kMinVisibleArea_px2 = 300;
// Square root of the area of the pad's visible part: below it the pad is drawn as a whole in the image's resolution,
// above it in one by which it is at least half as large.
constexpr double kWholeSide_px = 120;
// Correlation of a patch with the reference from which on the point counts.
constexpr double kMinPatchCorrelation = 0.7;
// Of 880 places at which tests and landings found a pad in even light the least alike had 0.64.
constexpr double kMinCoarseLikeness = 0.4;
constexpr double kImageInset_px = 3;  // of corners from the image's border
// Of corners from the pad's rim. A nearer one's window shows the ground, whose grey nobody knows, and the corners of a
// frame around the pad have the longest lever on its lean.
constexpr double kPadInset_px = 5;
// Of fewer corners than are asked for, where they go on from the last image.
constexpr double kFewThreshold_px = 0.5;
constexpr double kEvenedOfPad_m = 0.3;   // over which light is evened out: some of the pad's details
constexpr double kGreyOfDeviation = 40;  // of an evenly lit picture
const cv::TermCriteria kRegistrationEnd(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);

cv::Point2f ToPoint(const Eigen::Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}
Eigen::Vector2d ToVector(const cv::Point2f& p) { return {p.x, p.y}; }

// Pixels per metre of the plane, from the area of a polygon in the image and of its preimage on the pad.
double ScaleOf(const std::vector<cv::Point2f>& visible, const Eigen::Matrix3d& H_w) {
  const Eigen::Matrix3d H_inverse = H_w.inverse();
  std::vector<cv::Point2f> on_pad;
  for (const cv::Point2f& p : visible) on_pad.push_back(ToPoint(Transfer(H_inverse, ToVector(p))));
  return std::sqrt(cv::contourArea(visible) / std::max(cv::contourArea(on_pad), 1e-9));
}

// Of two square patches.
GreySums SumsOf(const cv::Mat& a, const cv::Point2f& at_a, const cv::Mat& b, const cv::Point2f& at_b) {
  constexpr int kSide = 11;
  cv::Mat patch_a, patch_b;
  cv::getRectSubPix(a, {kSide, kSide}, at_a, patch_a);
  cv::getRectSubPix(b, {kSide, kSide}, at_b, patch_b);
  GreySums sums;
  for (int y = 0; y < kSide; ++y) {
    const uchar *ra = patch_a.ptr(y), *rb = patch_b.ptr(y);
    for (int x = 0; x < kSide; ++x) {
      const double va = ra[x], vb = rb[x];
      sums += {1, va, vb, va * va, vb * vb, va * vb};
    }
  }
  return sums;
}

// The strongest corners, spread over the visible part: one for each cell of a grid. inner: half of the length and width
// within which they lie on the pad, m.
std::vector<Eigen::Vector2d> SpreadCorners(const std::vector<Eigen::Vector2d>& corners_T,
                                           const Eigen::Array2d& inner, const Eigen::Matrix3d& H_predicted,
                                           const cv::Size& image, double cell_px, int most) {
  const int columns = static_cast<int>(image.width / cell_px) + 1;
  std::vector<bool> taken(static_cast<std::size_t>(columns * (static_cast<int>(image.height / cell_px) + 1)));
  std::vector<Eigen::Vector2d> spread;
  const Eigen::Array2d most_uv(image.width - 1 - kImageInset_px, image.height - 1 - kImageInset_px);
  for (const Eigen::Vector2d& corner : corners_T) {
    if ((corner.array().abs() > inner).any()) continue;
    const Eigen::Vector2d uv = (H_predicted.leftCols<2>() * corner + H_predicted.col(2)).hnormalized();
    if (!((uv.array() > kImageInset_px).all() && (uv.array() < most_uv).all())) continue;
    const auto cell = static_cast<std::size_t>(static_cast<int>(uv.y() / cell_px) * columns +
                                               static_cast<int>(uv.x() / cell_px));
    if (taken[cell]) continue;
    taken[cell] = true;
    spread.push_back(corner);
    if (static_cast<int>(spread.size()) >= most) break;
  }
  return spread;
}

// What lies around the pad is not known: its mean grey makes the pad's own rim an honest edge.
void DrawAround(cv::Mat& drawn, const cv::Mat& seen, const cv::Mat& on_pad) {
  drawn.setTo(cv::mean(seen, ~on_pad), ~on_pad);
}

// A first guess, from the greys of the whole.
Exposure GuessExposure(const cv::Mat& drawn, const cv::Mat& seen, const cv::Mat& on_pad) {
  cv::Scalar mean_drawn, mean_seen, sigma_drawn, sigma_seen;
  cv::meanStdDev(drawn, mean_drawn, sigma_drawn, on_pad);
  cv::meanStdDev(seen, mean_seen, sigma_seen, on_pad);
  const double gain = std::clamp(sigma_seen[0] / std::max(sigma_drawn[0], 1.0), 0.2, 5.0);
  return {gain, mean_seen[0] - gain * mean_drawn[0]};
}

bool MostAgree(const Registered& r) {
  return r.seen &&
         static_cast<double>(r.agreed.size()) >= kMostlyAgree * static_cast<double>(r.tracked.size());
}

}  // namespace

std::vector<cv::Point2f> VisiblePart(const PadReference& reference, const Eigen::Matrix3d& H_w,
                                     const cv::Size& size) {
  std::vector<cv::Point2f> outline, visible;
  const double side = (H_w.row(2) * Eigen::Vector3d(0, 0, 1))(0);
  for (const Eigen::Vector2d& corner : reference.Outline()) {
    // A corner behind the camera: the pad cannot be seen as a polygon.
    if (!((H_w.row(2) * corner.homogeneous())(0) * side > 0)) return {};
    outline.push_back(ToPoint(Transfer(H_w, corner)));
  }
  const float w = static_cast<float>(size.width - 1), h = static_cast<float>(size.height - 1);
  const std::vector<cv::Point2f> image = {{0, 0}, {w, 0}, {w, h}, {0, h}};
  if (!(cv::intersectConvexConvex(outline, image, visible) > kMinVisibleArea_px2)) return {};
  return visible;
}

std::optional<PadRegistration::Place> PadRegistration::PlaceOf(const PadReference& reference,
                                                               const cv::Size& image,
                                                               const Eigen::Matrix3d& H_w) const {
  Place place{H_w, VisiblePart(reference, H_w, image), 0, nullptr, {}};
  if (place.visible.empty()) return std::nullopt;
  place.px_per_m = ScaleOf(place.visible, H_w);
  // Somewhat finer than the image, since it is blurred once more where it is drawn.
  place.level = &reference.NearestLevel(kFiner * place.px_per_m);
  const double cell_px = std::max(4.0, std::sqrt(cv::contourArea(place.visible) / options_.max_points));
  const Eigen::Array2d inner =
      Eigen::Array2d(reference.length_m, reference.width_m) / 2 - kPadInset_px / place.px_per_m;
  place.corners_T = SpreadCorners(place.level->corners, inner, H_w, image, cell_px, 2 * options_.max_points);
  return place;
}

std::optional<PadRegistration::Sight> PadRegistration::Look(const PadReference& reference,
                                                            const cv::Mat& grey,
                                                            const Eigen::Matrix3d& H_predicted,
                                                            int coarser) const {
  cv::Mat image = grey;
  Eigen::Matrix3d H_w = H_predicted;
  if (coarser > 1) {
    cv::resize(grey, image, grey.size() / coarser, 0, 0, cv::INTER_AREA);
    Eigen::Matrix3d coarse_from_image = Eigen::Matrix3d::Identity();
    coarse_from_image.topLeftCorner<2, 2>() /= coarser;
    coarse_from_image.topRightCorner<2, 1>().setConstant(0.5 / coarser - 0.5);
    H_w = coarse_from_image * H_predicted;
  }
  const auto place = PlaceOf(reference, image.size(), H_w);
  if (!place) return std::nullopt;
  Sight s;
  s.coarser = coarser;
  s.H_w = H_w;
  s.H_predicted = H_predicted;
  s.corners_T = place->corners_T;
  const double width_px = place->px_per_m * reference.width_m;
  s.window_px = coarser == 1 ? (width_px >= 70 ? 13 : 11) : (width_px >= 120 ? 13 : 9);
  s.evened_px =
      std::clamp(static_cast<int>(kEvenedOfPad_m * place->px_per_m), 2 * s.window_px, 8 * s.window_px) | 1;

  const int margin = 2 * s.window_px;
  cv::Rect box = cv::boundingRect(place->visible);
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect({0, 0}, image.size());
  s.seen = image(box);
  s.offset = cv::Point2f(static_cast<float>(box.x), static_cast<float>(box.y));

  std::vector<cv::Point> polygon;
  for (const cv::Point2f& p : place->visible)
    polygon.emplace_back(cvRound(p.x) - box.x, cvRound(p.y) - box.y);
  s.on_pad = cv::Mat(box.size(), CV_8UC1, cv::Scalar(0));
  cv::fillConvexPoly(s.on_pad, polygon, 255);

  // The pose of a small pad rests on this drawing alone, without patches about its corners: each pixel is the mean of
  // four samples, as a camera's is of all that falls onto it.
  const int finer = coarser == 1 && cv::contourArea(place->visible) < kWholeSide_px * kWholeSide_px ? 2 : 1;
  const PadReference::Level& level =
      finer == 1 ? *place->level : reference.NearestLevel(finer * place->px_per_m);
  Eigen::Matrix3d to_drawn = Eigen::Matrix3d::Identity();
  to_drawn.topLeftCorner<2, 2>() *= finer;
  to_drawn.topRightCorner<2, 1>() << (0.5 - box.x) * finer - 0.5, (0.5 - box.y) * finer - 0.5;
  cv::Mat map;
  cv::eigen2cv(Eigen::Matrix3d(to_drawn * H_w * level.pixel_from_T.inverse()), map);
  cv::warpPerspective(level.image, s.drawn, map, box.size() * finer, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  if (finer > 1) cv::resize(s.drawn, s.drawn, box.size(), 0, 0, cv::INTER_AREA);
  return s;
}

Registered PadRegistration::RegisterPlain(const PadReference& reference, const cv::Mat& grey,
                                          const Eigen::Matrix3d& H_predicted, int min_inliers,
                                          std::uint32_t draw) {
  const Consensus consensus{min_inliers, draw, reference.length_m * reference.width_m};
  const std::vector<cv::Point2f> visible = VisiblePart(reference, H_predicted, grey.size());
  if (visible.empty()) return {};
  const double area_px2 = cv::contourArea(visible);
  const int coarser = area_px2 > std::pow(2 * kWholeSide_px, 2) ? 4
                      : area_px2 > std::pow(kWholeSide_px, 2)   ? 2
                                                                : 1;
  const auto sight = Look(reference, grey, H_predicted, coarser);
  if (!sight || static_cast<int>(sight->corners_T.size()) < min_inliers) return {};
  Registered plain =
      coarser == 1 ? InExposure(*sight, consensus) : CoarseToFine(reference, grey, *sight, consensus);
  return MostAgree(plain) ? plain : Registered();
}

Registered PadRegistration::Register(const PadReference& reference, const cv::Mat& grey,
                                     const Eigen::Matrix3d& H_predicted, int min_inliers,
                                     std::uint32_t draw) {
  const Consensus consensus{min_inliers, draw, reference.length_m * reference.width_m};
  std::optional<Sight> sight = Look(reference, grey, H_predicted, 1);
  if (!sight || static_cast<int>(sight->corners_T.size()) < min_inliers) return {};
  Registered best = InExposure(*sight, consensus);
  if (MostAgree(best) || CoarseLikeness(grey, reference, H_predicted) < kMinCoarseLikeness) return best;
  for (const int coarser : kCoarser) {
    if (coarser > 1) sight = Look(reference, grey, H_predicted, coarser);
    if (!sight || static_cast<int>(sight->corners_T.size()) < min_inliers) break;
    Registered even = InEvenLight(*sight, consensus);
    // Of an evenly lit picture some corners agree with whatever is there.
    if (MostAgree(even)) return even;
    best.alike = std::max(best.alike, even.alike);
  }
  return best;
}

Registered PadRegistration::CoarseToFine(const PadReference& reference, const cv::Mat& grey,
                                         const Sight& sight, const Consensus& consensus) {
  const Exposure exposure = ExposureOf(sight);
  GreySums of_coarse;
  const Registered coarse = Agree(Compare(DrawnIn(exposure, sight), sight.seen, sight), sight.coarser,
                                  sight.H_predicted, consensus, of_coarse);
  if (!MostAgree(coarse)) return {};
  const auto place = PlaceOf(reference, grey.size(), coarse.seen->H_w);
  if (!place) return {};
  std::vector<Eigen::Vector2d> drawn;
  for (const Eigen::Vector2d& corner : place->corners_T) drawn.push_back(Transfer(place->H_w, corner));
  const std::vector<CornerMatch> seen =
      MatchCorners(place->level->image, place->level->pixel_from_T * place->H_w.inverse(), grey, drawn,
                   exposure, cv::mean(sight.seen, ~sight.on_pad)[0]);
  std::vector<Match> matches;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].found) matches.push_back({place->corners_T[i], drawn[i], seen[i].at, seen[i].greys});
  }
  GreySums greys;
  const Registered fine = Agree(matches, 1, place->H_w, consensus, greys);
  if (MostAgree(fine)) LearnExposure(exposure, greys);
  return fine;
}

Exposure PadRegistration::ExposureOf(const Sight& s) const {
  return exposure_ ? *exposure_ : GuessExposure(s.drawn, s.seen, s.on_pad);
}

cv::Mat PadRegistration::DrawnIn(const Exposure& exposure, const Sight& s) {
  cv::Mat drawn;
  s.drawn.convertTo(drawn, -1, exposure.gain, exposure.offset);
  DrawAround(drawn, s.seen, s.on_pad);
  return drawn;
}

Registered PadRegistration::InExposure(const Sight& s, const Consensus& consensus) {
  const Exposure exposure = ExposureOf(s);
  GreySums greys;
  const Registered registered =
      Agree(Compare(DrawnIn(exposure, s), s.seen, s), s.coarser, s.H_predicted, consensus, greys);
  if (registered.seen) LearnExposure(exposure, greys);
  return registered;
}

Registered PadRegistration::InEvenLight(const Sight& s, const Consensus& consensus) const {
  cv::Mat seen, drawn;
  EvenlyLit(s.seen, s.evened_px, s.on_pad).convertTo(seen, CV_8UC1, kGreyOfDeviation, 128);
  EvenlyLit(s.drawn, s.evened_px, s.on_pad).convertTo(drawn, CV_8UC1, kGreyOfDeviation, 128);
  DrawAround(drawn, seen, s.on_pad);
  GreySums greys;
  return Agree(Compare(drawn, seen, s), s.coarser, s.H_predicted, consensus, greys);
}

std::vector<PadRegistration::Match> PadRegistration::Compare(const cv::Mat& drawn, const cv::Mat& seen,
                                                             const Sight& sight) {
  std::vector<cv::Point2f> from, to;
  for (const Eigen::Vector2d& corner : sight.corners_T)
    from.push_back(ToPoint(Transfer(sight.H_w, corner)) - sight.offset);
  std::vector<uchar> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(drawn, seen, from, to, status, error, {sight.window_px, sight.window_px},
                           kLevelsOfRegistration, kRegistrationEnd, 0, 1e-3);
  const auto in_image = [&sight](const cv::Point2f& p) -> Eigen::Vector2d {
    const Eigen::Vector2d of_sight = ToVector(p + sight.offset);
    if (sight.coarser == 1) return of_sight;
    return (of_sight.array() + 0.5) * sight.coarser - 0.5;
  };
  std::vector<Match> matches;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (status[i])
      matches.push_back(
          {sight.corners_T[i], in_image(from[i]), in_image(to[i]), SumsOf(drawn, from[i], seen, to[i])});
  }
  return matches;
}

Registered PadRegistration::Agree(const std::vector<Match>& matches, int coarser,
                                  const Eigen::Matrix3d& H_drawn, const Consensus& consensus,
                                  GreySums& greys) const {
  Registered registered;
  registered.coarser = coarser;
  registered.H_drawn = H_drawn;
  std::vector<PointPair> pairs;    // drawn to seen pixel
  std::vector<PointPair> pairs_T;  // pad to seen pixel
  std::vector<const Match*> alike;
  for (const Match& match : matches) {
    registered.tracked.push_back(match.seen);
    // Where something hides the pad, Lucas-Kanade converges too, but not onto the same picture.
    if (!(match.greys.Correlation() > kMinPatchCorrelation)) continue;
    pairs.push_back({match.drawn, match.seen});
    pairs_T.push_back({match.corner_T, match.seen});
    alike.push_back(&match);
  }
  registered.alike = static_cast<int>(alike.size());
  const double threshold_px = options_.threshold_px * coarser;
  const auto robust = RansacHomography(
      pairs, {.threshold = threshold_px, .min_inliers = consensus.min_inliers}, consensus.draw);
  if (!robust) return registered;
  std::vector<PointPair> inliers;
  for (const int i : robust->inliers) inliers.push_back(pairs_T[i]);
  const auto H_w = FitHomography(inliers);
  if (!H_w) return registered;
  const auto start = PoseFromHomography(*H_w, camera_);
  if (!start) return registered;
  auto pose = RefinePlanePose(inliers, camera_, *start, options_.sigma_px * coarser);
  if (!pose || !(pose->rms_px < threshold_px)) return registered;
  if (static_cast<int>(inliers.size()) < options_.min_inliers &&
      !(pose->rms_px < kFewThreshold_px * coarser &&
        inliers.size() > kMostlyAgree * static_cast<double>(pairs.size())))
    return registered;
  pose->covariance += CovarianceOfShift(pose->X_CT, options_.shift_px / camera_.fx);

  PadObservation of_pad;
  of_pad.X_CT = pose->X_CT;
  of_pad.covariance = pose->covariance;
  of_pad.H_w = HomographyFromPose(pose->X_CT, camera_);
  of_pad.inliers = static_cast<int>(inliers.size());
  of_pad.residual_px = pose->rms_px;
  of_pad.registered = true;
  std::vector<cv::Point2f> spread, hull;
  for (const PointPair& pair : inliers) {
    spread.push_back(ToPoint(pair.from));
    registered.agreed.push_back(pair.to);
  }
  cv::convexHull(spread, hull);
  of_pad.visible = cv::contourArea(hull) / consensus.pad_area_m2;
  registered.seen = of_pad;
  for (const int i : robust->inliers) greys += alike[static_cast<std::size_t>(i)]->greys;
  return registered;
}

// The exposure of this image, for the next one: regression of grey on grey over the patches that agreed.
void PadRegistration::LearnExposure(const Exposure& drawn_in, const GreySums& g) {
  const double slope = (g.xy - g.x * g.y / g.n) / std::max(g.xx - g.x * g.x / g.n, 1e-9);
  // drawn = gain * reference + offset and seen = slope * drawn + shift: the two affine maps one after the other
  if (slope > 0.5 && slope < 2)
    exposure_ = Exposure{std::clamp(slope * drawn_in.gain, 0.1, 10.0),
                         slope * drawn_in.offset + (g.y - slope * g.x) / g.n};
}

}  // namespace kestrel::vision
