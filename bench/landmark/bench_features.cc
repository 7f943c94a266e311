// SPDX-License-Identifier: Apache-2.0
#include "bench/landmark/bench_features.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/file/model_files.h"
#include "base/random.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "bench/named_camera.h"
#include "geometry/tait_bryan.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/world/scene.h"
#include "vision/landmark/pad_features.h"
#include "vision/landmark/pad_file.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::bench {
namespace {

constexpr int kPartial = 40, kEmpty = 20;
constexpr double kFound_px = 5;              // a mean error up to which the pad counts as found
constexpr double kLeast = 0.2, kMost = 0.8;  // share of the pad that is in view

struct View {
  cv::Mat grey;
  std::vector<Eigen::Vector2d> in_view;  // points of the pad, T, m
  Eigen::Matrix3d H;                     // from T to the image
};

// Points all over the pad that lie in the image.
std::vector<Eigen::Vector2d> InView(const Eigen::Matrix3d& H, const vision::PadReference& pad,
                                    const cv::Size& size) {
  std::vector<Eigen::Vector2d> seen;
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector2d point(pad.length_m * ((i + 0.5) / 20 - 0.5),
                                  pad.width_m * ((k + 0.5) / 20 - 0.5));
      const Eigen::Vector2d uv = vision::Transfer(H, point);
      if (uv.x() >= 0 && uv.y() >= 0 && uv.x() <= size.width - 1 && uv.y() <= size.height - 1)
        seen.push_back(point);
    }
  }
  return seen;
}

// An aircraft that hovers at 1.5 to 6 m, tilted by up to some 12 degrees, with the pad at any place of the image.
Pose DrawnPose(RandomStream& random, const vision::Pinhole& camera, bool away) {
  const double height = random.Uniform(1.5, 6), yaw = random.Uniform(-M_PI, M_PI);
  const double tilt_x = random.Uniform(-0.15, 0.15), tilt_y = random.Uniform(-0.15, 0.15);
  const double u = random.Uniform(-0.1, 1.1) * camera.width_px,
               v = random.Uniform(-0.1, 1.1) * camera.height_px;
  const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
  return {ExpRotation({tilt_x, tilt_y, 0}) * HeadingRotation(yaw),
          height * ray + Eigen::Vector3d(away ? 30 : 0, 0, 0)};
}

vision::PadFile Helipad() {
  Mistakes mistakes;
  vision::PadFile file = vision::LoadPad(Root() / "models" / "pads" / "helipad" / "helipad.yaml", mistakes);
  mistakes.ThrowIfAny();
  return file;
}

sim::ModelPtr Airfield(const vision::PadFile& file) {
  sim::SceneParameters scene;
  scene.world = Root() / "models" / "worlds" / "airfield" / "airfield.xml";
  scene.vehicle = Root() / "models" / "targets" / "balloon.xml";
  scene.pad_texture = file.texture;
  scene.pad = file.parameters;
  return sim::MakeModel(scene);
}

// Of one seed: those with a part of the pad first.
std::vector<View> Views(const mjModel* model, const vision::PadReference& pad, const vision::Pinhole& camera,
                        std::uint64_t seed) {
  const sim::DataPtr data = sim::MakeData(model);
  for (int i = 0; i < model->nmocap; ++i) data->mocap_pos[3 * i] += 500;  // out of sight
  mj_forward(model, data.get());
  const Pose X_NT = sim::PadPose(model, data.get());
  sim::Renderer renderer(model, camera, {.backend = "ray"});
  const sim::ImageSensor sensor({}, camera, seed);
  RandomStream random(seed, "bench features");
  std::vector<View> views;
  while (static_cast<int>(views.size()) < kPartial + kEmpty) {
    const bool away = static_cast<int>(views.size()) >= kPartial;
    const Pose X_CT = DrawnPose(random, camera, away);
    View view{.grey = {}, .in_view = {}, .H = vision::HomographyFromPose(X_CT, camera)};
    if (!away) view.in_view = InView(view.H, pad, {camera.width_px, camera.height_px});
    const double share = static_cast<double>(view.in_view.size()) / 400;
    if (!away && (share < kLeast || share > kMost)) continue;
    view.grey =
        sensor.Expose(renderer.Render(data.get(), X_NT * X_CT.Inverse()), static_cast<int>(views.size()));
    if (view.grey.channels() == 3) cv::cvtColor(view.grey, view.grey, cv::COLOR_BGR2GRAY);
    views.push_back(view);
  }
  return views;
}

double MeanError(const Eigen::Matrix3d& H, const View& view) {
  double sum = 0;
  for (const Eigen::Vector2d& point : view.in_view)
    sum += (vision::Transfer(H, point) - vision::Transfer(view.H, point)).norm();
  return sum / static_cast<double>(view.in_view.size());
}

struct Score {
  std::vector<double> error_px, ms;
  int found = 0, partial = 0, imagined = 0, empty = 0;
};

}  // namespace

void BenchFeatures(std::uint64_t first_seed, std::uint64_t last_seed, std::vector<records::Figure>& table) {
  last_seed = std::min(last_seed, first_seed + 4);
  const auto camera = std::get<vision::Pinhole>(NamedCamera("thesis_6mm"));
  const vision::PadFile file = Helipad();
  const vision::PadReference& pad = file.reference;
  const sim::ModelPtr model = Airfield(file);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  std::vector<View> views;
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed)
    for (View& view : Views(model.get(), pad, camera, seed)) views.push_back(std::move(view));
  fmt::print("| {:<8} | found % | error px 50 % 95 % | imagined % | ms mean  99 % |\n", "features");
  for (const std::string& name : vision::FeatureDetectorNames()) {
    const vision::FeatureDetector detector = *vision::FeatureDetectorNamed(name);
    if (!vision::IsAvailable(detector)) continue;
    const vision::PadFeatures features(pad, camera, detector);
    Score score;
    for (const View& view : views) {
      const double start_ms = ThreadCpu_ms();
      const auto H = features.Find(view.grey, 1);
      score.ms.push_back(ThreadCpu_ms() - start_ms);
      if (view.in_view.empty()) {
        ++score.empty, score.imagined += H.has_value();
        continue;
      }
      ++score.partial;
      const double error = H ? MeanError(*H, view) : INFINITY;
      if (!(error < kFound_px)) continue;
      ++score.found, score.error_px.push_back(error);
    }
    const double found = static_cast<double>(score.found) / std::max(1, score.partial);
    fmt::print("| {:<8} | {:7.1f} | {:8.2f} {:9.2f} | {:10.1f} | {:7.1f} {:5.1f} |\n", name, 100 * found,
               Quantile(score.error_px, 0.5), Quantile(score.error_px, 0.95),
               100.0 * score.imagined / std::max(1, score.empty), Mean(score.ms), Quantile(score.ms, 0.99));
    const std::string figure = "pad partly in view, " + name;
    table.push_back({figure + ": found", found, "share", {}, true, ""});
    table.push_back({figure + ": error, median", Quantile(score.error_px, 0.5), "px", {}, false, ""});
    table.push_back({figure + ": time, mean an image", Mean(score.ms), "ms", 25, false, ""});
  }
  fmt::print("\n");
  cv::setNumThreads(threads);
}

}  // namespace kestrel::bench
