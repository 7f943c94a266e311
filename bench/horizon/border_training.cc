// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/border_training.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/process/in_parallel.h"
#include "bench/horizon/horizon_stills.h"
#include "flight/simulated/scenario.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/camera_mount.h"
#include "vision/horizon/border/border_belief.h"
#include "vision/horizon/border/straight_skyline.h"

namespace kestrel::bench {
namespace {

using Weights = Eigen::Matrix<double, vision::kBorderFeatures, 1>;

constexpr double kRight_deg = 1.5;
constexpr double kRidge = 1;  // of the weights but the first, which has none
constexpr int kFolds = 5;
constexpr double kToneCurves[] = {0.6, 1.6};  // exponents
constexpr int kTrainingLandscapes = 6, kTrainingStills = 12;
constexpr double kPhotographTilt = Radians(90);  // nothing is refused for it

struct TrainingLine {
  Weights features;
  double contrast = 0;
  double error_deg = 0;
};

struct TrainingImage {
  bool photograph = false;
  bool none = false;     // no horizon is in view
  bool as_it_is = true;  // not grey, nor of another tone curve: what answers are counted of
  int group = 0;         // a flight or a landscape, which is left out whole
  std::vector<TrainingLine> lines;
};

std::vector<TrainingLine> LinesOf(const vision::StraightSkyline& skyline, const cv::Mat& image,
                                  const std::optional<Eigen::Vector3d>& down_C) {
  std::vector<TrainingLine> lines;
  for (const vision::LookedAtLine& line : skyline.Lines(image)) {
    const auto features = vision::BorderFeatures(line.look, line.sides);
    lines.push_back({Weights(features.data()), line.look.contrast,
                     down_C ? Degrees(std::acos(std::clamp(line.down_C.dot(*down_C), -1.0, 1.0))) : 180});
  }
  return lines;
}

cv::Mat InGrey(const cv::Mat& image) {
  cv::Mat grey, again;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(grey, again, cv::COLOR_GRAY2BGR);
  return again;
}

cv::Mat WithToneCurve(const cv::Mat& image, double exponent) {
  cv::Mat curve(1, 256, CV_8UC1), toned;
  for (int i = 0; i < 256; ++i)
    curve.at<uchar>(i) = cv::saturate_cast<uchar>(255 * std::pow(i / 255.0, exponent));
  cv::LUT(image, curve, toned);
  return toned;
}

// The image as it is, and as other cameras would have it.
void AddImages(const vision::StraightSkyline& skyline, const cv::Mat& image,
               const std::optional<Eigen::Vector3d>& down_C, bool photograph, int group,
               std::vector<TrainingImage>& all) {
  const auto add = [&](const cv::Mat& seen, bool as_it_is) {
    all.push_back({photograph, !down_C, as_it_is, group, LinesOf(skyline, seen, down_C)});
  };
  add(image, true);
  add(InGrey(image), false);
  if (photograph)
    for (const double exponent : kToneCurves) add(WithToneCurve(image, exponent), false);
}

std::vector<TrainingImage> OfPhotographs(const std::vector<Photograph>& photographs, double fov_deg, int jobs,
                                         int& groups) {
  const Eigen::Matrix3d R_BC = vision::MountPose({.pitch_deg = 90}).R.toRotationMatrix();
  std::map<std::string, int> flights;
  for (const Photograph& p : photographs)
    if (p.labelled && flights.emplace(p.flight, groups).second) ++groups;
  std::vector<std::vector<TrainingImage>> of_each(photographs.size());
  InParallel(photographs.size(), jobs, "training", "photographs", [&](std::size_t k) {
    const Photograph& p = photographs[k];
    const cv::Mat image = p.labelled ? cv::imread(p.file.string(), cv::IMREAD_COLOR) : cv::Mat();
    if (image.empty()) return;
    const vision::Pinhole camera = PhotographCamera(image.size(), fov_deg);
    const vision::StraightSkyline skyline(camera, {}, R_BC.transpose() * Eigen::Vector3d::UnitZ(),
                                          kPhotographTilt);
    std::optional<Eigen::Vector3d> down_C;
    if (!p.none) down_C = LabelledDown(p, camera);
    AddImages(skyline, image, down_C, true, flights.at(p.flight), of_each[k]);
  });
  std::vector<TrainingImage> all;
  for (auto& images : of_each) std::move(images.begin(), images.end(), std::back_inserter(all));
  return all;
}

std::vector<TrainingImage> OfStills(std::uint64_t seed, int jobs, int& groups) {
  const flight::LoadedScenario loaded =
      flight::LoadScenario("attitude_1", {"mount.pitch_deg=90", "camera=thesis_2_8mm"});
  std::vector<StillLandscape> worlds;
  for (const char* world : {"summer_sun", "autumn_clear", "winter_cloudy", "winter_sunset", "open_sea",
                            "banded_sunset", "haze_layer", "city"}) {
    const flight::LoadedScenario there =
        flight::LoadScenario("attitude_1", {std::string("world=") + world, "landscape.seed=1"});
    worlds.push_back({world, there.scenario.landscape.value()});
  }
  const vision::CameraModel& camera = loaded.simulator.camera;
  const Pose X_BC = vision::MountPose(loaded.simulator.mount);
  const cv::Mat forbidden = sim::OwnParts(sim::MakeModel(loaded.simulator.scene, false).get(), camera, X_BC);
  const vision::StraightSkyline skyline(camera, forbidden, X_BC.R.conjugate() * Eigen::Vector3d::UnitZ(),
                                        kPhotographTilt);
  const sim::ImageSensor sensor(loaded.simulator.image, camera, seed);
  const StillSweep sweep = DrawSweep(worlds, kTrainingLandscapes, kTrainingStills, seed);
  std::vector<std::vector<TrainingImage>> of_each(sweep.landscapes.size());
  InParallel(sweep.landscapes.size(), jobs, "training", "landscapes", [&](std::size_t l) {
    StillRenderer renderer(sweep.landscapes[l], loaded.simulator.scene, camera, X_BC);
    for (std::size_t i = l * kTrainingStills; i < (l + 1) * kTrainingStills; ++i) {
      const Pose X_NB = renderer.PoseOf(sweep.stills[i], seed);
      const cv::Mat image = sensor.Expose(renderer.Draw(X_NB), static_cast<std::int64_t>(i));
      const Eigen::Vector3d down_C = (X_NB.R * X_BC.R).conjugate() * Eigen::Vector3d::UnitZ();
      AddImages(skyline, image, down_C, false, groups + static_cast<int>(l), of_each[l]);
    }
  });
  groups += static_cast<int>(sweep.landscapes.size());
  std::vector<TrainingImage> all;
  for (auto& images : of_each) std::move(images.begin(), images.end(), std::back_inserter(all));
  return all;
}

// By Newton's method; photographs and stills teach as much in all, however many there are. without: a fold that teaches nothing; -1: none.
Weights Fit(const std::vector<TrainingImage>& images, int without) {
  constexpr int kSteps = 30;
  std::array<double, 2> lines = {0, 0};
  for (const TrainingImage& image : images)
    if (image.group % kFolds != without) lines[image.photograph] += static_cast<double>(image.lines.size());
  Weights w = Weights::Zero();
  for (int step = 0; step < kSteps; ++step) {
    Weights g = -kRidge * w;
    Eigen::Matrix<double, vision::kBorderFeatures, vision::kBorderFeatures> H;
    H.setZero();
    H.diagonal().setConstant(kRidge);
    g(0) = 0, H(0, 0) = 0;
    for (const TrainingImage& image : images) {
      if (image.group % kFolds == without) continue;
      const double share = (lines[0] + lines[1]) / 2 / lines[image.photograph];
      for (const TrainingLine& line : image.lines) {
        const double p = 1 / (1 + std::exp(-w.dot(line.features)));
        g += share * ((line.error_deg < kRight_deg ? 1 : 0) - p) * line.features;
        H.selfadjointView<Eigen::Lower>().rankUpdate(line.features, share * p * (1 - p));
      }
    }
    const Weights change = H.selfadjointView<Eigen::Lower>().ldlt().solve(g);
    w += change;
    if (change.norm() < 1e-9) break;
  }
  return w;
}

// As StraightSkyline would answer, but that it refuses rivals.
struct Answers {
  int images = 0, over_5 = 0, over_10 = 0, none = 0, none_answered = 0;  // images: with a horizon in view
  std::vector<double> errors_deg;
  void Add(const TrainingImage& image, const Weights& weights) {
    ++(image.none ? none : images);
    double best = vision::kLeastBelief, error_deg = -1;
    for (const TrainingLine& line : image.lines) {
      const double belief = weights.dot(line.features);
      if (line.contrast >= vision::kLeastContrast && belief > best) best = belief, error_deg = line.error_deg;
    }
    if (error_deg < 0) return;
    if (image.none) {
      ++none_answered;
      return;
    }
    errors_deg.push_back(error_deg);
    over_5 += error_deg > 5, over_10 += error_deg > 10;
  }
  void AddTo(std::vector<records::Figure>& table, const std::string& name) const {
    if (images == 0) return;
    const double n = images;
    const auto add = [&](const char* what, double value, const char* unit) {
      table.push_back({"training, " + name + ", " + what, value, unit, {}, false, ""});
    };
    add("answered", static_cast<double>(errors_deg.size()) / n, "share");
    add("off by more than 5 degrees", over_5 / n, "share");
    add("off by more than 10 degrees", over_10 / n, "share");
    if (none > 0) add("answered where no horizon is", none_answered, "images");
    if (errors_deg.empty()) return;
    std::vector<double> sorted = errors_deg;
    std::sort(sorted.begin(), sorted.end());
    add("error, median", sorted[sorted.size() / 2], "deg");
  }
};

}  // namespace

void TrainBorderBelief(const std::vector<Photograph>& photographs, double fov_deg, std::uint64_t seed,
                       int jobs, std::vector<records::Figure>& table) {
  int groups = 0;
  std::vector<TrainingImage> images = OfPhotographs(photographs, fov_deg, jobs, groups);
  std::vector<TrainingImage> stills = OfStills(seed, jobs, groups);
  std::move(stills.begin(), stills.end(), std::back_inserter(images));

  std::array<Weights, kFolds> without;
  for (int k = 0; k < kFolds; ++k) without[static_cast<std::size_t>(k)] = Fit(images, k);
  const auto in_use = vision::BorderWeights();
  for (const bool photograph : {true, false}) {
    Answers left_out, by_those_in_use;
    for (const TrainingImage& image : images) {
      if (image.photograph != photograph || !image.as_it_is) continue;
      left_out.Add(image, without[static_cast<std::size_t>(image.group % kFolds)]);
      by_those_in_use.Add(image, Weights(in_use.data()));
    }
    const std::string kind = photograph ? "photographs" : "stills";
    left_out.AddTo(table, kind + " left out");
    by_those_in_use.AddTo(table, kind + " by the weights in use");
  }
  const Weights w = Fit(images, -1);
  fmt::print("Weights, in the order of BorderFeatures:\n");
  for (int k = 0; k < w.size(); ++k) fmt::print("{:.3f}{}", w(k), k + 1 < w.size() ? ", " : "\n\n");
}

}  // namespace kestrel::bench
