// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/alignment/alignment_draws.h"
#include "flight/simulated/seeds.h"

namespace kestrel::bench {

// Something that finds kTemplateRegion of a reference image in others, from the identity.
struct NamedAligner {
  std::string name;
  std::function<std::optional<Eigen::Matrix3d>(const cv::Mat& image)> align;
};
std::vector<NamedAligner> OurAligners(const cv::Mat& reference);  // forward additive, ICIA and ESM
NamedAligner EccAligner(const cv::Mat& reference);                // OpenCV's findTransformECC

inline constexpr std::array kDisplacements_px = {1.0, 2.0, 4.0, 8.0, 12.0, 16.0};
inline constexpr double kConverged_px = 1;

struct Convergence {
  int draws = 0, converged = 0;
  double ms = 0;  // of the processor, sum
  double Share() const { return draws > 0 ? static_cast<double>(converged) / draws : 0; }
  double Mean_ms() const { return draws > 0 ? ms / draws : 0; }
};
// By nuisance, aligner, picture ("all" for all) and displacement.
using ConvergenceTable =
    std::map<std::string, std::map<std::string, std::map<std::string, std::map<double, Convergence>>>>;

// A draw for each seed, picture, displacement and nuisance, all of them for each aligner.
ConvergenceTable StudyConvergence(
    flight::SeedRange seeds,
    const std::function<std::vector<NamedAligner>(const cv::Mat& reference)>& aligners);
void PrintConvergence(const ConvergenceTable& table);

}  // namespace kestrel::bench
