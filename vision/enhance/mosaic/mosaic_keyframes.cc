// SPDX-License-Identifier: Apache-2.0
// How images are registered to the keyframes of a mosaic, and those to each other.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "vision/enhance/mosaic/mosaic.h"
#include "vision/enhance/mosaic/straighten.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// The pairs that an adjustment needs, evenly from all.
std::vector<PixelPair> Thinned(const std::vector<PixelPair>& pairs) {
  constexpr std::size_t kMost = 40;
  if (pairs.size() <= kMost) return pairs;
  std::vector<PixelPair> thinned;
  for (std::size_t i = 0; i < kMost; ++i) thinned.push_back(pairs[i * pairs.size() / kMost]);
  return thinned;
}

// Where the middle of an image is in another.
std::optional<Vector2d> MiddleIn(const CameraModel& camera, const Matrix3d& M) {
  const auto ray = Ray(camera, {(WidthPx(camera) - 1) / 2.0, (HeightPx(camera) - 1) / 2.0});
  return ray ? Project(camera, M * *ray) : std::nullopt;
}

}  // namespace

std::optional<Mosaic::Found> Mosaic::Follow(RegisteredImage& image, const MaybePlaced& M_WC_pose) {
  RegisteredImage& keyframe = keyframes_[static_cast<std::size_t>(current_)];
  // From one image to the next a pose is far truer than by itself. On ground that repeats a guess that is off by
  // half its period leads to a motion on which all agree, and which is wrong.
  std::vector<Matrix3d> guesses;
  if (M_WC_pose && M_WC_pose_last_) guesses.push_back(M_KC_last_ * M_WC_pose_last_->inverse() * *M_WC_pose);
  guesses.push_back(M_KC_last_ * M_KC_before_.inverse() * M_KC_last_);  // it goes on so
  guesses.push_back(M_KC_last_);
  for (const Matrix3d& guess : guesses) {
    auto motion = RegisterNear(options_.model, camera_, keyframe, image, guess, {});
    if (motion && AgreesWithPoses(current_, motion->M_AB, M_WC_pose))
      return Found{current_, std::move(*motion)};
  }
  return std::nullopt;
}

std::optional<Mosaic::Found> Mosaic::Find(RegisteredImage& image, const MaybePlaced& M_WC_pose) {
  // After a jump the last keyframe; after a loss others too, a few at a time, so that no image takes long.
  constexpr int kAtATime = 4;
  std::vector<int> candidates = {current_};
  const int n = keyframes();
  if (M_WC_pose) {
    std::vector<std::pair<double, int>> shares;
    for (int k = 0; k < n; ++k)
      shares.emplace_back(-SharedWith(camera_, M_WK_[static_cast<std::size_t>(k)].inverse() * *M_WC_pose), k);
    std::sort(shares.begin(), shares.end());
    for (int i = 0; i < std::min(n, kAtATime); ++i)
      if (shares[static_cast<std::size_t>(i)].first < 0)
        candidates.push_back(shares[static_cast<std::size_t>(i)].second);
  } else if (lost_ > 0) {
    for (int i = 0; i < std::min(n, kAtATime); ++i)
      candidates.push_back((n - 1 - ((lost_ - 1) * kAtATime + i) % n));
  }
  for (const int k : candidates) {
    auto motion = RegisterFar(options_.model, camera_, keyframes_[static_cast<std::size_t>(k)], image, {});
    if (!motion || !AgreesWithPoses(k, motion->M_AB, M_WC_pose)) continue;
    if (k != current_) keyframes_[static_cast<std::size_t>(current_)].ForgetPyramid();
    return Found{k, std::move(*motion)};
  }
  return std::nullopt;
}

// Whether what images say of a motion can be, by the poses of both.
bool Mosaic::AgreesWithPoses(int keyframe, const Matrix3d& M_KC, const MaybePlaced& M_WC_pose) {
  const MaybePlaced& M_WK_pose = M_WK_pose_[static_cast<std::size_t>(keyframe)];
  if (!M_WC_pose || !M_WK_pose) return true;
  constexpr double kMostSigmas = 4;
  const auto by_images = MiddleIn(camera_, M_KC),
             by_poses = MiddleIn(camera_, M_WK_pose->inverse() * *M_WC_pose);
  const bool agrees = by_images && by_poses &&
                      (*by_images - *by_poses).norm() <= kMostSigmas * std::sqrt(2.0) * PoseSigma_px();
  against_pose_ |= !agrees;
  return agrees;
}

void Mosaic::MakeKeyframe(const cv::Mat& image, RegisteredImage registered, const Matrix3d& M_WC,
                          const MaybePlaced& M_WC_pose, const Found* found, MosaicStep& step) {
  const int k = keyframes();
  if (k > 0) keyframes_[static_cast<std::size_t>(current_)].ForgetPyramid();
  keyframes_.push_back(std::move(registered));
  M_WK_.push_back(M_WC);
  M_WK_pose_.push_back(M_WC_pose);
  if (M_WC_pose) priors_.push_back({k, *M_WC_pose, PoseSigma_px()});
  placements_.push_back({step.state, k, Matrix3d::Identity()});
  step.keyframe = k;
  step.is_keyframe = true;
  ++since_adjusted_;
  if (found) edges_.push_back({found->keyframe, k, Thinned(found->motion.pairs)});
  // From now on motion is told from here.
  const bool followed = found && found->keyframe == current_;
  M_KC_before_ = followed ? Matrix3d(found->motion.M_AB.inverse() * M_KC_last_) : Matrix3d::Identity();
  M_KC_last_ = Matrix3d::Identity(), M_WC_pose_last_ = M_WC_pose;
  current_ = k;
  if (options_.loops) BeginJoins(found ? found->keyframe : -1);
  Keep({step.number, image.clone(), projection_->PartOf(M_WC)});
  KeepWhatAloneShows();
}

// The newest keyframe with all that show the same.
void Mosaic::BeginJoins(int joined_already) {
  constexpr double kLeastShared = 0.2;
  const int k = keyframes() - 1;
  const Matrix3d M_WC = M_WK_.back();
  std::vector<std::pair<double, int>> candidates;
  for (int j = 0; j < k; ++j) {
    if (j == joined_already) continue;
    const double shared = SharedWith(camera_, M_WK_[static_cast<std::size_t>(j)].inverse() * M_WC);
    if (shared >= kLeastShared) candidates.emplace_back(-shared, j);
  }
  std::sort(candidates.begin(), candidates.end(), std::greater<>());
  Joining& joining = joining_.emplace_back(k, std::vector<int>(), std::vector<int>(), false);
  for (const auto& [less_shared, j] : candidates) joining.candidates.push_back(j);
}

// The next of them that is to be tried. False: none.
bool Mosaic::JoinNext(MosaicStep& step) {
  constexpr int kMostJoined = 4, kApart = 2, kLoop = 4;
  while (!joining_.empty()) {
    Joining& joining = joining_.front();
    if (joining.candidates.empty() || static_cast<int>(joining.joined.size()) >= kMostJoined) {
      joining_.pop_front();
      continue;
    }
    const int k = joining.keyframe, j = joining.candidates.back();
    joining.candidates.pop_back();
    if (std::any_of(joining.joined.begin(), joining.joined.end(),
                    [j](int other) { return std::abs(other - j) < kApart; }))
      continue;
    RegisteredImage &older = keyframes_[static_cast<std::size_t>(j)],
                    &newer = keyframes_[static_cast<std::size_t>(k)];
    const Matrix3d guess = M_WK_[static_cast<std::size_t>(j)].inverse() * M_WK_[static_cast<std::size_t>(k)];
    auto motion = RegisterNear(options_.model, camera_, older, newer, guess, {});
    if (!motion && !joining.looked_far) {
      joining.looked_far = true;
      motion = RegisterFar(options_.model, camera_, older, newer, {});
    }
    for (const int each : {j, k})
      if (each != current_) keyframes_[static_cast<std::size_t>(each)].ForgetPyramid();
    if (!motion || !AgreesWithPoses(j, motion->M_AB, M_WK_pose_[static_cast<std::size_t>(k)])) return true;
    joining.joined.push_back(j);
    edges_.push_back({j, k, Thinned(motion->pairs)});
    if (k - j < kLoop) return true;
    ++loops_, ++step.loops;
    // How far apart the ends were.
    constexpr double kOpen_px = 1;
    const auto guessed = MiddleIn(camera_, guess), is = MiddleIn(camera_, motion->M_AB);
    if (guessed && is && (*guessed - *is).norm() > kOpen_px) loop_is_open_ = true;
    return true;
  }
  return false;
}

void Mosaic::AdjustWhenDue(MosaicStep& step) {
  if (!options_.loops) return;
  constexpr int kOften = 10, kSoon = 3, kIterations = 4;
  if (since_adjusted_ < (loop_is_open_ ? kSoon : kOften)) return;
  if (loops_ == 0 && priors_.empty()) return;  // a chain agrees with itself
  AdjustKeyframes(kIterations, &step.moved_px);
  step.adjusted = true;
  moved_px_ += step.moved_px;
  constexpr double kWorthDrawing_px = 2, kMore = 1.5;
  if (!options_.redraw || moved_px_ < std::ldexp(kWorthDrawing_px, canvas_->halvings())) return;
  // Ever more seldom, so that it takes a constant share of the time.
  if (!stale_.empty() || static_cast<double>(keyframes()) < kMore * static_cast<double>(drawn_anew_)) return;
  stale_ = canvas_->tiles();
  stale_halvings_ = canvas_->halvings();
  moved_px_ = 0;
  drawn_anew_ = keyframes_.size();
}

AdjustmentResult Mosaic::AdjustKeyframes(int most_iterations, double* moved_px) {
  const std::vector<Matrix3d> before = M_WK_;
  const AdjustmentResult result =
      AdjustMosaic(options_.model, camera_, edges_, priors_, {.most_iterations = most_iterations}, M_WK_);
  const Vector2d middle((WidthPx(camera_) - 1) / 2.0, (HeightPx(camera_) - 1) / 2.0);
  for (std::size_t k = 0; k < M_WK_.size(); ++k) {
    if (options_.model == MosaicModel::kPlane) M_WK_[k] /= M_WK_[k](2, 2);
    const auto was = projection_->ToSurface(before[k], middle), is = projection_->ToSurface(M_WK_[k], middle);
    if (!was || !is) continue;
    Vector2d moved = *is - *was;
    if (const int period = projection_->period_px()) moved.x() -= period * std::round(moved.x() / period);
    if (moved_px) *moved_px = std::max(*moved_px, moved.norm());
  }
  since_adjusted_ = 0;
  loop_is_open_ = false;
  return result;
}

AdjustmentResult Mosaic::Adjust() {
  if (keyframes_.empty()) return {};
  MosaicStep step;
  while (JoinNext(step)) {}
  AdjustmentResult result;
  constexpr int kIterations = 30;
  if (options_.loops) result = AdjustKeyframes(kIterations, nullptr);
  if (options_.model == MosaicModel::kRotation && !has_poses_)
    if (const auto R_VW = Straightening(M_WK_))
      for (Matrix3d& M : M_WK_) M = *R_VW * M;
  KeepWhatAloneShows();
  Redraw();
  return result;
}

}  // namespace kestrel::vision
