// SPDX-License-Identifier: Apache-2.0
#include "sim/deck/wave_spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/gravity.h"
#include "base/random.h"

namespace kestrel::sim {
namespace {

constexpr double kPhillips = 0.0081;
constexpr double kPeakedness = 3.3;
constexpr double kFrom = 0.5, kUntil = 5;  // of the peak
constexpr int kWaves = 80;
constexpr int kSlices = 40;  // of a cell, to integrate

double Integral(const WaveSpectrum& spectrum, double from, double until, int slices) {
  double sum = 0;
  for (int i = 0; i < slices; ++i) sum += spectrum.At(from + (until - from) * (i + 0.5) / slices);
  return sum * (until - from) / slices;
}

}  // namespace

SeaState SeaStateOf(int sea_state) {
  constexpr SeaState kStates[] = {{0.3, 7.5}, {0.88, 7.5}, {1.88, 8.8}, {3.25, 9.7}, {5.0, 12.4}};
  return kStates[std::clamp(sea_state, 2, 6) - 2];
}

WaveSpectrum::WaveSpectrum(const WaveParameters& p) : jonswap_(p.spectrum == "jonswap") {
  const SeaState of_state = p.sea_state > 0 ? SeaStateOf(p.sea_state) : SeaState{};
  height_m_ = p.height_m > 0 ? p.height_m : of_state.height_m;
  const double period_s = p.peak_s > 0 ? p.peak_s : of_state.peak_s;
  peak_ = p.spectrum == "pierson_moskowitz"
              ? std::pow(4.0 / 5 * 4 * kPhillips * std::pow(kGravity_m_s2 / height_m_, 2), 0.25)
              : 2 * std::numbers::pi / period_s;
  if (!jonswap_) return;
  const double m0 = Integral(*this, 0.3 * peak_, 30 * peak_, 20000);
  scale_ = height_m_ * height_m_ / 16 / m0;
}

// That of Pierson and Moskowitz is Bretschneider's with the peak that goes with its height.
double WaveSpectrum::At(double w) const {
  if (w <= 0) return 0;
  const double ratio = std::pow(peak_ / w, 4);
  double density = 5.0 / 16 * height_m_ * height_m_ * ratio / w * std::exp(-1.25 * ratio);
  if (jonswap_) {
    const double s = w <= peak_ ? 0.07 : 0.09;
    density *= scale_ * std::pow(kPeakedness, std::exp(-std::pow((w / peak_ - 1) / s, 2) / 2));
  }
  return density;
}

std::vector<Wave> WavesOf(const WaveSpectrum& spectrum, std::uint64_t seed) {
  RandomStream random(seed, "waves");
  const double from = kFrom * spectrum.peak_rad_s();
  const double width = (kUntil - kFrom) * spectrum.peak_rad_s() / kWaves;
  std::vector<Wave> waves(kWaves);
  double variance = 0;
  for (int i = 0; i < kWaves; ++i) {
    const double low = from + width * i;
    const double of_cell = Integral(spectrum, low, low + width, kSlices);
    variance += of_cell;
    const double w = random.Uniform(low, low + width), phase = random.Uniform(0, 2 * std::numbers::pi);
    waves[static_cast<std::size_t>(i)] = {std::sqrt(2 * of_cell), w, phase};
  }
  const double whole = spectrum.height_m() * spectrum.height_m() / 16;
  for (Wave& wave : waves) wave.amplitude_m *= std::sqrt(whole / variance);
  return waves;
}

}  // namespace kestrel::sim
