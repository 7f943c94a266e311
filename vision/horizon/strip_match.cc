// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/strip_match.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "geometry/tait_bryan.h"
#include "vision/least_squares.h"

namespace kestrel::vision {

namespace {

static_assert(kStripGrid.elevations <= StripColumn::kRows);
constexpr float kMinShared = 0.06f;  // of the strip, in which two must overlap
constexpr double kTukey = 1.6;       // where a difference says nothing more, in units of the pattern

cv::Mat Halved(const cv::Mat& full) {
  cv::Mat half;
  cv::resize(full, half, {full.cols / 2, full.rows}, 0, 0, cv::INTER_AREA);
  return half;
}
cv::Mat Spectrum(const cv::Mat& rows) {
  cv::Mat out;
  cv::dft(rows, out, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  return out;
}
// Sum over the rows of the circular correlations: out[k] = sum of a(i) b(i + k).
cv::Mat Correlate(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat sum(1, a.cols, CV_32FC2, cv::Scalar(0, 0));
  auto* s = sum.ptr<std::complex<float>>(0);
  for (int j = 0; j < a.rows; ++j) {
    const auto* p = a.ptr<std::complex<float>>(j);
    const auto* q = b.ptr<std::complex<float>>(j);
    for (int i = 0; i <= a.cols / 2; ++i) {
      const float re = p[i].real() * q[i].real() + p[i].imag() * q[i].imag();
      const float im = p[i].real() * q[i].imag() - p[i].imag() * q[i].real();
      s[i] += std::complex<float>(re, im);
    }
  }
  for (int i = a.cols / 2 + 1; i < a.cols; ++i) s[i] = std::conj(s[a.cols - i]);
  cv::Mat out;
  cv::idft(sum, out, cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return out;
}

using Lanes = std::array<float, StripColumn::kRows>;

float Sum(const Lanes& lanes) {
  std::array<float, 4> four{};
  for (std::size_t j = 0; j < lanes.size(); ++j) four[j % 4] += lanes[j];
  return (four[0] + four[1]) + (four[2] + four[3]);
}

// Of the rows of a column: products of the slopes a by column and e by row and of the residual r, weighted; and,
// not weighted, of both patterns.
struct ColumnSums {
  float aa, ae, ee, ar, er, rr, weight;
  float cross, energy_now, energy_then;
};

// left, right, f: between which columns `then` is seen where `now` is; up: rows by which it is higher there.
ColumnSums Compare(const StripColumn& left, const StripColumn& right, float f, const StripColumn& now,
                   float up) {
  Lanes aa, ae, ee, ar, er, rr, weight, cross, energy_now, energy_then;
  for (std::size_t j = 0; j < StripColumn::kRows; ++j) {
    const float both = now.shown[j] * left.shown[j] * right.shown[j];
    const float a = (1 - f) * left.by_column[j] + f * right.by_column[j];
    const float e = (1 - f) * left.by_row[j] + f * right.by_row[j];
    const float here = both * now.pattern[j];
    const float there = both * ((1 - f) * left.pattern[j] + f * right.pattern[j] + up * e);
    const float r = here - there, u = r / static_cast<float>(kTukey);
    const float w = both * TukeyWeight(u);
    aa[j] = w * a * a, ae[j] = w * a * e, ee[j] = w * e * e;
    ar[j] = w * a * r, er[j] = w * e * r, rr[j] = w * r * r;
    weight[j] = w;
    cross[j] = here * there, energy_now[j] = here * here, energy_then[j] = there * there;
  }
  return {Sum(aa), Sum(ae),     Sum(ee),    Sum(ar),         Sum(er),
          Sum(rr), Sum(weight), Sum(cross), Sum(energy_now), Sum(energy_then)};
}

}  // namespace

StripReference MakeReference(PanoramaStrip strip) {
  StripReference r;
  const int columns = strip.pattern.cols, rows = strip.pattern.rows;
  r.columns.resize(static_cast<std::size_t>(columns));
  for (int j = 1; j + 1 < rows; ++j) {
    const auto* p = strip.pattern.ptr<float>(j);
    const auto *low = strip.pattern.ptr<float>(j - 1), *high = strip.pattern.ptr<float>(j + 1);
    const auto at = static_cast<std::size_t>(j);
    for (int i = 0; i < columns; ++i) {
      StripColumn& column = r.columns[static_cast<std::size_t>(i)];
      column.pattern[at] = p[i];
      column.by_column[at] = (p[(i + 1) % columns] - p[(i + columns - 1) % columns]) / 2;
      column.by_row[at] = (high[i] - low[i]) / 2;
      column.shown[at] = strip.shown.at<float>(j, i) == 0 ? 0.0f : 1.0f;
    }
  }
  const cv::Mat half = Halved(strip.pattern), shown = Halved(strip.shown);
  r.spectrum = Spectrum(half);
  r.spectrum_square = Spectrum(half.mul(half));
  r.spectrum_shown = Spectrum(shown);
  r.strip = std::move(strip);
  return r;
}

std::vector<float> TurnLikeness(const StripReference& then, const StripReference& now) {
  const cv::Mat product = Correlate(now.spectrum, then.spectrum);
  const cv::Mat now_square = Correlate(now.spectrum_square, then.spectrum_shown);
  const cv::Mat then_square = Correlate(now.spectrum_shown, then.spectrum_square);
  const cv::Mat shared = Correlate(now.spectrum_shown, then.spectrum_shown);
  std::vector<float> out(static_cast<std::size_t>(product.cols), -1.0f);
  const float least = kMinShared * static_cast<float>(product.cols * now.spectrum.rows);
  for (int k = 0; k < product.cols; ++k) {
    const float energy = now_square.at<float>(0, k) * then_square.at<float>(0, k);
    if (shared.at<float>(0, k) > least && energy > 1e-3f)
      out[static_cast<std::size_t>(k)] = product.at<float>(0, k) / std::sqrt(energy);
  }
  return out;
}

TurnFit RefineTurn(const StripReference& then, const StripReference& now, double turn) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;  // turn, parallax (2), columns; tilt (2), height, rows
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const int columns = kStripGrid.azimuths;
  const double per_rad = columns / (2 * M_PI);
  Vector6 x = Vector6::Zero();
  x[0] = turn * per_rad;
  // Beforehand: parallax of some degrees, verticals that err by half a degree, a horizon by less.
  Vector6 prior;
  prior << 0, 1 / (0.3 * 0.3), 1 / (0.3 * 0.3), 1 / 0.25, 1 / 0.25, 1 / 0.1;
  TurnFit fit;
  std::vector<float> cosines(static_cast<std::size_t>(columns)), sines(cosines.size());
  for (int i = 0; i < columns; ++i) {
    cosines[static_cast<std::size_t>(i)] = static_cast<float>(std::cos(kStripGrid.Azimuth(i)));
    sines[static_cast<std::size_t>(i)] = static_cast<float>(std::sin(kStripGrid.Azimuth(i)));
  }
  Matrix6 H;
  NormalEquations<float, 6> normal;
  for (int round = 0; round < 6; ++round) {
    normal = {};
    double cross = 0, energy_now = 0, energy_then = 0;
    for (int i = round % 2; i < columns; i += 2) {
      const float c = cosines[static_cast<std::size_t>(i)], s = sines[static_cast<std::size_t>(i)];
      const float across = static_cast<float>(i) + static_cast<float>(x[0] + x[1] * static_cast<double>(c) +
                                                                      x[2] * static_cast<double>(s));
      const float up =
          static_cast<float>(x[3] * static_cast<double>(c) + x[4] * static_cast<double>(s) + x[5]);
      const float whole = std::floor(across), f = across - whole;
      int left = static_cast<int>(whole) % columns;
      if (left < 0) left += columns;
      const int right = left + 1 == columns ? 0 : left + 1;
      const ColumnSums sums =
          Compare(then.columns[static_cast<std::size_t>(left)], then.columns[static_cast<std::size_t>(right)],
                  f, now.columns[static_cast<std::size_t>(i)], up);
      cross += sums.cross, energy_now += sums.energy_now, energy_then += sums.energy_then;
      // By the unknowns the pattern changes as (a, a c, a s, e c, e s, e), of its slopes a and e.
      const Eigen::Vector3f by_a(1, c, s), by_e(c, s, 1);
      normal.H.topLeftCorner<3, 3>() += sums.aa * by_a * by_a.transpose();
      normal.H.topRightCorner<3, 3>() += sums.ae * by_a * by_e.transpose();
      normal.H.bottomRightCorner<3, 3>() += sums.ee * by_e * by_e.transpose();
      normal.g.head<3>() += sums.ar * by_a;
      normal.g.tail<3>() += sums.er * by_e;
      normal.squares += sums.rr, normal.weight += sums.weight;
    }
    normal.H.bottomLeftCorner<3, 3>() = normal.H.topRightCorner<3, 3>().transpose();
    if (normal.weight < 200) return fit;
    fit.likeness = cross / std::sqrt(energy_now * energy_then + 1e-9);
    const double noise2 = std::max(0.01, normal.squares / normal.weight);
    H = normal.H.cast<double>() / noise2;
    H.diagonal() += prior;
    Vector6 g = normal.g.cast<double>() / noise2;
    g -= prior.cwiseProduct(x);
    const Vector6 step = H.ldlt().solve(g);
    x += step;
    if (round > 0 && std::abs(step[0]) < 0.01) break;
  }
  const double moved = x[0] - turn * per_rad;
  fit.good = std::abs(moved) < 8 && x.segment<2>(3).norm() < 3;
  fit.turn = WrapAngle(x[0] / per_rad);
  fit.parallax = x.segment<2>(1).norm() / per_rad;
  // Neighbours in the pattern err together: some six of them count as one. What is at unlike ranges shifts
  // unlike; a part of the parallax stays in the turn.
  const Matrix6 P = H.inverse();
  const double floor = Radians(0.03), rest = 0.15 * fit.parallax, unlike = Radians(1.2) * (1 - fit.likeness);
  fit.variance = 6 * P(0, 0) / (per_rad * per_rad) + floor * floor + rest * rest + unlike * unlike;
  return fit;
}

}  // namespace kestrel::vision
