// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/velocity_lag.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace kestrel::control {
namespace {

constexpr double kPhaseMargin = M_PI / 6;  // rad

constexpr double kExplained = 0.8;    // of that square, by the best answer
constexpr double kMuchWorse = 1.5;    // as many times the squares that are left
constexpr double kFloor_m_s = 0.005;  // so much is left of the best always: the candidates are a grid

}  // namespace

double MaxLag(double lambda_per_s) {
  return lambda_per_s > 0 ? (M_PI / 2 - kPhaseMargin) / lambda_per_s
                          : std::numeric_limits<double>::infinity();
}

void VelocityLagEstimator::Add(double commanded_s, const std::optional<Eigen::Vector3d>& commanded_N,
                               double t_s, const Eigen::Vector3d& flown_N) {
  if (!commanded_N) return samples_.clear();
  if (!samples_.empty() && !(t_s > samples_.back().t_s && commanded_s > samples_.back().commanded_s)) return;
  samples_.push_back({commanded_s, *commanded_N, t_s, flown_N});
  while (samples_.front().t_s < t_s - kWindow_s - search_.max_delay_s) samples_.pop_front();
}

std::optional<VelocityLagEstimator::Late> VelocityLagEstimator::Fit(int axis, int axes) const {
  const double tells_m_s = axes == 2 ? search_.moved_level : search_.moved_climb;
  if (samples_.empty() || samples_.back().t_s - samples_.front().t_s < search_.least_s + search_.max_delay_s)
    return std::nullopt;
  // Where every delay has its command, the answers begin, at what was flown.
  const auto count = static_cast<std::ptrdiff_t>(samples_.size());
  std::ptrdiff_t begin = 1;
  while (samples_[begin - 1].t_s < samples_.front().commanded_s + search_.max_delay_s) ++begin;
  const auto scored = static_cast<double>((count - begin) * axes);
  const auto squares = [&](const auto& of) {  // about the mean of each axis
    double sum = 0;
    for (int k = axis; k < axis + axes; ++k) {
      double first = 0, second = 0;
      for (std::ptrdiff_t i = begin; i < count; ++i) {
        const double value = of(i, k);
        first += value, second += value * value;
      }
      sum += second - first * first / static_cast<double>(count - begin);
    }
    return sum;
  };
  const double moved = squares([&](std::ptrdiff_t i, int k) { return samples_[i].flown_N[k]; });
  if (!(moved >= scored * tells_m_s * tells_m_s)) return std::nullopt;

  struct Answer {
    double late_s, left;
  };
  std::vector<Answer> answers;
  std::vector<Eigen::Vector3d> commanded(samples_.size()), answered(samples_.size());
  for (int d = 0; d * search_.step_s <= search_.max_delay_s + 1e-9; ++d) {
    std::ptrdiff_t in_force = 0;
    for (std::ptrdiff_t i = begin; i < count; ++i) {
      const double at_s = (samples_[i - 1].t_s + samples_[i].t_s) / 2 - d * search_.step_s;
      while (in_force + 1 < count && samples_[in_force + 1].commanded_s <= at_s) ++in_force;
      commanded[i] = samples_[in_force].commanded_N;
    }
    for (int l = 0; l * search_.step_s <= search_.max_lag_s + 1e-9; ++l) {
      answered[begin - 1] = samples_[begin - 1].flown_N;
      for (std::ptrdiff_t i = begin; i < count; ++i) {
        const double kept =
            l == 0 ? 0 : std::exp(-(samples_[i].t_s - samples_[i - 1].t_s) / (l * search_.step_s));
        answered[i] = kept * answered[i - 1] + (1 - kept) * commanded[i];
      }
      const double left =
          squares([&](std::ptrdiff_t i, int k) { return samples_[i].flown_N[k] - answered[i][k]; });
      answers.push_back({(d + l) * search_.step_s, std::max(left, scored * kFloor_m_s * kFloor_m_s)});
    }
  }
  const Answer best = *std::min_element(answers.begin(), answers.end(),
                                        [](const Answer& a, const Answer& b) { return a.left < b.left; });
  if (!(best.left <= (1 - kExplained) * moved)) return std::nullopt;
  Late late{best.late_s, best.late_s};
  for (const Answer& answer : answers)
    if (answer.left <= kMuchWorse * best.left) late.min_s = std::min(late.min_s, answer.late_s);
  late.min_s = std::max(0.0, late.min_s - search_.step_s / 2);  // between two candidates
  return late;
}

}  // namespace kestrel::control
