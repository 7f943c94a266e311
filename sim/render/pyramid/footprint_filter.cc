// SPDX-License-Identifier: Apache-2.0
#include "sim/render/pyramid/footprint_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace kestrel::sim::ray {
namespace {

constexpr int kReach = 3;
// Of numbers between the two passes: 8 bits and these, so that two of them fit 16 though the filter may sharpen.
constexpr int kSpareBits = 5, kWeightBits = 12;
// A footprint goes by the root of the mean square of its two sides. Seen aslant, its shorter side is less by far: this
// much of it gives the least error over slants (`kestrel bench render`, from many rays for each pixel).
constexpr double kWidth = 0.82;

double Interpolation(double x) { return std::max(0.0, 1 - std::abs(x)); }

// What is wanted at a texel, of the one n away: the footprint's mean, seen through the weights of interpolation.
double Wanted(int n, double width, bool original) {
  constexpr int kSteps = 64;
  const auto place = [](int i, double range) { return ((i + 0.5) / kSteps - 0.5) * range; };
  double sum = 0, weights = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double x = place(j, original ? 2 : 1), weight = original ? Interpolation(x) : 1;
      sum += weight * Interpolation(n + place(i, width) + x), weights += weight;
    }
  }
  return sum / weights;
}

int Beyond(int at, int size, bool repeats) {
  return repeats ? (at % size + size) % size : std::clamp(at, 0, size - 1);
}

// Of places k before and k after the middle, which together fit 16 bits: products of 16 bits by 16 are what every
// processor makes many of at once.
template <int shift, class Number>
int Weighed(const FootprintFilter& filter, const std::array<const Number*, 2 * kReach + 1>& from, int i) {
  const auto times = [&](int k, int sum) {
    return static_cast<int>(static_cast<std::int16_t>(filter[k])) * static_cast<std::int16_t>(sum);
  };
  int sum = times(0, from[kReach][i]) + (1 << (shift - 1));
  for (int k = 1; k <= kReach; ++k) sum += times(k, from[kReach - k][i] + from[kReach + k][i]);
  return sum >> shift;
}

}  // namespace

FootprintFilter FilterFor(double footprint, bool original) {
  // Least squares: the inverse of how texels overlap in interpolation (1/6, 2/3, 1/6) is sqrt(3) z^|n|.
  const double z = std::sqrt(3.0) - 2;
  std::array<double, kReach + 1> wanted{}, exact{};
  for (int k = 0; k <= kReach; ++k) wanted[k] = Wanted(k, kWidth * footprint, original);
  for (int n = 0; n <= kReach; ++n)
    for (int k = -kReach; k <= kReach; ++k) exact[n] += wanted[std::abs(k)] * std::pow(z, std::abs(n - k));
  const double all = exact[0] + 2 * (exact[1] + exact[2] + exact[3]);
  FootprintFilter filter{};
  int others = 0;
  for (int n = 1; n <= kReach; ++n) {
    filter[n] = static_cast<int>(std::lround((1 << kWeightBits) * exact[n] / all));
    others += 2 * filter[n];
  }
  filter[0] = (1 << kWeightBits) - others;
  return filter;
}

cv::Mat Filtered(const cv::Mat& picture, cv::Range rows, const FootprintFilter& filter, bool repeats) {
  const FootprintFilter weights = filter;
  const int channels = picture.channels(), numbers = picture.cols * channels;
  cv::Mat across(rows.size() + 2 * kReach, numbers, CV_16S), out(rows.size(), picture.cols, picture.type());
  std::vector<std::uint8_t> padded(static_cast<std::size_t>(numbers) + 2 * kReach * channels);
  for (int y = 0; y < across.rows; ++y) {
    const std::uint8_t* row = picture.ptr(Beyond(rows.start + y - kReach, picture.rows, repeats));
    std::copy_n(row, numbers, padded.data() + kReach * channels);
    for (int x = 0; x < kReach; ++x) {
      std::copy_n(row + Beyond(x - kReach, picture.cols, repeats) * channels, channels,
                  padded.data() + x * channels);
      std::copy_n(row + Beyond(picture.cols + x, picture.cols, repeats) * channels, channels,
                  padded.data() + numbers + (kReach + x) * channels);
    }
    std::array<const std::uint8_t*, 2 * kReach + 1> from{};
    for (int k = 0; k <= 2 * kReach; ++k) from[k] = padded.data() + k * channels;
    std::int16_t* const __restrict to = across.ptr<std::int16_t>(y);
    for (int i = 0; i < numbers; ++i)
      to[i] = static_cast<std::int16_t>(Weighed<kWeightBits - kSpareBits>(weights, from, i));
  }
  for (int y = 0; y < out.rows; ++y) {
    std::array<const std::int16_t*, 2 * kReach + 1> from{};
    for (int k = 0; k <= 2 * kReach; ++k) from[k] = across.ptr<std::int16_t>(y + k);
    std::uint8_t* const __restrict to = out.ptr(y);
    for (int i = 0; i < numbers; ++i)
      to[i] =
          static_cast<std::uint8_t>(std::clamp(Weighed<kWeightBits + kSpareBits>(weights, from, i), 0, 255));
  }
  return out;
}

}  // namespace kestrel::sim::ray
