// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>

// ViSP's template trackers, in a wrapper that is compiled by C++17; for the tests alone.
namespace kestrel::visp {

enum class TemplateMethod { kInverseCompositional, kSecondOrder, kNormalisedInverse };

// Rows of 8-bit grey without gaps.
struct GreyImage {
  const unsigned char* pixels;
  int cols, rows;
};

// The homography of a quadrangle of one image in others: sums of squares by the inverse compositional algorithm
// or by ESM, or zero-mean normalised correlation by the former.
class TemplateTracker {
 public:
  TemplateTracker(TemplateMethod method, const GreyImage& reference,
                  const std::array<Eigen::Vector2d, 4>& corners, int levels);
  ~TemplateTracker();
  void Restart();                                                // from the identity, as at first
  std::optional<Eigen::Matrix3d> Track(const GreyImage& image);  // from where it ended last; none: it gave up

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kestrel::visp
