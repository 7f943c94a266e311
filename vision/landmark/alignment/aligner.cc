// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/aligner.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "vision/landmark/alignment/descent_rows.h"

namespace kestrel::vision {
namespace {

constexpr double kFirstDamping = 1e-4, kMinDamping = 1e-2, kMaxDamping = 10;  // of a unit diagonal
constexpr double kWorse = 1.001;  // of the cost before, from which on a step is taken back
constexpr double kSettledCoarse_px = 0.05;
constexpr double kMinGain = 0.5;  // of the contrast: of what looks otherwise the regression makes too little
constexpr double kMinDepth = 0.05;  // of a corner's denominator over that of the middle

Eigen::Matrix3d LevelFromFinest(int level) {
  const double scale = std::ldexp(1.0, -level);
  return Eigen::Vector3d(scale, scale, 1).asDiagonal();
}

// Thesis (3.4), solved for the step and the light together. None: they do not follow from the pixels.
struct Step {
  WarpParameters warp = kNoWarp;
  double gain = 1, offset = 0;
};
std::optional<Step> SolveStep(const NormalSums& sums, int parameters, bool with_light, const Light& light,
                              double damping) {
  const int first = with_light ? 0 : kFirstWarpRow, warp = kFirstWarpRow - first, n = warp + parameters;
  DesignMatrix H = DesignMatrix::Identity();
  DesignVector g = DesignVector::Zero(), unit = DesignVector::Ones();
  H.topLeftCorner(n, n) = sums.hessian.block(first, first, n, n);
  g.head(n) = sums.slope.segment(first, n);
  if (!with_light)
    g.head(n) -= light.gain * sums.hessian.block(first, kGainRow, n, 1) +
                 light.offset * sums.hessian.block(first, kOffsetRow, n, 1);
  for (int i = 0; i < n; ++i) {
    if (!(H(i, i) > 0)) return std::nullopt;
    unit[i] = 1 / std::sqrt(H(i, i));
  }
  H = (unit.asDiagonal() * H * unit.asDiagonal()).eval();
  H.diagonal().segment(warp, parameters).array() += damping;
  const Eigen::LDLT<DesignMatrix> solver(H);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-9)) return std::nullopt;
  const DesignVector q = unit.asDiagonal() * solver.solve(unit.asDiagonal() * g);
  if (!q.allFinite()) return std::nullopt;
  Step step{.gain = light.gain, .offset = light.offset};
  if (with_light) step.gain = std::max(q[kGainRow], kMinGain * light.contrast), step.offset = q[kOffsetRow];
  step.warp.head(parameters) = q.segment(warp, parameters) / step.gain;
  return step;
}

}  // namespace

std::string_view NameOf(AlignmentState state) {
  switch (state) {
    case AlignmentState::kConverged:
      return "converged";
    case AlignmentState::kDiverged:
      return "diverged";
    case AlignmentState::kLeftImage:
      return "left the image";
  }
  return "";
}

// Where it stands.
struct Aligner::Fit {
  Eigen::Matrix3d H;           // from normal coordinates to the finest level of the image
  WarpParameters p = kNoWarp;  // of the forward additive algorithm, since the stage began
  Light light;                 // as seen there, and what follows also
  double cost =
      std::numeric_limits<double>::infinity();  // deviation of the residual, in greys of the template
  double in_view = 0, agreeing = 1;
  int iterations = 0;
  bool settled = false, left = false;
};

// A level with what does not change on it.
struct Aligner::Stage {
  const TemplateLevel& level;
  const cv::Mat& image;
  int image_level;
  WarpModel warp;
  Eigen::Matrix3d H_start;
  AlignmentLoss loss;
  double settled_px;
};

Aligner::Aligner(const cv::Mat& picture, const cv::Rect& region, const AlignmentOptions& options)
    : options_(options) {
  assert(region.width >= 4 && region.height >= 4);
  assert((region & cv::Rect({0, 0}, picture.size())) == region);
  ImagePyramid pyramid;
  FillPyramid(picture, pyramid, options.levels);
  levels_ = MakeTemplateLevels(pyramid, region, options.levels, options.min_side_px);
  Eigen::Matrix3d region_from_picture = Eigen::Matrix3d::Identity();
  region_from_picture(0, 2) = -region.x, region_from_picture(1, 2) = -region.y;
  normal_from_picture_ = levels_.front().normal_from_pixel * region_from_picture;
  const double x = 1.0 * region.width / std::max(region.width, region.height),
               y = 1.0 * region.height / std::max(region.width, region.height);
  corners_ = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
  if (options.method == AlignmentMethod::kInverseCompositional) return;
  for (const TemplateLevel& level : levels_) scratch_.push_back({level.design, {}});
}

int Aligner::ImageLevel(const Fit& fit, const TemplateLevel& level) const {
  const double scale = std::sqrt(std::abs(PlaceDerivative(fit.H, {0, 0}).determinant())) *
                       normal_from_picture_(0, 0);  // px of the image's finest level to one of the template's
  return static_cast<int>(std::lround(std::log2(std::clamp(scale, 1e-3, 1e3)))) + level.level;
}

bool Aligner::Look(const Stage& stage, Fit& fit) {
  const TemplateLevel& level = stage.level;
  Sample(stage.image, LevelFromFinest(stage.image_level) * fit.H * level.normal_from_pixel, level.cols,
         level.rows, patch_);
  fit.in_view = static_cast<double>(patch_.count) / static_cast<double>(level.design.cols());
  fit.left = !(fit.in_view >= options_.min_in_view);
  if (fit.left) return false;
  const auto light_of = [&](const float* weights) {
    return options_.light ? FitLight(level, patch_, weights) : SameLight(level, patch_, weights);
  };
  double sigma_grey = 0;
  if (options_.loss == AlignmentLoss::kSquares) {
    fit.light = light_of(nullptr);
    sigma_grey = fit.light.rms_grey;
  } else {
    WeighResiduals(level, patch_, fit.light.weight > 0 ? fit.light : light_of(nullptr), stage.loss, weights_);
    fit.light = light_of(weights_.weights.data());
    sigma_grey = weights_.sigma_grey;
    fit.agreeing = fit.light.weight / patch_.count;
  }
  fit.cost = fit.light.gain > 0 ? sigma_grey / fit.light.gain : std::numeric_limits<double>::infinity();
  return true;
}

// The image about the patch that was looked at last.
NormalSums Aligner::Linearise(const Stage& stage, const Fit& fit) {
  const TemplateLevel& level = stage.level;
  const float* weights = options_.loss == AlignmentLoss::kSquares ? nullptr : weights_.weights.data();
  if (options_.method == AlignmentMethod::kInverseCompositional) {
    const bool all = !weights && patch_.count == level.design.cols();
    return SumNormal(level.design, patch_, patch_.spans, weights, all ? &level.hessian : nullptr);
  }
  Scratch& scratch = scratch_[static_cast<std::size_t>(&level - levels_.data())];
  Differentiate(patch_, level, scratch.slope);
  const double gain = std::max(fit.light.gain, kMinGain * fit.light.contrast);
  if (options_.method == AlignmentMethod::kSecondOrder) {
    FillSecondOrderRows(level, scratch.slope, gain, scratch.design);
  } else {
    FillForwardAdditiveRows(level, scratch.slope, gain, stage.warp, fit.p, scratch.design);
  }
  return SumNormal(scratch.design, patch_, scratch.slope.spans, weights, nullptr);
}

bool Aligner::Move(const Stage& stage, const WarpParameters& step, Fit& fit) const {
  const Eigen::Matrix3d H_before = fit.H;
  if (options_.method == AlignmentMethod::kForwardAdditive) {
    fit.p += step;
    fit.H = stage.H_start * AdditiveWarp(stage.warp, fit.p);
  } else {
    fit.H = H_before * ExponentialWarp(-step);  // the inverse of the step that the template would take
  }
  ++fit.iterations;
  double moved = 0;
  for (const Eigen::Vector2d& corner : corners_) {
    const Eigen::Vector3d now = fit.H * corner.homogeneous(), before = H_before * corner.homogeneous();
    if (!(now.z() / fit.H(2, 2) > kMinDepth)) return false;
    moved = std::max(moved, (now.hnormalized() - before.hnormalized()).norm());
  }
  fit.settled = std::ldexp(moved, -stage.image_level) < stage.settled_px;
  return true;
}

void Aligner::Settle(const Stage& stage, Fit& fit) {
  fit.p = kNoWarp, fit.settled = false;
  if (!Look(stage, fit)) return;
  NormalSums sums = Linearise(stage, fit);
  double damping = kFirstDamping;
  for (int iteration = 0; iteration < options_.max_iterations && !fit.settled; ++iteration) {
    const auto step = SolveStep(sums, ParameterCount(stage.warp), options_.light, fit.light, damping);
    if (!step) return;
    Fit next = fit;
    next.light.gain = step->gain, next.light.offset = step->offset;
    const bool seen = Move(stage, step->warp, next) && Look(stage, next);
    if (seen && !(next.cost > kWorse * fit.cost)) {
      fit = next;
      damping /= 10;
      if (!fit.settled) sums = Linearise(stage, fit);
      continue;
    }
    fit.iterations = next.iterations;
    // Where even a small step makes it worse, it stands at the bottom.
    fit.settled = seen && next.settled;
    damping = std::max(10 * damping, kMinDamping);
    if (damping <= kMaxDamping) continue;
    fit.settled = seen, fit.left = next.left;
    return;
  }
}

Alignment Aligner::Align(const ImagePyramid& image, const Eigen::Matrix3d& W_start) {
  Fit fit;
  fit.H = W_start * normal_from_picture_.inverse();
  double mean_grey = 0;
  const int coarsest = static_cast<int>(levels_.size()) - 1;
  for (int k = coarsest; k >= 0 && !fit.left; --k) {
    const TemplateLevel& level = levels_[static_cast<std::size_t>(k)];
    const int image_level = ImageLevel(fit, level);
    if (image_level < 0 && k < coarsest) break;  // finer than the image
    mean_grey = level.mean_grey;
    const int top = static_cast<int>(image.levels.size()) - 1, at = std::clamp(image_level, 0, top);
    const bool rough = k == coarsest && coarsest > 0, last = k == 0 || image_level <= 0;
    const WarpModel warp = rough ? std::min(options_.warp, WarpModel::kAffine) : options_.warp;
    // Tukey's loss has many minima: Huber's, which has but one, leads to the right one.
    const bool gentle = options_.loss == AlignmentLoss::kTukey && !last;
    Settle({level, image.levels[static_cast<std::size_t>(at)], at, warp, fit.H,
            gentle ? AlignmentLoss::kHuber : options_.loss, last ? options_.settled_px : kSettledCoarse_px},
           fit);
  }
  Alignment found;
  found.W = fit.H * normal_from_picture_;
  found.W /= found.W(2, 2);
  found.correlation = fit.light.correlation;
  found.rms_grey = fit.light.rms_grey;
  found.in_view = fit.in_view, found.agreeing = fit.agreeing;
  found.gain = fit.light.gain, found.offset = fit.light.offset - fit.light.gain * mean_grey;
  found.iterations = fit.iterations;
  found.state = fit.left                                                       ? AlignmentState::kLeftImage
                : fit.settled && found.correlation >= options_.min_correlation ? AlignmentState::kConverged
                                                                               : AlignmentState::kDiverged;
  return found;
}

}  // namespace kestrel::vision
