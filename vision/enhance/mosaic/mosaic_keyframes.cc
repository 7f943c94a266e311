// SPDX-License-Identifier: Apache-2.0
// How images are registered to the keyframes of a mosaic, and those to each other.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
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

}  // namespace

std::optional<Mosaic::Found> Mosaic::Follow(RegisteredImage& image, const MaybePlaced& M_WC_pose) {
  RegisteredImage& keyframe = keyframes_[static_cast<std::size_t>(current_)];
  const MaybePlaced& M_WK_pose = M_WK_pose_[static_cast<std::size_t>(current_)];
  std::vector<Matrix3d> guesses = {M_KC_last_ * M_KC_before_.inverse() * M_KC_last_};  // it goes on so
  if (M_WC_pose && M_WK_pose) guesses.push_back(M_WK_pose->inverse() * *M_WC_pose);
  guesses.push_back(M_KC_last_);
  for (const Matrix3d& guess : guesses)
    if (auto motion = RegisterNear(options_.model, camera_, keyframe, image, guess, {}))
      return Found{current_, std::move(*motion)};
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
  for (const int k : candidates)
    if (auto motion =
            RegisterFar(options_.model, camera_, keyframes_[static_cast<std::size_t>(k)], image, {})) {
      if (k != current_) keyframes_[static_cast<std::size_t>(current_)].ForgetPyramid();
      return Found{k, std::move(*motion)};
    }
  return std::nullopt;
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
  M_KC_last_ = Matrix3d::Identity();
  current_ = k;
  if (options_.loops) JoinLoops(found ? found->keyframe : -1, step);
  Keep({step.number, image.clone(), projection_->PartOf(M_WC)});
  KeepWhatAloneShows();
}

// The newest keyframe with all that show the same.
void Mosaic::JoinLoops(int joined_already, MosaicStep& step) {
  constexpr double kLeastShared = 0.2;
  constexpr int kMostJoined = 4, kApart = 2, kLoop = 4;
  const int k = keyframes() - 1;
  const Matrix3d M_WC = M_WK_.back();
  std::vector<std::pair<double, int>> candidates;
  for (int j = 0; j < k; ++j) {
    if (j == joined_already) continue;
    const double shared = SharedWith(camera_, M_WK_[static_cast<std::size_t>(j)].inverse() * M_WC);
    if (shared >= kLeastShared) candidates.emplace_back(-shared, j);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<int> joined;
  bool looked_far = false;
  for (const auto& [less_shared, j] : candidates) {
    if (static_cast<int>(joined.size()) >= kMostJoined) break;
    if (std::any_of(joined.begin(), joined.end(),
                    [j = j](int other) { return std::abs(other - j) < kApart; }))
      continue;
    RegisteredImage& older = keyframes_[static_cast<std::size_t>(j)];
    const Matrix3d guess = M_WK_[static_cast<std::size_t>(j)].inverse() * M_WC;
    auto motion = RegisterNear(options_.model, camera_, older, keyframes_.back(), guess, {});
    if (!motion && !looked_far) {
      looked_far = true;
      motion = RegisterFar(options_.model, camera_, older, keyframes_.back(), {});
    }
    older.ForgetPyramid();
    if (!motion) continue;
    joined.push_back(j);
    edges_.push_back({j, k, Thinned(motion->pairs)});
    if (k - j < kLoop) continue;
    ++loops_, ++step.loops;
    // How far apart the ends were.
    constexpr double kOpen_px = 1;
    const Vector2d middle((WidthPx(camera_) - 1) / 2.0, (HeightPx(camera_) - 1) / 2.0);
    const auto ray = Ray(camera_, middle);
    const auto guessed = ray ? Project(camera_, guess * *ray) : std::nullopt,
               is = ray ? Project(camera_, motion->M_AB * *ray) : std::nullopt;
    if (guessed && is && (*guessed - *is).norm() > kOpen_px) loop_is_open_ = true;
  }
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
  if (static_cast<double>(keyframes()) >= kMore * static_cast<double>(drawn_anew_)) Redraw();
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

void Mosaic::Keep(KeptImage kept) { kept_.push_back(std::move(kept)); }

// Of the images since the last keyframe those that show what no keyframe does, the most of it first.
void Mosaic::KeepWhatAloneShows() {
  constexpr double kWorthKeeping = 0.01;
  while (!pending_.empty() && HasRoom()) {
    std::size_t best = 0;
    double most = kWorthKeeping;
    bool any = false;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      const double share = UncoveredShare(*M_WC(pending_[i].number));
      if (share <= most) continue;
      most = share, best = i, any = true;
    }
    if (!any) break;
    Keep(std::move(pending_[best]));
    pending_.erase(pending_.begin() + static_cast<std::ptrdiff_t>(best));
  }
  pending_.clear();
}

// Of an image at this place, by the images that are kept.
double Mosaic::UncoveredShare(const Matrix3d& M_WC) const {
  constexpr int kAcross = 16, kDown = 12;
  const cv::Size size = projection_->image_size();
  const cv::Rect part = projection_->PartOf(M_WC);
  std::vector<Matrix3d> M_CW;
  for (const KeptImage& each : kept_) {
    bool near = false;
    for (const cv::Rect& moved : WrappedParts(each.part, projection_->period_px()))
      for (const cv::Rect& its : WrappedParts(part, projection_->period_px())) near |= !(moved & its).empty();
    if (near) M_CW.push_back(this->M_WC(each.number)->inverse());
  }
  int all = 0, uncovered = 0;
  for (int i = 0; i <= kDown; ++i)
    for (int j = 0; j <= kAcross; ++j) {
      const auto ray = Ray(camera_, {(size.width - 1.0) * j / kAcross, (size.height - 1.0) * i / kDown});
      if (!ray) continue;
      ++all;
      const Eigen::Vector3d w = M_WC * *ray;
      uncovered += std::none_of(M_CW.begin(), M_CW.end(), [&](const Matrix3d& M) {
        const auto uv = Project(camera_, M * w);
        return uv && InImage(size, *uv);
      });
    }
  return all > 0 ? static_cast<double>(uncovered) / all : 0;
}

void Mosaic::Redraw() {
  canvas_->Clear();
  for (KeptImage& each : kept_) {
    const Matrix3d M = *M_WC(each.number);
    each.part = projection_->PartOf(M);
    DrawImage(*projection_, each.image, M, *canvas_, options_.blending);
  }
  moved_px_ = 0;
  drawn_anew_ = keyframes_.size();
}

}  // namespace kestrel::vision
