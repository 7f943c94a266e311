// SPDX-License-Identifier: Apache-2.0
#include "bench/planar/bench_planar.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>

#include "base/process/in_parallel.h"
#include "base/statistics.h"
#include "bench/planar/planar_pictures.h"
#include "bench/planar/planar_score.h"
#include "vision/landmark/plane/homography.h"
#include "vision/write_image.h"

namespace kestrel::bench {
namespace {

constexpr std::size_t kOurs = 0;
constexpr double kRecovered_s = 0.5;

struct Piece {
  std::uint64_t seed;
  PlanarPicture picture;
  PlanarFactor factor;
};

using Trackers = std::function<std::vector<PlanarTracker>(const cv::Mat& picture)>;

struct Row {
  std::string name;
  bool ours;
  PlanarScore score;
};

// With the true outline, as it is seen by the one who judges.
void Save(const std::filesystem::path& out, const Piece& piece, const std::vector<PlanarFrame>& frames) {
  std::filesystem::create_directories(out);
  for (std::size_t i = 0; i < frames.size(); i += 30) {
    cv::Mat drawn;
    cv::cvtColor(frames[i].image, drawn, cv::COLOR_GRAY2BGR);
    std::vector<cv::Point> outline;
    for (const Eigen::Vector2d& corner : PlanarCorners()) {
      const Eigen::Vector2d uv = vision::Transfer(frames[i].H_w, corner);
      outline.emplace_back(cvRound(uv.x()), cvRound(uv.y()));
    }
    cv::polylines(drawn, outline, true, {0, 200, 255}, 1, cv::LINE_AA);
    vision::WriteImage(
        out / fmt::format("{}_{}_{}_{:03}.png", NameOf(piece.factor), piece.picture.name, piece.seed, i),
        drawn);
  }
}

std::vector<Row> Run(const Piece& piece, const std::filesystem::path& out, const Trackers& trackers) {
  const PlanarSequence sequence(piece.picture.grey, piece.factor, piece.seed);
  std::vector<PlanarFrame> frames;
  for (int i = 0; i < kPlanarFrames; ++i) frames.push_back(sequence.Draw(i));
  if (!out.empty()) Save(out, piece, frames);
  std::vector<Row> rows;
  for (const PlanarTracker& tracker : trackers(piece.picture.grey))
    rows.push_back({tracker.name, tracker.ours, ScoreOf(tracker, frames)});
  return rows;
}

double RecoveredShare(const PlanarScore& score) {
  const auto soon = std::count_if(score.recovery_s.begin(), score.recovery_s.end(),
                                  [](double s) { return s <= kRecovered_s; });
  return static_cast<double>(soon) / static_cast<double>(std::max<std::size_t>(1, score.recovery_s.size()));
}

void Print(const std::string& what, const std::vector<Row>& rows) {
  for (const auto& [name, ours, s] : rows)
    fmt::print("| {:<13} | {:<17} | {:8.2f} | {:6.3f} {:6.3f} {:6.3f} | {:6} | {:>9} | {:>8} | {:6.1f} |\n",
               what, name, s.Accuracy_px(), s.Precision(1), s.Precision(5), s.Precision(15), s.losses,
               s.recovery_s.empty() ? "" : fmt::format("{:.2f}", RecoveredShare(s)),
               s.gone == 0 ? "" : fmt::format("{:.2f}", static_cast<double>(s.imagined) / s.gone),
               Mean(s.ms));
}

// Adds the rows of one sequence to those of many.
void Gather(const std::vector<Row>& rows, std::vector<Row>& all) {
  if (all.empty()) {
    all = rows;
    return;
  }
  for (std::size_t k = 0; k < rows.size(); ++k) all[k].score.Add(rows[k].score);
}

}  // namespace

void BenchPlanar(flight::SeedRange seeds, int jobs, const std::filesystem::path& out,
                 const Trackers& trackers, std::vector<records::Figure>& table) {
  seeds.last = std::min(seeds.last, seeds.first + 4);
  std::vector<Piece> pieces;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed)
    for (const PlanarPicture& picture : PlanarPictures(seed))
      for (const PlanarFactor factor : kPlanarFactors) pieces.push_back({seed, picture, factor});
  std::vector<std::vector<Row>> results(pieces.size());
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  InParallel(pieces.size(), jobs, "planar", "sequences", [&](std::size_t i) {
    results[i] = Run(pieces[i], pieces[i].seed == seeds.first ? out : std::filesystem::path(), trackers);
  });
  cv::setNumThreads(threads);

  std::vector<Row> all;
  std::map<std::string, std::vector<Row>> by_picture;
  std::map<PlanarFactor, std::vector<Row>> by_factor;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    Gather(results[i], all);
    Gather(results[i], by_picture[pieces[i].picture.name]);
    Gather(results[i], by_factor[pieces[i].factor]);
  }
  fmt::print(
      "| {:<13} | {:<17} | error px | within 1 px, 5, 15   | losses | recovered | imagined | ms     |\n",
      "factor", "tracker");
  for (const auto& [factor, rows] : by_factor) Print(NameOf(factor), rows);
  for (const auto& [name, rows] : by_picture) Print(name, rows);
  Print("all", all);

  // The mean of the factors, each as good as another.
  const auto precision = [&](std::size_t k, double within_px) {
    std::vector<double> of_factors;
    for (const auto& [factor, rows] : by_factor) of_factors.push_back(rows[k].score.Precision(within_px));
    return Mean(of_factors);
  };
  const auto best = [&](auto&& of) {
    double value = 0;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (!all[k].ours) value = std::max(value, of(k));
    return value;
  };
  for (const auto& [factor, rows] : by_factor) {
    const double peer = best([&, &its = rows](std::size_t k) { return its[k].score.Precision(5); });
    table.push_back({fmt::format("planar, {}: within 5 px", NameOf(factor)),
                     rows[kOurs].score.Precision(5),
                     "share",
                     {},
                     true,
                     fmt::format("{:.3f}", peer)});
  }
  const double peer = best([&](std::size_t k) { return precision(k, 5); });
  table.push_back({"planar, mean of the factors: within 5 px", precision(kOurs, 5), "share",
                   std::max(0.95, peer), true, fmt::format("{:.3f}", peer)});
  for (const double within_px : {1.0, 15.0})
    table.push_back({fmt::format("planar, mean of the factors: within {:g} px", within_px),
                     precision(kOurs, within_px),
                     "share",
                     {},
                     true,
                     fmt::format("{:.3f}", best([&](std::size_t k) { return precision(k, within_px); }))});
  const auto& out_of_view = by_factor[PlanarFactor::kOutOfView];
  table.push_back(
      {"planar, out of view: right again within 0.5 s", RecoveredShare(out_of_view[kOurs].score), "share",
       0.95, true,
       fmt::format("{:.3f}", best([&](std::size_t k) { return RecoveredShare(out_of_view[k].score); }))});
  table.push_back({"planar, error of the corners", all[kOurs].score.Accuracy_px(), "px", {}, false, ""});
  table.push_back({"planar, time, mean an image", Mean(all[kOurs].score.ms), "ms", {}, false, ""});
}

}  // namespace kestrel::bench
