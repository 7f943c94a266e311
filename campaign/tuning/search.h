// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

// Searches for the least of a function over the unit cube. Each asks for points, is told what they cost, and
// so on; how the points of one asking are evaluated, in what order or by how many at a time, changes nothing.
// Where the cost has a part of chance, what is the same chance for all that a search compares does not
// mislead it: kComparesRounds says whether that is more than the points of one asking.
namespace kestrel::campaign {

using Point = std::vector<double>;

// How far a search looks around its start, standard deviation along each side of the cube.
constexpr double kFirstStep = 0.3;

// Covariance matrix adaptation (Hansen 2006), pagmo's. A coordinate that it draws beyond the cube is on its
// wall.
class CmaEs {
 public:
  static constexpr bool kComparesRounds = false;
  CmaEs(const Point& start, std::uint64_t seed);
  ~CmaEs();
  CmaEs(CmaEs&&) noexcept;
  CmaEs& operator=(CmaEs&&) noexcept;

  const std::vector<Point>& Ask();  // the same ones until they are told of
  void Tell(const std::vector<double>& costs);
  const Point& Centre() const;  // of where it looks, the mean of its best points

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The cross-entropy method (Rubinstein, Kroese 2004): a normal distribution, independent along each side,
// that follows the best quarter of its points, smoothed.
class CrossEntropy {
 public:
  static constexpr bool kComparesRounds = false;
  CrossEntropy(Point start, std::uint64_t seed);
  const std::vector<Point>& Ask();
  void Tell(const std::vector<double>& costs);
  const Point& Centre() const { return mean_; }

 private:
  std::uint64_t seed_;
  int generation_ = 0;
  Point mean_, sigma_;
  std::vector<Point> asked_;
};

// Points drawn evenly from the cube.
class RandomSearch {
 public:
  static constexpr bool kComparesRounds = true;
  RandomSearch(Point start, std::uint64_t seed);
  const std::vector<Point>& Ask();
  void Tell(const std::vector<double>& costs);
  const Point& Centre() const { return best_; }

 private:
  std::uint64_t seed_;
  int generation_ = 0;
  Point best_;
  double min_;
  std::vector<Point> asked_;
};

using Search = std::variant<CmaEs, CrossEntropy, RandomSearch>;

bool ComparesRounds(const Search& search);

// "cma_es", "cross_entropy", "random_search". A method that is none of them is a bug.
Search MakeSearch(const std::string& method, const Point& start, std::uint64_t seed);

// The indices of the costs, the least first.
std::vector<std::size_t> ByCost(const std::vector<double>& costs);

}  // namespace kestrel::campaign
