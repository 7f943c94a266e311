// SPDX-License-Identifier: Apache-2.0
#include "control/margin/loop_margins.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel::control {
namespace {

using Complex = std::complex<double>;

constexpr int kScanned = 4000;
constexpr int kHalvings = 40;

// Where a function of the frequency changes its sign between two of them.
double Root(const std::function<double(double)>& f, double low, double high) {
  const bool rising = f(low) < 0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(low * high);
    ((f(middle) < 0) == rising ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace

Complex VelocityStep::At(double w) const {
  Complex sum = 0;
  for (std::size_t i = 1; i < answer.size(); ++i)
    sum += (answer[i] - answer[i - 1]) * std::polar(1.0, -w * dt_s * (static_cast<double>(i) - 0.5));
  return sum;
}

double VelocityStep::Late_s() const {
  double sum = 0;
  for (std::size_t i = 1; i < answer.size(); ++i)
    sum += (answer[i] - answer[i - 1]) * dt_s * (static_cast<double>(i) - 0.5);
  return answer.empty() || answer.back() == 0 ? 0 : sum / answer.back();
}

Complex OpenLoop(const VelocityStep& answer, const ServoLoop& loop, double w) {
  const Complex s(0, w);
  const Complex to_come = (1.0 - std::exp(-s * loop.reckoned_s)) / s;
  const Complex hold = loop.hold_s > 0 ? (1.0 - std::exp(-s * loop.hold_s)) / (s * loop.hold_s) : 1.0;
  return loop.lambda_per_s / (1.0 + loop.lambda_per_s * to_come) * answer.At(w) * hold / s;
}

LoopMargins Margins(const std::function<Complex(double)>& open_loop, double low, double high) {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  LoopMargins margins{kEndless, kEndless, kEndless, 0};
  const auto excess = [&](double w) { return std::log(std::abs(open_loop(w))); };
  const auto across = [&](double w) { return open_loop(w).imag(); };
  const auto at = [&](int i) { return low * std::pow(high / low, static_cast<double>(i) / kScanned); };
  std::vector<std::pair<double, double>> crossovers;  // rad/s, and rad from -1: above 0, before it
  std::vector<double> gains;                          // with which it would go through -1
  double turned = 0;                                  // of 1 + L, rad
  Complex before = open_loop(low);
  for (int i = 1; i <= kScanned; ++i) {
    const Complex now = open_loop(at(i));
    turned += std::arg((1.0 + now) / (1.0 + before));
    if ((std::abs(before) < 1) != (std::abs(now) < 1)) {
      const double w = Root(excess, at(i - 1), at(i));
      crossovers.emplace_back(w, std::arg(-open_loop(w)));
    }
    if ((before.imag() < 0) != (now.imag() < 0) && before.real() < 0 && now.real() < 0)
      gains.push_back(1 / std::abs(open_loop(Root(across, at(i - 1), at(i)))));
    before = now;
  }
  // Nyquist, of a loop that integrates once and has no pole to the right: stable, 1 + L turns from -90 degrees to
  // 0; each pair of poles to the right takes a whole turn from that.
  const bool stable = turned > 0;
  for (const double gain : gains)
    if ((gain > 1) == stable) margins.gain = std::min(margins.gain, gain);
  for (const auto& [w, phase] : crossovers) {
    margins.phase_deg = std::min(margins.phase_deg, std::abs(phase) * 180 / M_PI);
    const double delayed = stable && phase < 0 ? phase + 2 * M_PI : std::abs(phase);
    margins.delay_s = std::min(margins.delay_s, delayed / w);
  }
  if (!crossovers.empty()) margins.crossover_rad_s = crossovers.front().first;
  if (!stable) margins.phase_deg *= -1, margins.delay_s *= -1;
  return margins;
}

}  // namespace kestrel::control
