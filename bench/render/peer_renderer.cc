// SPDX-License-Identifier: Apache-2.0
#include "bench/render/peer_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "sim/world/frames.h"

namespace kestrel::bench {
namespace {

constexpr double kNear_m = 0.02, kFar_m = 500;

std::vector<Eigen::Quaterniond> CubeFaces() {
  std::vector<Eigen::Quaterniond> R_CV;
  for (const double quarters : {0, 1, 2, 3})
    R_CV.emplace_back(Eigen::AngleAxisd(quarters * std::numbers::pi / 2, Eigen::Vector3d::UnitY()));
  for (const double quarters : {1, -1})
    R_CV.emplace_back(Eigen::AngleAxisd(quarters * std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  return R_CV;
}

std::size_t FaceOf(const std::vector<Eigen::Quaterniond>& R_CV, const Eigen::Vector3d& ray) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < R_CV.size(); ++k)
    if ((R_CV[k].conjugate() * ray).z() > (R_CV[best].conjugate() * ray).z()) best = k;
  return best;
}

// In faces of this side no pixel in the middle of one is larger than half of one of the lens's there.
int SideFor(const vision::CameraModel& camera, const std::vector<Eigen::Quaterniond>& R_CV) {
  double side = 0;
  for (const Eigen::Quaterniond& R : R_CV) {
    const auto uv = vision::Project(camera, R * Eigen::Vector3d::UnitZ());
    Eigen::Matrix<double, 3, 2> d_pixel;
    if (!uv || uv->x() < 0 || uv->y() < 0 || uv->x() > vision::WidthPx(camera) - 1 ||
        uv->y() > vision::HeightPx(camera) - 1 || !vision::Ray(camera, *uv, &d_pixel))
      continue;
    side = std::max(side, 4 / std::sqrt(d_pixel.col(0).cross(d_pixel.col(1)).norm()));
  }
  if (!(side > 0)) throw std::runtime_error("The lens sees no face of a cube in its middle.");
  return static_cast<int>(std::lround(side));
}

}  // namespace

PeerRenderer::PeerRenderer(const mjModel* model, const vision::CameraModel& camera,
                           const std::string& backend, int samples, double finer)
    : model_(model) {
  const vision::Pinhole* const pinhole = std::get_if<vision::Pinhole>(&camera);
  if (pinhole) {
    picture_ = *pinhole;
    R_CV_ = {Eigen::Quaterniond::Identity()};
  } else {
    const std::vector<Eigen::Quaterniond> cube = CubeFaces();
    face_px_ = static_cast<int>(SideFor(camera, cube) * finer);
    const double middle = (face_px_ - 1) / 2.0;
    picture_ = {face_px_, face_px_, face_px_ / 2.0, face_px_ / 2.0, middle, middle};
    std::array<bool, 6> used{};
    for (int v = 0; v < vision::HeightPx(camera); ++v)
      for (int u = 0; u < vision::WidthPx(camera); ++u)
        if (const auto ray = vision::Ray(camera, Eigen::Vector2d(u, v))) used[FaceOf(cube, *ray)] = true;
    for (std::size_t k = 0; k < cube.size(); ++k)
      if (used[k]) R_CV_.push_back(cube[k]);
    cv::Mat table(vision::HeightPx(camera), vision::WidthPx(camera), CV_32FC2,
                  cv::Scalar::all(-10));  // there is nothing
    for (int v = 0; v < table.rows; ++v) {
      for (int u = 0; u < table.cols; ++u) {
        const auto ray = vision::Ray(camera, Eigen::Vector2d(u, v));
        if (!ray) continue;
        const std::size_t k = FaceOf(R_CV_, *ray);
        const Eigen::Vector2d at = *picture_.Project(R_CV_[k].conjugate() * *ray);
        const double top = static_cast<double>(k * static_cast<std::size_t>(face_px_));
        table.at<cv::Vec2f>(v, u) = {
            static_cast<float>(std::clamp(at.x(), 0.0, face_px_ - 1.0)),
            static_cast<float>(top + std::clamp(face_px_ - 1 - at.y(), 0.0, face_px_ - 1.0))};
      }
    }
    cv::convertMaps(table, cv::Mat(), table_, table_fraction_, CV_16SC2);
  }

  context_ = sim::MakeGlContext(backend);
  mjv_defaultOption(&visible_);
  mjModel shown = *model;
  shown.vis.global.offwidth = picture_.width_px;
  shown.vis.global.offheight = picture_.height_px;
  shown.vis.quality.offsamples = samples;
  shown.vis.quality.shadowsize = 0;
  mjr_defaultContext(&gpu_);
  mjr_makeContext(&shown, &gpu_, mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &gpu_);
  mjv_defaultScene(&scene_);
  mjv_makeScene(model, &scene_, 2000);
  scene_.flags[mjRND_SHADOW] = 0;
  pictures_.create(static_cast<int>(R_CV_.size()) * picture_.height_px, picture_.width_px, CV_8UC3);
}

PeerRenderer::~PeerRenderer() {
  mjv_freeScene(&scene_);
  mjr_freeContext(&gpu_);
}

cv::Mat PeerRenderer::Render(const mjData* data, const Pose& X_NC) {
  mjvCamera by_hand;
  mjv_defaultCamera(&by_hand);
  mjv_updateScene(model_, const_cast<mjData*>(data), &visible_, nullptr, &by_hand, mjCAT_ALL, &scene_);
  const mjrRect whole{0, 0, picture_.width_px, picture_.height_px};
  for (std::size_t k = 0; k < R_CV_.size(); ++k) {
    const Eigen::Matrix3d R_NV = (X_NC.R * R_CV_[k]).toRotationMatrix();
    const Eigen::Vector3d p_M = sim::SwapNedNwu(X_NC.p),
                          forward_M = sim::SwapNedNwu(Eigen::Vector3d(R_NV.col(2))),
                          up_M = sim::SwapNedNwu(Eigen::Vector3d(-R_NV.col(1)));
    mjvGLCamera eye{};
    for (int i = 0; i < 3; ++i) {
      eye.pos[i] = static_cast<float>(p_M[i]);
      eye.forward[i] = static_cast<float>(forward_M[i]);
      eye.up[i] = static_cast<float>(up_M[i]);
    }
    eye.frustum_near = static_cast<float>(kNear_m);
    eye.frustum_far = static_cast<float>(kFar_m);
    eye.frustum_top = static_cast<float>(kNear_m * (picture_.cy + 0.5) / picture_.fy);
    eye.frustum_bottom = static_cast<float>(kNear_m * (picture_.cy + 0.5 - picture_.height_px) / picture_.fy);
    scene_.camera[0] = scene_.camera[1] = eye;
    mjr_render(whole, &scene_, &gpu_);
    mjr_readPixels(pictures_.ptr(static_cast<int>(k) * picture_.height_px), nullptr, whole, &gpu_);
  }
  cv::Mat image;
  if (face_px_ == 0) {
    cv::flip(pictures_, image, 0);
  } else {
    cv::remap(pictures_, image, table_, table_fraction_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  }
  return image;
}

}  // namespace kestrel::bench
