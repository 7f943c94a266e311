// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

// How far a polynomial c[0] + c[1] x + ... stays positive from x = 0: how far a distortion is one to one.
namespace kestrel::vision {

// Whether Bernstein coefficients are those of a polynomial that is positive over its interval. The polynomial
// lies within the hull of its coefficients, so all positive is proof; what they leave open is halved.
template <std::size_t n>
bool PositiveBernstein(std::array<double, n> b, int halvings = 40) {
  if (std::all_of(b.begin(), b.end(), [](double each) { return each > 0; })) return true;
  if (!(b.front() > 0 && b.back() > 0) || halvings == 0) return false;
  std::array<double, n> right = b;  // de Casteljau's scheme leaves the left half in b
  std::array<double, n> left{b[0]};
  for (std::size_t level = 1; level < n; ++level) {
    for (std::size_t i = 0; i + level < n; ++i) right[i] = (right[i] + right[i + 1]) / 2;
    left[level] = right[0];
  }
  return PositiveBernstein(left, halvings - 1) && PositiveBernstein(right, halvings - 1);
}

// Whether it is positive on all of [0, x].
template <std::size_t n>
bool PositiveUpTo(const std::array<double, n>& c, double x) {
  std::array<double, n> b{};
  double power = 1, choose_n = 1;  // x^i and the binomial of (degree, i)
  for (std::size_t i = 0; i < n; ++i) {
    const double share = c[i] * power / choose_n;
    double choose_j = 1;  // the binomial of (j, i)
    for (std::size_t j = i; j < n; ++j) {
      b[j] += share * choose_j;
      choose_j *= static_cast<double>(j + 1) / static_cast<double>(j + 1 - i);
    }
    power *= x;
    choose_n *= static_cast<double>(n - 1 - i) / static_cast<double>(i + 1);
  }
  return PositiveBernstein(b);
}

// The least x > 0 at which it is no longer positive; infinity: it stays so as far as matters here, 1e6.
template <std::size_t n>
double FirstZero(const std::array<double, n>& c) {
  double high = 1e-3;
  while (PositiveUpTo(c, high)) {
    if (high > 1e6) return std::numeric_limits<double>::infinity();
    high *= 2;
  }
  double low = 0;
  for (double middle = high / 2; middle > low && middle < high; middle = (low + high) / 2) {
    (PositiveUpTo(c, middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace kestrel::vision
