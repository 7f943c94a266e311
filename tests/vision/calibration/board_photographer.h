// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <vector>

#include "geometry/pose.h"
#include "vision/calibration/board/board.h"
#include "vision/camera/camera_model.h"

// Images of a board from known poses, through any camera: every pixel's rays are met with the board's plane,
// so that it owes nothing to a renderer.
namespace kestrel::vision {

// A board before the camera such that a random corner of it is seen at a random pixel, tilted, near or far.
// Of a chessboard all corners are in the image, of tags half.
inline Pose ScatteredPose(const CameraModel& camera, const Board& board, std::mt19937_64& random) {
  const std::vector<Eigen::Vector2d> corners = Corners(board);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const bool chess = IsSeenWholeOnly(board);
  const double width = WidthPx(camera), height = HeightPx(camera);
  const double f = Parameters(camera)[0], size = (corners.back() - corners.front()).norm();
  while (true) {
    const auto ray = Ray(camera, {uniform(0, width - 1), uniform(0, height - 1)});
    const double span = chess ? uniform(0.2, 0.9) : uniform(0.5, 1.6);  // of the board over the image
    const double range = f * size / (std::hypot(width, height) * span);
    const double about = uniform(-std::numbers::pi, std::numbers::pi), tilt = uniform(0, 0.9);
    const double roll = uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Vector2d anchor =
        corners[std::uniform_int_distribution<std::size_t>(0, corners.size() - 1)(random)];
    if (!ray) continue;
    Pose X_CT;
    X_CT.R = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -*ray) *
             ExpRotation(tilt * Eigen::Vector3d(std::cos(about), std::sin(about), 0)) *
             ExpRotation({0, 0, roll});
    X_CT.p = range * *ray - X_CT.R * Eigen::Vector3d(anchor.x(), anchor.y(), 0);
    std::size_t seen = 0;
    for (const Eigen::Vector2d& corner : corners) {
      const Eigen::Vector3d p_CQ = X_CT * Eigen::Vector3d(corner.x(), corner.y(), 0);
      const auto uv = Project(camera, p_CQ);
      const double facing = -(X_CT.R * Eigen::Vector3d::UnitZ()).dot(p_CQ.normalized());
      seen +=
          uv && facing > 0.35 && uv->x() > 6 && uv->y() > 6 && uv->x() < width - 7 && uv->y() < height - 7;
    }
    if (seen == corners.size() || (!chess && 2 * seen > corners.size())) return X_CT;
  }
}

struct Photograph {
  double blur_px = 0.3, noise_grey = 2;
  double white = 220, black = 30;
  double shade_per_px = 0;  // light grows to the right by this share of itself
  int fine = 4;             // samples along each side of a pixel
};

// The mean light over each pixel's square, blurred by the lens, with read noise.
inline cv::Mat PhotographBoard(const CameraModel& camera, const BoardPicture& picture, const Pose& X_CT,
                               std::uint64_t seed, const Photograph& p = {}) {
  const int width = WidthPx(camera), height = HeightPx(camera);
  // From a ray in C to the picture, whose pixels count from its upper left corner here, homogeneous.
  const Pose X_TC = X_CT.Inverse();
  const Eigen::Vector2d px_per_m = Eigen::Vector2d(picture.grey.cols, picture.grey.rows)
                                       .cwiseQuotient(picture.sheet.high - picture.sheet.low);
  Eigen::Matrix3d T_from_ray, picture_from_T;
  T_from_ray << -X_TC.p.z(), 0, X_TC.p.x(), 0, -X_TC.p.z(), X_TC.p.y(), 0, 0, 1;
  picture_from_T << px_per_m.x(), 0, -px_per_m.x() * picture.sheet.low.x(),  //
      0, -px_per_m.y(), px_per_m.y() * picture.sheet.high.y(),               //
      0, 0, 1;
  const Eigen::Matrix3d M = picture_from_T * T_from_ray * X_TC.R.toRotationMatrix();
  // Rays through the corners of pixels; within a pixel they are interpolated.
  std::vector<std::optional<Eigen::Vector3d>> rays;
  for (int v = 0; v <= height; ++v) {
    for (int u = 0; u <= width; ++u) {
      auto ray = Ray(camera, {u - 0.5, v - 0.5});
      if (ray) ray = M * *ray;
      if (ray && !(ray->z() * X_TC.p.z() < 0)) ray.reset();  // never meets the plane
      rays.push_back(ray);
    }
  }
  cv::Mat fine(height * p.fine, width * p.fine, CV_32FC1);
  const auto light = [&](double share, int u) {
    return static_cast<float>((p.black + share * (p.white - p.black)) *
                              (1 + p.shade_per_px * (u - width / 2.0)));
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto* above = &rays[static_cast<std::size_t>(v * (width + 1) + u)];
      const auto* below = above + width + 1;
      const bool all = above[0] && above[1] && below[0] && below[1];
      for (int i = 0; i < p.fine; ++i) {
        for (int j = 0; j < p.fine; ++j) {
          double share = 0.4;  // the wall
          if (all) {
            const double y = (i + 0.5) / p.fine, x = (j + 0.5) / p.fine;
            const Eigen::Vector2d at =
                ((1 - y) * ((1 - x) * *above[0] + x * *above[1]) + y * ((1 - x) * *below[0] + x * *below[1]))
                    .hnormalized();
            if (at.x() >= 0 && at.y() >= 0 && at.x() < picture.grey.cols && at.y() < picture.grey.rows)
              share = picture.grey.at<std::uint8_t>(int(at.y()), int(at.x())) / 255.0;
          }
          fine.at<float>(v * p.fine + i, u * p.fine + j) = light(share, u);
        }
      }
    }
  }
  if (p.blur_px > 0) cv::GaussianBlur(fine, fine, {}, p.blur_px * p.fine);
  cv::Mat image;
  cv::resize(fine, image, {width, height}, 0, 0, cv::INTER_AREA);
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u)
      image.at<float>(v, u) += static_cast<float>(p.noise_grey) * normal(random);
  }
  image.convertTo(image, CV_8U);
  return image;
}

}  // namespace kestrel::vision
