// SPDX-License-Identifier: Apache-2.0
#include "bench/enhance/bench_mosaic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <opencv2/stitching/detail/warpers.hpp>
#include <string>

#include "base/statistics.h"
#include "bench/enhance/mosaic_drawings.h"
#include "bench/enhance/mosaic_judgement.h"
#include "vision/enhance/mosaic/composition.h"
#include "vision/enhance/mosaic/mosaic.h"
#include "vision/write_image.h"

namespace kestrel::bench {
namespace {

constexpr int kSurveyImages = 450, kTurnImages = 120;

double ProcessorTime_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Grown {
  vision::Mosaic mosaic;
  double mean_ms = 0, longest_ms = 0;  // an image; the mean with the adjustment at the end
};

Grown Grow(
    const vision::MosaicOptions& options, int images, const std::function<cv::Mat(int)>& draw,
    const std::function<std::optional<Pose>(int)>& pose = [](int) { return std::nullopt; }) {
  Grown grown{vision::Mosaic(options)};
  double sum_s = 0;
  for (int i = 0; i < images; ++i) {
    const cv::Mat image = draw(i);
    const double start = ProcessorTime_s();
    grown.mosaic.Add(image, 0.1 * i, pose(i));
    const double took = ProcessorTime_s() - start;
    sum_s += took;
    grown.longest_ms = std::max(grown.longest_ms, 1e3 * took);
  }
  const double start = ProcessorTime_s();
  grown.mosaic.Adjust();
  grown.mean_ms = 1e3 * (sum_s + ProcessorTime_s() - start) / images;
  return grown;
}

// The farthest that a projection and OpenCV's are apart, forward and back, px.
template <class Projector>
double FromOpenCvs_px(vision::Surface surface, double down_px_per_rad) {
  constexpr float kF_px = 128;
  Projector projector;
  projector.scale = kF_px;
  projector.setCameraParams();
  double farthest = 0;
  for (double azimuth = -1.1; azimuth <= 1.1; azimuth += 0.05)
    for (double elevation = -0.8; elevation <= 0.8; elevation += 0.05) {
      const Eigen::Vector3d w(std::tan(azimuth), std::tan(elevation), 1);
      float u = 0, v = 0, x = 0, y = 0;
      projector.mapForward(static_cast<float>(w.x()), static_cast<float>(w.y()), u, v);
      const auto at = vision::OnSurface(surface, kF_px, w);
      const Eigen::Vector2d theirs(u, v - down_px_per_rad * kF_px);
      farthest = std::max(farthest, (*at - theirs).norm());
      projector.mapBackward(u, v, x, y);
      const auto back = vision::FromSurface(surface, kF_px, theirs);
      farthest = std::max(
          farthest,
          kF_px *
              (Eigen::Vector2d(back->x() / back->z(), back->y() / back->z()) - Eigen::Vector2d(x, y)).norm() *
              std::pow(std::cos(azimuth) * std::cos(elevation), 2));
    }
  return farthest;
}

void Save(const std::filesystem::path& out, const std::string& name, const cv::Mat& image) {
  if (out.empty() || image.empty()) return;
  std::filesystem::create_directories(out);
  vision::WriteImage(out / (name + ".jpg"), image);
}

struct SurveyRow {
  std::string name;
  vision::MosaicOptions options;
  bool poses = false;
  std::vector<double> placed_px, picture_px, ms, longest_ms;
};

void BenchSurvey(flight::SeedRange seeds, const std::filesystem::path& out,
                 std::vector<records::Figure>& table) {
  vision::MosaicOptions chain, loops, poses;
  chain.camera = loops.camera = poses.camera = kMosaicCamera;
  chain.loops = false;
  poses.pose_sigma_m = 0.5, poses.pose_sigma_deg = 0.5;
  std::vector<SurveyRow> rows = {{"chained alone", chain, false, {}, {}, {}, {}},
                                 {"with loops", loops, false, {}, {}, {}, {}},
                                 {"with loops and poses", poses, true, {}, {}, {}, {}}};
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    const DrawnSurvey survey(kSurveyImages, seed);
    for (SurveyRow& row : rows) {
      Grown grown = Grow(
          row.options, survey.images(), [&](int i) { return survey.Draw(i); },
          [&](int i) { return row.poses ? std::optional(survey.Known(i)) : std::nullopt; });
      const vision::MosaicPicture picture = grown.mosaic.Picture();
      cv::Mat drawn;
      const SurveyErrors errors = JudgeSurvey(survey, grown.mosaic, picture, !row.poses, seed, &drawn);
      row.placed_px.push_back(errors.placed_px);
      row.picture_px.push_back(errors.picture_px);
      row.ms.push_back(grown.mean_ms);
      row.longest_ms.push_back(grown.longest_ms);
      fmt::print(
          "| survey {:<21} | seed {} | placed {:7.3f} px | picture {:7.3f} px ({} points) | {} keyframes, {} "
          "kept, {} loops | {:.1f} ms an image, longest {:.0f} ms |\n",
          row.name, seed, errors.placed_px, errors.picture_px, errors.points, grown.mosaic.keyframes(),
          grown.mosaic.kept().size(), grown.mosaic.loops(), grown.mean_ms, grown.longest_ms);
      if (seed == seeds.first) {
        Save(out, row.poses ? "survey_poses" : row.options.loops ? "survey_loops" : "survey_chained", drawn);
      }
    }
  }
  for (const SurveyRow& row : rows) {
    const bool judged = row.options.loops && !row.poses;
    const auto target = [&](double value) { return judged ? std::optional(value) : std::nullopt; };
    table.push_back(
        {fmt::format("mosaic, survey of 450 images {}: 200 ground points in the picture, RMS", row.name),
         Mean(row.picture_px), "px", target(1), false, "by eye"});
    table.push_back({fmt::format("mosaic, survey of 450 images {}: by where images are placed", row.name),
                     Mean(row.placed_px), "px", target(1), false, ""});
    if (judged)
      table.push_back({"mosaic, planar, an image of 640 x 480, one core", Mean(row.ms), "ms", 15, false, ""});
    if (judged) table.push_back({"mosaic, planar, longest image", Mean(row.longest_ms), "ms", {}, false, ""});
  }
}

void BenchTurn(flight::SeedRange seeds, const std::filesystem::path& out,
               std::vector<records::Figure>& table) {
  std::vector<double> closure, direction, chained, ms;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    const DrawnTurn turn(kTurnImages, seed);
    vision::MosaicOptions options;
    options.model = vision::MosaicModel::kRotation;
    options.surface = vision::Surface::kSphere;
    options.camera = kMosaicCamera;
    const auto draw = [&](int i) { return turn.Draw(i); };
    Grown grown = Grow(options, turn.images(), draw);
    const TurnErrors errors = JudgeTurn(turn, grown.mosaic, seed);
    options.loops = false;
    const TurnErrors alone = JudgeTurn(turn, Grow(options, turn.images(), draw).mosaic, seed);
    closure.push_back(errors.closure_deg), direction.push_back(errors.direction_deg);
    chained.push_back(alone.closure_deg), ms.push_back(grown.mean_ms);
    fmt::print(
        "| panorama | seed {} | closure {:.4f} deg, chained alone {:.4f} deg | RMS {:.4f} deg | {:.1f} ms an "
        "image |\n",
        seed, errors.closure_deg, alone.closure_deg, errors.direction_deg, grown.mean_ms);
    if (seed == seeds.first) Save(out, "panorama", grown.mosaic.Picture().image);
  }
  table.push_back({"mosaic, panorama of 360 degrees: closure", Mean(closure), "deg", 0.1, false, ""});
  table.push_back({"mosaic, panorama: closure, chained alone", Mean(chained), "deg", {}, false, ""});
  table.push_back({"mosaic, panorama: directions, RMS", Mean(direction), "deg", 0.05, false, ""});
  table.push_back({"mosaic, spherical, an image of 640 x 480, one core", Mean(ms), "ms", 25, false, ""});
}

}  // namespace

void BenchMosaic(flight::SeedRange seeds, const std::filesystem::path& out,
                 std::vector<records::Figure>& table) {
  seeds.last = std::min(seeds.last, seeds.first + 1);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  BenchSurvey(seeds, out, table);
  BenchTurn(seeds, out, table);
  cv::setNumThreads(threads);
  const double projections = std::max(
      {FromOpenCvs_px<cv::detail::PlaneProjector>(vision::Surface::kPlane, 0),
       FromOpenCvs_px<cv::detail::CylindricalProjector>(vision::Surface::kCylinder, 0),
       FromOpenCvs_px<cv::detail::SphericalProjector>(vision::Surface::kSphere, std::numbers::pi / 2)});
  table.push_back(
      {"mosaic, projections forward and back, from OpenCV's at most", projections, "px", 1e-4, false, ""});
}

}  // namespace kestrel::bench
