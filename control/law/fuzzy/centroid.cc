// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/centroid.h"

#include <algorithm>
#include <cmath>

namespace kestrel::control {
namespace {

// A straight piece of a membership function over [x0, x1].
struct Piece {
  double y0, y1;
  double At(double share) const { return (1 - share) * y0 + share * y1; }
};

// Of a set with no corner between x0 and x1; at a corner where it leaps, its value on the side of the piece.
Piece PieceOf(const ImpliedSet& set, double x0, double x1) {
  const double a = set.corners[0], b = set.corners[1], c = set.corners[2], d = set.corners[3];
  const double middle = x0 + (x1 - x0) / 2;
  if (middle < a || middle > d) return {0, 0};
  if (middle < b) return {set.height * (x0 - a) / (b - a), set.height * (x1 - a) / (b - a)};
  if (middle > c) return {set.height * (d - x0) / (d - c), set.height * (d - x1) / (d - c)};
  return {set.height, set.height};
}

// Of the area under straight pieces.
struct Moments {
  double area = 0, first = 0;
  void Add(double x0, double x1, double y0, double y1) {
    area += (x1 - x0) * (y0 + y1) / 2;
    first += (x1 - x0) * (x0 * (2 * y0 + y1) + x1 * (y0 + 2 * y1)) / 6;
  }
};

void AddSum(const std::vector<Piece>& pieces, double x0, double x1, Moments& moments) {
  double y0 = 0, y1 = 0;
  for (const Piece& piece : pieces) y0 += piece.y0, y1 += piece.y1;
  moments.Add(x0, x1, y0, y1);
}

void AddMax(const std::vector<Piece>& pieces, double x0, double x1, Moments& moments) {
  std::vector<double> shares = {0, 1};  // of the way from x0 to x1: the ends, and where two cross
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double at_x0 = pieces[i].y0 - pieces[j].y0, at_x1 = pieces[i].y1 - pieces[j].y1;
      if (at_x0 * at_x1 < 0) shares.push_back(at_x0 / (at_x0 - at_x1));
    }
  std::sort(shares.begin(), shares.end());
  const auto highest = [&](double share) {
    double y = 0;
    for (const Piece& piece : pieces) y = std::max(y, piece.At(share));
    return y;
  };
  for (std::size_t i = 1; i < shares.size(); ++i)
    moments.Add(x0 + shares[i - 1] * (x1 - x0), x0 + shares[i] * (x1 - x0), highest(shares[i - 1]),
                highest(shares[i]));
}

}  // namespace

ImpliedSet CutOff(const FuzzySet& set, double height) {
  Eigen::Vector4d corners = set.corners;
  corners[1] = corners[0] + height * (set.corners[1] - corners[0]);
  corners[2] = corners[3] - height * (corners[3] - set.corners[2]);
  return {corners, height};
}

ImpliedSet Scaled(const FuzzySet& set, double height) { return {set.corners, height}; }

std::optional<double> Centroid(const std::vector<ImpliedSet>& sets, Aggregation aggregation, double low,
                               double high) {
  std::vector<double> knots = {low, high};
  for (const ImpliedSet& set : sets)
    for (const double corner : set.corners)
      if (low < corner && corner < high) knots.push_back(corner);
  std::sort(knots.begin(), knots.end());
  Moments moments;
  std::vector<Piece> pieces(sets.size());
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const double x0 = knots[i - 1], x1 = knots[i];
    if (!(x0 < x1)) continue;
    for (std::size_t k = 0; k < sets.size(); ++k) pieces[k] = PieceOf(sets[k], x0, x1);
    aggregation == Aggregation::kMax ? AddMax(pieces, x0, x1, moments) : AddSum(pieces, x0, x1, moments);
  }
  if (!(moments.area > 0)) return std::nullopt;
  return std::clamp(moments.first / moments.area, low, high);
}

}  // namespace kestrel::control
