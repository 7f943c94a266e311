// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/diagnostics.h"
#include "base/process/in_parallel.h"
#include "base/statistics.h"
#include "bench/named_camera.h"
#include "flight/simulated/scenario.h"
#include "sim/calibration/board_renderer.h"
#include "vision/calibration/calibrate.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::bench {
namespace {

constexpr int kCalibrationImages = 30;

struct Trial {
  std::string name, model;
  vision::CameraModel camera;
  vision::Board board;
};

std::vector<Trial> Trials() {
  // Some 180 degrees, made up.
  const vision::DoubleSphere sphere{640, 480, 180, 181, 322, 237, -0.2, 0.6, 1.6};
  std::vector<Trial> trials;
  for (const auto& [name, model, camera] :
       {std::tuple{"pinhole 43 deg", "pinhole", NamedCamera("thesis_6mm")},
        {"fisheye 190 deg", "fisheye", NamedCamera("fisheye")},
        {"mirror 243 deg", "unified", NamedCamera("hyperbolic_mirror")},
        {"double sphere 180 deg", "double_sphere", vision::CameraModel(sphere)}}) {
    trials.push_back({fmt::format("{}, chessboard", name), model, camera, vision::Chessboard{}});
    trials.push_back({fmt::format("{}, tags", name), model, camera, vision::AprilGrid{}});
  }
  return trials;
}

// The numbers that the file of a camera gives, in the order of the calibrated model's.
Eigen::VectorXd TruthFor(const vision::CameraModel& camera, Eigen::Index size) {
  Eigen::VectorXd truth = Eigen::VectorXd::Zero(size);  // a pinhole's distortion is none
  const Eigen::VectorXd given = vision::Parameters(camera);
  truth.head(given.size()) = given;
  return truth;
}

struct Outcome {
  double rms_px = 0;
  std::vector<double> normalised;  // of f, centre and xi or alpha: error over its own sigma
  Eigen::Vector2d corner_error = Eigen::Vector2d::Zero();  // sum
  double corner_square = 0;
  int corners = 0;
};

Outcome Run(const Trial& trial, std::uint64_t seed) {
  sim::BoardRenderer renderer(trial.board, trial.camera, {.threads = 1});
  const std::vector<Pose> poses = sim::SpreadPoses(trial.camera, trial.board, kCalibrationImages, seed);
  std::vector<cv::Mat> images;
  std::vector<vision::BoardView> views;
  for (int i = 0; i < kCalibrationImages; ++i) {
    images.push_back(renderer.Render(poses[static_cast<std::size_t>(i)], seed, i));
    views.push_back({std::to_string(i), vision::FindBoard(images.back(), trial.board)});
  }
  const vision::CameraModel like = vision::CameraLike(trial.model, images.front().size());
  const vision::Calibration first = vision::Calibrate(trial.board, views, like);
  views = vision::Refit(trial.board, images, views, first);
  const vision::Calibration c = vision::Calibrate(trial.board, views, like);

  Outcome outcome{.rms_px = c.rms_px, .normalised = {}};
  const Eigen::VectorXd found = vision::Parameters(c.camera), truth = TruthFor(trial.camera, found.size());
  const std::vector<std::string> names = vision::ParameterNames(c.camera);
  for (std::size_t i = 0; i < c.free.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(c.free[i])];
    if (name[0] == 'k' || name[0] == 'p') continue;
    outcome.normalised.push_back((found - truth)[c.free[i]] / c.sigma[static_cast<Eigen::Index>(i)]);
  }
  const std::vector<Eigen::Vector2d> places = vision::Corners(trial.board);
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const vision::BoardCorner& corner : views[i].corners) {
      const Eigen::Vector2d& p = places[static_cast<std::size_t>(corner.index)];
      const auto uv = vision::Project(trial.camera, poses[i] * Eigen::Vector3d(p.x(), p.y(), 0));
      if (!uv) continue;
      outcome.corner_error += corner.pixel - *uv;
      outcome.corner_square += (corner.pixel - *uv).squaredNorm();
      ++outcome.corners;
    }
  }
  return outcome;
}

double ShareWithinTwo(const std::vector<double>& normalised) {
  const auto within =
      std::count_if(normalised.begin(), normalised.end(), [](double d) { return std::abs(d) <= 2; });
  return static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(normalised.size(), 1));
}

}  // namespace

void BenchCalibration(std::uint64_t first_seed, std::uint64_t last_seed, int jobs,
                      std::vector<records::Figure>& table) {
  const std::vector<Trial> trials = Trials();
  const std::size_t seeds = static_cast<std::size_t>(std::min<std::uint64_t>(last_seed - first_seed + 1, 5));
  std::vector<Outcome> outcomes(trials.size() * seeds);
  InParallel(outcomes.size(), jobs, "calibration", "trials",
             [&](std::size_t i) { outcomes[i] = Run(trials[i / seeds], first_seed + i % seeds); });

  Outcome all;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    std::vector<double> normalised;
    double worst = 0;
    for (std::size_t s = 0; s < seeds; ++s) {
      const Outcome& o = outcomes[t * seeds + s];
      worst = std::max(worst, o.rms_px);
      normalised.insert(normalised.end(), o.normalised.begin(), o.normalised.end());
      all.corner_error += o.corner_error;
      all.corner_square += o.corner_square;
      all.corners += o.corners;
    }
    all.rms_px = std::max(all.rms_px, worst);
    all.normalised.insert(all.normalised.end(), normalised.begin(), normalised.end());
    table.push_back({trials[t].name + ": residual, worst seed", worst, "px", 0.15, false, "< 0.5"});
    table.push_back({trials[t].name + ": f, centre, xi, RMS error", Rms(normalised), "sigma", {}, false, ""});
  }
  table.push_back(
      {"f, centre, xi, alpha within 2 sigma", ShareWithinTwo(all.normalised), "share", 0.9, true, ""});
  table.push_back({"corners, mean error (bias)", all.corner_error.norm() / std::max(all.corners, 1), "px",
                   0.01, false, ""});
  table.push_back({"corners, RMS error along an axis",
                   std::sqrt(all.corner_square / std::max(2 * all.corners, 1)),
                   "px",
                   {},
                   false,
                   ""});
}

}  // namespace kestrel::bench
