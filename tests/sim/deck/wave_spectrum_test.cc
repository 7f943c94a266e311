// SPDX-License-Identifier: Apache-2.0
#include "sim/deck/wave_spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kestrel::sim {
namespace {

// By the trapezium rule on a logarithmic grid.
double Moment(const WaveSpectrum& spectrum, int order) {
  double sum = 0;
  const double low = std::log(0.05), step = 1e-3;
  for (double x = low; x < std::log(60.0); x += step) {
    const double w = std::exp(x);
    sum += std::pow(w, order) * spectrum.At(w) * w * step;
  }
  return sum;
}

double PeakOf(const WaveSpectrum& spectrum) {
  double best = 0, at = 0;
  for (double w = 0.1; w < 5; w += 1e-3)
    if (spectrum.At(w) > best) best = spectrum.At(w), at = w;
  return at;
}

TEST(WaveSpectrumTest, SignificantHeightIsFourRootsOfTheVarianceAndThePeakIsWhereItIsSaid) {
  int checked = 0;
  for (const char* name : {"bretschneider", "jonswap"})
    for (int state = 2; state <= 6; ++state) {
      const WaveSpectrum spectrum({.spectrum = name, .sea_state = state});
      const SeaState of = SeaStateOf(state);
      EXPECT_NEAR(4 * std::sqrt(Moment(spectrum, 0)), of.height_m, 1e-3 * of.height_m) << name << state;
      EXPECT_NEAR(2 * std::numbers::pi / PeakOf(spectrum), of.peak_s, 2e-2 * of.peak_s) << name << state;
      ++checked;
    }
  EXPECT_EQ(checked, 10);
}

// The mean zero-crossing period of Bretschneider's spectrum is 0.710 of its peak's (ITTC).
TEST(WaveSpectrumTest, BretschneidersMeanPeriodIsThatOfTheLiterature) {
  const WaveSpectrum spectrum({.spectrum = "bretschneider", .sea_state = 4});
  const double zero_crossing_s = 2 * std::numbers::pi * std::sqrt(Moment(spectrum, 0) / Moment(spectrum, 2));
  EXPECT_NEAR(zero_crossing_s / 8.8, 0.710, 0.005);
}

// As printed by Pierson and Moskowitz, by the wind at 19.5 m: H = 0.21 U^2 / g, peak at 0.877 g / U.
TEST(WaveSpectrumTest, ThatOfPiersonAndMoskowitzIsTheirsByItsWind) {
  const double g = 9.80665, U = 12;
  const double height_m = 2 * U * U / g * std::sqrt(0.0081 / 0.74);
  const WaveSpectrum spectrum({.spectrum = "pierson_moskowitz", .height_m = height_m});
  EXPECT_NEAR(height_m, 0.21 * U * U / g, 0.02);
  EXPECT_NEAR(spectrum.peak_rad_s(), 0.877 * g / U, 1e-3);
  for (const double w : {0.4, 0.7, 1.0, 2.0}) {
    const double printed = 0.0081 * g * g / std::pow(w, 5) * std::exp(-0.74 * std::pow(g / U / w, 4));
    EXPECT_NEAR(spectrum.At(w), printed, 1e-9 + 1e-6 * printed) << w;
  }
}

TEST(WaveSpectrumTest, WavesHaveTheVarianceOfTheirSpectrumWhereverTheSeedPutsThem) {
  const WaveSpectrum spectrum({.spectrum = "jonswap", .sea_state = 5});
  for (const std::uint64_t seed : {1, 2, 3}) {
    double variance = 0, in_time = 0;
    const std::vector<Wave> waves = WavesOf(spectrum, seed);
    for (const Wave& wave : waves) variance += wave.amplitude_m * wave.amplitude_m / 2;
    EXPECT_NEAR(4 * std::sqrt(variance), 3.25, 1e-6);
    constexpr int kSamples = 3000;
    for (int i = 0; i < kSamples; ++i) {
      double elevation = 0;
      for (const Wave& wave : waves) elevation += wave.amplitude_m * std::cos(wave.w * 0.37 * i + wave.phase);
      in_time += elevation * elevation / kSamples;
    }
    EXPECT_NEAR(4 * std::sqrt(in_time), 3.25, 0.2) << seed;
  }
}

}  // namespace
}  // namespace kestrel::sim
