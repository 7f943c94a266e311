// SPDX-License-Identifier: Apache-2.0
#include "bench/render/agreement.h"

#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "base/statistics.h"
#include "bench/render/drawer.h"
#include "sim/camera/renderer.h"

namespace kestrel::bench {
namespace {

// Rays of the reference, along each side of a pixel. Each has a 64th of a pixel's footprint, for which little of its
// filter for textures is left, except towards the horizon, where a pixel is hundreds of texels long.
constexpr int kRays = 8;

// The same lens with so many pixels along each side of one.
vision::CameraModel Finer(const vision::CameraModel& camera, int times) {
  return std::visit(
      [&](auto model) -> vision::CameraModel {
        if constexpr (requires { model.fx; }) {
          model.width_px *= times, model.height_px *= times;
          model.fx *= times, model.fy *= times;
          model.cx = times * model.cx + (times - 1) / 2.0, model.cy = times * model.cy + (times - 1) / 2.0;
          return model;
        } else {
          throw std::runtime_error("A camera of the benchmark of rendering has no focal length.");
        }
      },
      camera);
}

// Pixels with no edge of a thing within two of them.
cv::Mat AwayFromEdges(const sim::Surfaces& seen) {
  cv::Mat geom, low, high;
  seen.geom.convertTo(geom, CV_32F);
  const cv::Mat around = cv::Mat::ones(5, 5, CV_8U);
  cv::erode(geom, low, around);
  cv::dilate(geom, high, around);
  return (low == high) & (geom > -2);
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  const cv::Scalar mean = cv::mean(difference, mask);
  return (mean[0] + mean[1] + mean[2]) / 3;
}

}  // namespace

void BenchAgreement(const BenchCamera& bench, World& world, const sim::RenderOptions& by_opengl,
                    std::uint64_t first_seed, std::uint64_t last_seed, std::vector<records::Figure>& table) {
  const sim::RenderOptions by_ray{.backend = "ray"};
  Drawer<sim::Renderer> ray(world.model(), bench.camera, by_ray),
      fine(world.model(), Finer(bench.camera, kRays), by_ray), opengl(world.model(), bench.camera, by_opengl);
  std::vector<double> between, ray_off, opengl_off;
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed) {
    for (const Height height : kHeights) {
      const Pose X_NC = world.Put(AircraftPose(bench, height, seed));
      const cv::Mat mask =
          AwayFromEdges(ray.Trace(world.data(), X_NC)) & AwayFromEdges(opengl.Trace(world.data(), X_NC));
      const cv::Mat by_rays = ray.Render(world.data(), X_NC), drawn = opengl.Render(world.data(), X_NC);
      cv::Mat reference;
      cv::resize(fine.Render(world.data(), X_NC), reference, by_rays.size(), 0, 0, cv::INTER_AREA);
      between.push_back(MeanDifference(by_rays, drawn, mask));
      ray_off.push_back(MeanDifference(by_rays, reference, mask));
      opengl_off.push_back(MeanDifference(drawn, reference, mask));
    }
  }
  const auto add = [&](const std::string& what, double value, std::optional<double> target) {
    table.push_back({bench.name + ", " + what, value, "grey levels", target, false, ""});
  };
  add("ray and OpenGL differ away from edges, mean", Mean(between), 2);
  add("the same, the worst image", Quantile(between, 1), 2);
  for (const auto& [name, off] : {std::pair("ray", &ray_off), std::pair("OpenGL", &opengl_off)}) {
    add(std::string(name) + " from 8 x 8 rays a pixel, mean", Mean(*off), {});
    add(std::string(name) + " from 8 x 8 rays a pixel, the worst image", Quantile(*off, 1), {});
  }
}

}  // namespace kestrel::bench
