// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/ray_renderer.h"

#include <fmt/format.h>
#include <hwy/targets.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "sim/render/ray/kernel.h"
#include "sim/render/ray/lens.h"
#include "sim/render/ray/render_scene.h"
#include "sim/render/ray/sky_light.h"
#include "sim/world/frames.h"

namespace kestrel::sim {
namespace {

using ray::Lens;
using ray::RenderScene;
using ray::SceneInstance;
using ray::Slice;

Pose InterpolatePose(const Pose& a, const Pose& b, double share) {
  return {a.R.slerp(share, b.R), a.p + share * (b.p - a.p)};
}

// CV_64FC3: the unit vector through the centre of each pixel; NaN outside the lens.
cv::Mat RaysOf(const vision::CameraModel& camera) {
  cv::Mat rays(vision::HeightPx(camera), vision::WidthPx(camera), CV_64FC3,
               cv::Scalar::all(std::numeric_limits<double>::quiet_NaN()));
  rays.forEach<cv::Vec3d>([&](cv::Vec3d& pixel, const int* at) {
    if (const auto ray = vision::Ray(camera, Eigen::Vector2d(at[1], at[0])))
      pixel = {ray->x(), ray->y(), ray->z()};
  });
  return rays;
}

}  // namespace

// What is kept between pictures.
struct RayRenderer::Stage {
  std::shared_ptr<const Lens> lens;
  RenderScene scene;
  bool shadows = false, sky_light = false;
  int threads = 1;
  SharedLoop own_loop;
  SharedLoop* loop = &own_loop;
  cv::Mat code, common;                       // CV_32S, as in Canvas
  std::vector<SceneInstance> instances;       // one, or one for each row
  std::vector<std::uint64_t> seen;            // of each row of tiles, or of each row
  std::vector<ray::TileTriangles> triangles;  // the same
  std::vector<ray::ScenePose> worlds;         // of the states
  std::vector<cv::Mat> given_out;
  cv::Mat rays;  // as RaysOf(), once they are asked for

  int SeenOfRow() const { return lens->tiles_x * ray::VisibleWords(scene); }

  // Of tiles, or of pixels.
  void SetRows(int rows) {
    seen.resize(static_cast<std::size_t>(rows) * SeenOfRow());
    triangles.resize(static_cast<std::size_t>(rows) * lens->tiles_x);
  }

  Slice SliceOf(int instance, int seen_row) {
    return {lens.get(),
            &scene,
            &instances[instance],
            seen.data() + static_cast<std::ptrdiff_t>(seen_row) * SeenOfRow(),
            triangles.data() + static_cast<std::ptrdiff_t>(seen_row) * lens->tiles_x,
            ray::VisibleWords(scene),
            shadows};
  }

  // An image to draw into: one given out before that nobody holds any more, since its memory is warm; fresh
  // memory costs a page fault for every 4 kB.
  cv::Mat Blank() {
    for (const cv::Mat& old : given_out)
      if (old.u && old.u->refcount == 1) return old;
    if (given_out.size() == 4) given_out.erase(given_out.begin());
    given_out.emplace_back(lens->height, lens->width, CV_8UC3);
    return given_out.back();
  }

  // One sharp picture. fill(row, instance): places world and camera as at the row's instant; if not rolling, it is
  // asked for row 0 alone.
  template <class Fill>
  void Draw(cv::Mat& picture, bool rolling, const Fill& fill) {
    const bool grey = picture.depth() == CV_32F;  // or the bytes of blue, green, red
    const ray::Canvas canvas{grey ? nullptr : picture.data, grey ? picture.ptr<float>() : nullptr,
                             picture.step1(), code.ptr<std::uint32_t>(), common.ptr<std::uint32_t>()};
    instances.resize(rolling ? lens->height : 1);
    SetRows(rolling ? lens->height : lens->tiles_y);
    if (!rolling) fill(0, instances[0]);
    // What is drawn of a row of tiles at once: all of it, or where each row has an instant of its own, one row.
    const auto each_slice = [&](int tile_row, const auto& act) {
      const int begin = tile_row * Lens::kTile, end = std::min(begin + Lens::kTile, lens->height);
      if (!rolling) return act(SliceOf(0, tile_row), begin, end);
      for (int v = begin; v < end; ++v) act(SliceOf(v, v), v, v + 1);
    };
    const auto draw = [&](const Slice& slice, int begin, int end) {
      if (rolling) fill(begin, instances[begin]);
      ray::Cull(slice, begin, end);
      ray::DrawRows(slice, begin, end, canvas);
    };
    const auto finish = [&](const Slice& slice, int begin, int end) {
      ray::SmoothRows(slice, begin, end, canvas);
      if (sky_light) ray::LightRows(slice, begin, end, canvas);
    };
    // Of each row of tiles how many must be drawn before it can be finished: the row and its neighbours. It is
    // finished as soon as they are, while what was listed and drawn is still in the cache.
    std::vector<std::atomic<int>> awaited(static_cast<std::size_t>(lens->tiles_y));
    const auto each_beside = [&](int row, const auto& act) {
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, lens->tiles_y - 1); ++r) act(r);
    };
    for (int row = 0; row < lens->tiles_y; ++row) each_beside(row, [&](int r) { ++awaited[r]; });
    loop->Run(threads, lens->tiles_y, [&](int tile_row) {
      each_slice(tile_row, draw);
      each_beside(tile_row, [&](int row) {
        if (--awaited[row] == 0) each_slice(row, finish);
      });
    });
  }

  void SetLens(const vision::CameraModel& camera) {
    lens = ray::LensOf(camera);
    code = cv::Mat(lens->tiles_y * Lens::kTile, lens->stride, CV_32S, cv::Scalar(0x7fffffff));
    common = cv::Mat(lens->height, lens->tiles_x, CV_32S);
    if (!given_out.empty() && given_out[0].size() != cv::Size(lens->width, lens->height)) given_out.clear();
    rays.release();
  }

  // World and camera at a time between the states.
  void PlaceAt(double t_s, std::span<const SceneState> states, SceneInstance& instance) const {
    std::size_t after = 0;
    while (after < states.size() && states[after].t_s < t_s) ++after;
    if (after == 0 || after == states.size()) {
      const std::size_t i = after == 0 ? 0 : after - 1;
      return ray::InstantiateScene(scene, worlds[i], states[i].X_NC, lens->pixel_rad, instance);
    }
    const SceneState &a = states[after - 1], &b = states[after];
    const double share = (t_s - a.t_s) / (b.t_s - a.t_s);
    ray::InstantiateScene(scene, ray::Interpolate(scene, worlds[after - 1], worlds[after], share),
                          InterpolatePose(a.X_NC, b.X_NC, share), lens->pixel_rad, instance);
  }
};

RayRenderer::RayRenderer(const mjModel* model, const vision::CameraModel& camera,
                         const RenderOptions& options, SharedLoop* shared)
    : camera_(camera), stage_(std::make_unique<Stage>()) {
  if (shared) stage_->loop = shared;
  stage_->SetLens(camera);
  stage_->sky_light = options.light == "sky";
  stage_->shadows = options.shadows && !stage_->sky_light;
  stage_->scene = ray::CompileScene(model, stage_->sky_light || stage_->shadows);
  stage_->threads = options.threads > 0 ? options.threads
                                        : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  name_ = fmt::format("ray renderer ({})", ray::InstructionSet());
}

RayRenderer::~RayRenderer() = default;

void RayRenderer::SetCamera(const vision::CameraModel& camera) {
  camera_ = camera;
  stage_->SetLens(camera);
}

cv::Mat RayRenderer::Render(const mjData* data, const Pose& X_NC) {
  const ray::ScenePose world = ray::PoseOfScene(stage_->scene, data);
  cv::Mat bgr = stage_->Blank();
  stage_->Draw(bgr, false, [&](int, SceneInstance& instance) {
    ray::InstantiateScene(stage_->scene, world, X_NC, stage_->lens->pixel_rad, instance);
  });
  return bgr;
}

cv::Mat RayRenderer::Render(std::span<const SceneState> states, const Shutter& shutter) {
  if (states.empty()) throw std::runtime_error("A picture needs at least one instant of the world.");
  stage_->worlds.clear();
  for (const SceneState& i : states) stage_->worlds.push_back(ray::PoseOfScene(stage_->scene, i.data));
  const bool rolling = shutter.line_s != 0;
  const int samples = std::max(1, shutter.samples);
  cv::Mat sum, bgr = stage_->Blank();
  for (int k = 0; k < samples; ++k) {
    const double offset_s = shutter.exposure_s * ((k + 0.5) / samples - 0.5);
    stage_->Draw(bgr, rolling, [&](int row, SceneInstance& instance) {
      stage_->PlaceAt(shutter.row_0_s + row * shutter.line_s + offset_s, states, instance);
    });
    if (samples == 1) return bgr;
    if (k == 0) sum = cv::Mat::zeros(bgr.size(), CV_32SC3);
    cv::add(sum, bgr, sum, cv::noArray(), CV_32S);
  }
  sum.convertTo(bgr, CV_8U, 1.0 / samples);
  return bgr;
}

cv::Mat RayRenderer::RenderGrey(std::span<const SceneState> states, double t_s) {
  if (states.empty()) throw std::runtime_error("A picture needs at least one instant of the world.");
  stage_->worlds.clear();
  for (const SceneState& i : states) stage_->worlds.push_back(ray::PoseOfScene(stage_->scene, i.data));
  cv::Mat grey(stage_->lens->height, stage_->lens->width, CV_32FC1);
  stage_->Draw(grey, false, [&](int, SceneInstance& instance) { stage_->PlaceAt(t_s, states, instance); });
  return grey;
}

Surfaces RayRenderer::Trace(const mjData* data, const Pose& X_NC) {
  Stage& s = *stage_;
  const ray::ScenePose world = ray::PoseOfScene(s.scene, data);
  s.instances.resize(1);
  s.SetRows(s.lens->tiles_y);
  ray::InstantiateScene(s.scene, world, X_NC, s.lens->pixel_rad, s.instances[0]);
  Surfaces surfaces{cv::Mat(s.lens->height, s.lens->width, CV_32F),
                    cv::Mat(s.lens->height, s.lens->width, CV_32S)};
  s.loop->Run(s.threads, s.lens->tiles_y, [&](int tile_row) {
    const Slice slice = s.SliceOf(0, tile_row);
    const int begin = tile_row * Lens::kTile, end = std::min(begin + Lens::kTile, s.lens->height);
    ray::Cull(slice, begin, end);
    ray::TraceRows(slice, begin, end, surfaces.depth_m.ptr<float>(), surfaces.geom.ptr<std::int32_t>(),
                   surfaces.depth_m.step1());
  });
  return surfaces;
}

cv::Mat RayRenderer::Flow(const Surfaces& seen_now, const SceneState& now, const SceneState& next) {
  const ray::ScenePose before = ray::PoseOfScene(stage_->scene, now.data),
                       after = ray::PoseOfScene(stage_->scene, next.data);
  // X of C at the next instant from C now, for the points of each geom; -1: the sky, which only turns.
  const auto pose_M = [](const Pose& X_NC) {
    Eigen::Matrix3d R;
    for (int k = 0; k < 3; ++k) R.col(k) = SwapNedNwu(X_NC.R * Eigen::Vector3d::Unit(k));
    return Pose{Eigen::Quaterniond(R), SwapNedNwu(X_NC.p)};
  };
  const Pose X_MC = pose_M(now.X_NC), X_CM_next = pose_M(next.X_NC).Inverse();
  struct Move {
    Eigen::Matrix3d R;
    Eigen::Vector3d p;
  };
  const auto move_of = [](const Pose& X) { return Move{X.R.toRotationMatrix(), X.p}; };
  std::vector<Move> moves;  // by the id of the geom
  for (std::size_t i = 0; i < stage_->scene.all.size(); ++i) {
    const Pose X_MG{before.R[i], before.p[i]}, X_MG_next{after.R[i], after.p[i]};
    const auto geom = static_cast<std::size_t>(stage_->scene.all[i].geom);
    if (geom >= moves.size()) moves.resize(geom + 1);
    moves[geom] = move_of(X_CM_next * X_MG_next * X_MG.Inverse() * X_MC);
  }
  const Eigen::Matrix3d turn = (X_CM_next * X_MC).R.toRotationMatrix();
  if (stage_->rays.empty()) stage_->rays = RaysOf(camera_);
  cv::Mat flow(seen_now.geom.size(), CV_32FC2, cv::Scalar::all(std::numeric_limits<float>::quiet_NaN()));
  std::visit(  // once, and not for each pixel
      [&](const auto& camera) {
        stage_->loop->Run(stage_->threads, flow.rows, [&](int v) {
          const auto* rays = stage_->rays.ptr<cv::Vec3d>(v);
          const int* geoms = seen_now.geom.ptr<int>(v);
          const float* depths_m = seen_now.depth_m.ptr<float>(v);
          auto* flows = flow.ptr<cv::Vec2f>(v);
          for (int u = 0; u < flow.cols; ++u) {
            if (geoms[u] == -2 || std::isnan(rays[u][0])) continue;
            const Eigen::Vector3d ray_C(rays[u].val);
            Eigen::Vector3d moved;
            if (geoms[u] < 0) {
              moved = turn * ray_C;
            } else {
              const Move& move = moves[static_cast<std::size_t>(geoms[u])];
              moved = move.R * (depths_m[u] * ray_C) + move.p;
            }
            if (const auto to = camera.Project(moved))
              flows[u] = cv::Vec2f(static_cast<float>(to->x() - u), static_cast<float>(to->y() - v));
          }
        });
      },
      camera_);
  return flow;
}

}  // namespace kestrel::sim
