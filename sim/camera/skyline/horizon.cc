// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/skyline/horizon.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/landscape/landscape.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"

namespace kestrel::sim {

HorizonTruth HorizonOf(const Pose& X_NC) {
  HorizonTruth truth;
  truth.up_C = X_NC.R.conjugate() * Eigen::Vector3d(0, 0, -1);
  truth.height_m = std::max(0.0, -X_NC.p.z());
  truth.dip_rad = std::sqrt(2 * truth.height_m / kEarth_m);
  return truth;
}

cv::Mat ClassifySky(const mjModel* model, const Surfaces& surfaces) {
  cv::Mat classes(surfaces.geom.size(), CV_8U);
  for (int v = 0; v < classes.rows; ++v) {
    for (int u = 0; u < classes.cols; ++u) {
      const int geom = surfaces.geom.at<int>(v, u);
      classes.at<unsigned char>(v, u) = geom == -1                                          ? kSky
                                        : geom < 0                                          ? kNeither
                                        : model->body_weldid[model->geom_bodyid[geom]] == 0 ? kGround
                                                                                            : kNeither;
    }
  }
  return classes;
}

cv::Mat OwnParts(const mjModel* model, const vision::CameraModel& camera, const Pose& X_BC) {
  constexpr double kHigh_m = 5000;  // over all that is fixed to the world
  // What light shines through counts too, and See() leaves it out.
  const ModelPtr opaque(mj_copyModel(nullptr, model));
  for (int g = 0; g < opaque->ngeom; ++g) {
    if (opaque->body_weldid[opaque->geom_bodyid[g]] == 0) continue;
    if (opaque->geom_rgba[4 * g + 3] > 0) opaque->geom_rgba[4 * g + 3] = 1;
    if (const int material = opaque->geom_matid[g]; material >= 0) opaque->mat_rgba[4 * material + 3] = 1;
  }
  const DataPtr data(mj_makeData(opaque.get()));
  const Pose X_NB{Eigen::Quaterniond::Identity(), {0, 0, -kHigh_m}};
  const int joint = opaque->body_jntadr[mj_name2id(opaque.get(), mjOBJ_BODY, "vehicle")];
  PoseToMujoco(X_NB, data->qpos + opaque->jnt_qposadr[joint]);
  mj_forward(opaque.get(), data.get());
  RenderOptions by_ray;
  by_ray.backend = "ray";
  by_ray.threads = 1;
  const Surfaces seen = Renderer(opaque.get(), camera, by_ray).Trace(data.get(), X_NB * X_BC);
  cv::Mat own = ClassifySky(opaque.get(), seen) == kNeither;
  cv::dilate(own, own, cv::Mat::ones(5, 5, CV_8U));
  return own;
}

std::vector<SkylinePoint> TrueSkyline(const cv::Mat& classes, const vision::CameraModel& camera,
                                      const Pose& X_NC) {
  std::vector<SkylinePoint> line;
  const auto is_edge = [](int a, int b) { return std::min(a, b) == kGround && std::max(a, b) == kSky; };
  const auto add = [&](double u, double v) {
    const auto ray_C = vision::Ray(camera, Eigen::Vector2d(u, v));
    if (!ray_C) return;
    const Eigen::Vector3d d = (X_NC.R * *ray_C).normalized();
    line.push_back({{u, v}, std::atan2(d.y(), d.x()), std::asin(std::clamp(-d.z(), -1.0, 1.0))});
  };
  for (int v = 0; v < classes.rows; ++v) {
    for (int u = 0; u < classes.cols; ++u) {
      const int here = classes.at<unsigned char>(v, u);
      if (u + 1 < classes.cols && is_edge(here, classes.at<unsigned char>(v, u + 1))) add(u + 0.5, v);
      if (v + 1 < classes.rows && is_edge(here, classes.at<unsigned char>(v + 1, u))) add(u, v + 0.5);
    }
  }
  return line;
}

}  // namespace kestrel::sim
