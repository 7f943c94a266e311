// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/descent_rows.h"

#include <Eigen/Dense>

namespace kestrel::vision {
namespace {

template <typename Visit>
void ForEachPixel(const TemplateLevel& level, const PatchGradient& slope, const Visit& visit) {
  for (int y = 0; y < level.rows; ++y) {
    const Patch::Span span = slope.spans[static_cast<std::size_t>(y)];
    const Eigen::Index row = static_cast<Eigen::Index>(y) * level.cols;
    for (Eigen::Index i = row + span.begin; i < row + span.end; ++i) visit(i);
  }
}

}  // namespace

void FillSecondOrderRows(const TemplateLevel& level, const PatchGradient& slope, double gain,
                         Design& design) {
  const float half = 0.5F, half_by_gain = static_cast<float>(0.5 / gain);
  const auto row = [&](int k) { return design.row(kFirstWarpRow + k).data(); };
  float *r0 = row(0), *r1 = row(1), *r2 = row(2), *r3 = row(3), *r4 = row(4), *r5 = row(5), *r6 = row(6),
        *r7 = row(7);
  const float *x = level.normal.row(0).data(), *y = level.normal.row(1).data();
  ForEachPixel(level, slope, [&](Eigen::Index i) {
    const float gx = half_by_gain * slope.gradient(0, i) + half * level.gradient(0, i),
                gy = half_by_gain * slope.gradient(1, i) + half * level.gradient(1, i);
    const float outward = gx * x[i] + gy * y[i];
    r0[i] = gx, r1[i] = gy;  // the columns of ExponentialDerivative()
    r2[i] = gy * x[i] - gx * y[i], r3[i] = outward;
    r4[i] = gx * x[i] - gy * y[i], r5[i] = gx * y[i] + gy * x[i];
    r6[i] = outward * x[i], r7[i] = outward * y[i];
  });
}

void FillForwardAdditiveRows(const TemplateLevel& level, const PatchGradient& slope, double gain,
                             WarpModel warp, const WarpParameters& p, Design& design) {
  const Eigen::Matrix3d W = AdditiveWarp(warp, p);
  ForEachPixel(level, slope, [&](Eigen::Index i) {
    const Eigen::Vector2d x = level.normal.col(i).cast<double>();
    const Eigen::RowVector2d gradient =
        slope.gradient.col(i).cast<double>().transpose() * PlaceDerivative(W, x).inverse();
    design.block<8, 1>(kFirstWarpRow, i) =
        (-gradient / gain * AdditiveDerivative(warp, p, x)).transpose().cast<float>();
  });
}

}  // namespace kestrel::vision
