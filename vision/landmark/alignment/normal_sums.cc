// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/normal_sums.h"

namespace kestrel::vision {
namespace {

using Row = Eigen::Map<const Eigen::ArrayXf>;

}  // namespace

// Within a row in single precision, which the processor adds several at a time of; rows in double.
NormalSums SumNormal(const Design& design, const Patch& patch, std::span<const Patch::Span> spans,
                     const float* weights, const DesignMatrix* known_hessian) {
  NormalSums sums;
  constexpr Eigen::Index kChunk = 256;  // of a row, whose weighted form has its place on the stack
  Eigen::Array<float, kChunk, 1> weighted;
  for (std::size_t y = 0; y < spans.size(); ++y) {
    for (Eigen::Index begin = spans[y].begin; begin < spans[y].end; begin += kChunk) {
      const Eigen::Index n = std::min<Eigen::Index>(spans[y].end - begin, kChunk);
      const Eigen::Index at = static_cast<Eigen::Index>(y) * patch.cols + begin;
      const Row grey(patch.grey.data() + at, n);
      if (weights) {
        const Row w(weights + at, n);
        weighted.head(n) = w * grey;
        sums.squares += static_cast<double>((weighted.head(n) * grey).sum());
        sums.weight += static_cast<double>(w.sum());
      } else {
        sums.squares += static_cast<double>(grey.square().sum());
        sums.weight += static_cast<double>(n);
      }
      for (int i = 0; i < kDesignRows; ++i) {
        const Row d(design.row(i).data() + at, n);
        if (known_hessian) {
          sums.slope[i] += static_cast<double>((d * (weights ? Row(weighted.data(), n) : grey)).sum());
          continue;
        }
        if (weights) {
          weighted.head(n) = Row(weights + at, n) * d;
        } else {
          weighted.head(n) = d;
        }
        sums.slope[i] += static_cast<double>((weighted.head(n) * grey).sum());
        for (int j = 0; j <= i; ++j)
          sums.hessian(i, j) +=
              static_cast<double>((weighted.head(n) * Row(design.row(j).data() + at, n)).sum());
      }
    }
  }
  if (known_hessian) {
    sums.hessian = *known_hessian;
  } else {
    sums.hessian.triangularView<Eigen::StrictlyUpper>() = sums.hessian.transpose();
  }
  return sums;
}

}  // namespace kestrel::vision
