// SPDX-License-Identifier: Apache-2.0
#include "bench/limits/frame_stages.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "bench/timings/timed_scene.h"
#include "sim/render/ray/kernel.h"
#include "sim/world/frames.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::bench {
namespace {

using sim::ray::Lens;

template <class Work>
double Taken_ms(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// As the kernel takes them: a neighbour shows something else, and is in the lens.
double EdgesOf(const cv::Mat& code, const Lens& lens) {
  constexpr std::uint32_t kWithoutTopBit = 0x7fffffff, kTopBit = 0x80000000, kOutside = 0x7fffffff;
  double edges = 0;
  for (int v = 0; v < lens.height; ++v)
    for (int u = 0; u < lens.width; ++u) {
      const auto at = [&](int row, int column) {
        row = std::clamp(row, 0, lens.height - 1), column = std::clamp(column, 0, lens.width - 1);
        return static_cast<std::uint32_t>(code.at<std::int32_t>(row, column));
      };
      const std::uint32_t own = at(v, u) & kWithoutTopBit;
      if (own == kOutside) continue;
      bool edge = at(v, u) & kTopBit;
      for (const auto& [down, right] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const std::uint32_t other = at(v + down, u + right) & kWithoutTopBit;
        edge = edge || (other != own && other != kOutside);
      }
      edges += edge;
    }
  return edges;
}

}  // namespace

StagedRenderer::StagedRenderer(const std::string& scenario, const vision::CameraModel& camera)
    : loaded_(flight::LoadScenario(scenario)),
      X_BC_(vision::MountPose(loaded_.simulator.mount)),
      model_(sim::MakeModel(loaded_.simulator.scene)),
      data_(sim::MakeData(model_.get())),
      lens_(sim::ray::LensOf(camera)),
      scene_(sim::ray::CompileScene(model_.get(), false)) {}

StagedFrame StagedRenderer::Draw(const Pose& X_NB) {
  const Lens& lens = *lens_;
  const int joint = model_->body_jntadr[mj_name2id(model_.get(), mjOBJ_BODY, "vehicle")];
  sim::PoseToMujoco(X_NB, data_->qpos + model_->jnt_qposadr[joint]);
  mj_forward(model_.get(), data_.get());

  StagedFrame frame;
  sim::ray::SceneInstance placed;
  frame.stages.set_up_ms = Taken_ms([&] {
    sim::ray::InstantiateScene(scene_, sim::ray::PoseOfScene(scene_, data_.get()), X_NB * X_BC_,
                               lens.pixel_rad, placed);
  });
  const int words = sim::ray::VisibleWords(scene_);
  std::vector<std::uint64_t> visible(static_cast<std::size_t>(lens.tiles_y) * lens.tiles_x * words);
  std::vector<sim::ray::TileTriangles> triangles(static_cast<std::size_t>(lens.tiles_y) * lens.tiles_x);
  // Written once before, so that its memory is there, as that of a flight's images is.
  cv::Mat bgr(lens.height, lens.width, CV_8UC3, cv::Scalar::all(0)),
      common(lens.height, lens.tiles_x, CV_32S, cv::Scalar(0));
  cv::Mat code(lens.tiles_y * Lens::kTile, lens.stride, CV_32S, cv::Scalar(0x7fffffff));
  const sim::ray::Canvas canvas{bgr.data, nullptr, bgr.step1(), code.ptr<std::uint32_t>(),
                                common.ptr<std::uint32_t>()};
  const auto rows = [&](const auto& act) {
    return Taken_ms([&] {
      for (int row = 0; row < lens.tiles_y; ++row) {
        const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(row) * lens.tiles_x;
        const sim::ray::Slice slice{
            &lens, &scene_, &placed, visible.data() + first * words, triangles.data() + first, words, false};
        const int begin = row * Lens::kTile;
        act(slice, begin, std::min(begin + Lens::kTile, lens.height));
      }
    });
  };
  using sim::ray::Slice;
  const auto list = [](const Slice& slice, int begin, int end) { sim::ray::Cull(slice, begin, end); };
  rows(list);  // so that the lists have their memory, as they have from the second frame of a flight on
  frame.stages.list_ms = rows(list);
  frame.stages.rays_ms =
      rows([&](const Slice& slice, int begin, int end) { sim::ray::DrawRows(slice, begin, end, canvas); });
  frame.stages.edges_ms =
      rows([&](const Slice& slice, int begin, int end) { sim::ray::SmoothRows(slice, begin, end, canvas); });
  cv::Mat depth_m(lens.height, lens.width, CV_32F), geom(lens.height, lens.width, CV_32S);
  rows([&](const Slice& slice, int begin, int end) {
    sim::ray::TraceRows(slice, begin, end, depth_m.ptr<float>(), geom.ptr<std::int32_t>(), depth_m.step1());
  });

  std::vector<bool> textured(static_cast<std::size_t>(model_->ngeom));
  for (const sim::ray::Geom& thing : scene_.all)
    if (thing.geom >= 0) textured[static_cast<std::size_t>(thing.geom)] = thing.texture != nullptr;
  for (int v = 0; v < lens.height; ++v)
    for (int u = 0; u < lens.width; ++u) {
      const int seen = geom.at<std::int32_t>(v, u);
      if (seen == -2) continue;
      ++frame.content.pixels;
      frame.content.textured += seen == -1 ? scene_.sky != nullptr : textured[static_cast<std::size_t>(seen)];
    }
  frame.content.at_edges = EdgesOf(code, lens);
  frame.picture = bgr;
  return frame;
}

StagedFrame MeanFrame(StagedRenderer& renderer, double height_m, int frames) {
  constexpr int kTries = 5;
  constexpr std::array kParts = {&FrameStages::set_up_ms, &FrameStages::list_ms, &FrameStages::rays_ms,
                                 &FrameStages::edges_ms};
  constexpr std::array kCounts = {&FrameContent::pixels, &FrameContent::textured, &FrameContent::at_edges};
  StagedFrame mean;
  for (int i = 0; i < frames; ++i) {
    StagedFrame best = renderer.Draw(PathPose(height_m, i));
    for (int k = 1; k < kTries; ++k) {
      const FrameStages now = renderer.Draw(PathPose(height_m, i)).stages;
      for (const auto part : kParts) best.stages.*part = std::min(best.stages.*part, now.*part);
    }
    for (const auto part : kParts) mean.stages.*part += best.stages.*part / frames;
    for (const auto count : kCounts) mean.content.*count += best.content.*count / frames;
  }
  return mean;
}

}  // namespace kestrel::bench
