// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/frame_maker.h"

#include <cmath>
#include <vector>

#include "base/random.h"
#include "sim/world/frames.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::flight {
namespace {

sim::RenderOptions OnOneThread(sim::RenderOptions options) {
  options.threads = 1;  // there is a maker for each core
  return options;
}

}  // namespace

std::uint64_t SeedOf(const FrameMakerParameters& p) {
  return p.number == 0 ? p.seed : RandomStream(p.seed, "camera " + p.camera.name).Bits();
}

FrameMaker::FrameMaker(const mjModel* model, const FrameMakerParameters& parameters,
                       const Trajectory& trajectory, const Extras& extras)
    : model_(model),
      parameters_(parameters),
      trajectory_(trajectory),
      extras_(extras),
      data_(sim::MakeData(model)),
      image_(sim::DrawScatter(parameters.camera.image, SeedOf(parameters))),
      renderer_(model, parameters.camera.camera, OnOneThread(parameters.render)),
      sensor_(image_, parameters.camera.camera, SeedOf(parameters)),
      interpolator_(model, vision::MountPose(parameters.camera.mount),
                    sim::Vibration(parameters.camera.mount.vibration, SeedOf(parameters))),
      boxes_(model) {
  mj_forward(model_, data_.get());
  for (std::size_t i = 0; i < parameters.targets.size(); ++i)
    sim::PlaceTarget(model_, data_.get(), i, sim::TargetPath(parameters.targets[i], parameters.seed, i));
}

sim::Snapshot FrameMaker::SnapshotAt(std::int64_t t_ns) {
  sim::PoseToMujoco(trajectory_.At(t_ns).X_NB, data_->qpos);
  // In s since the beginning: a double of a date holds no ns.
  return sim::SnapshotOf(model_, data_.get(), static_cast<double>(t_ns - trajectory_.begin_ns()) * 1e-9);
}

SetFrame FrameMaker::Make(int index, std::int64_t stamp_ns, std::optional<std::int64_t> next_ns) {
  SetFrame frame{.index = index,
                 .camera = parameters_.number,
                 .stamp_ns = stamp_ns,
                 .image = {},
                 .surfaces = {},
                 .flow = {},
                 .boxes = {}};
  const sim::ExposureParameters& exposure = image_.exposure;
  const sim::ExposureSetting setting{exposure.time_s, parameters_.render.daylight, image_.gain};
  const double readout_s = exposure.line_s * (vision::HeightPx(parameters_.camera.camera) - 1);
  const double half_s = (readout_s + exposure.time_s) / 2;
  std::vector<sim::Snapshot> shots{SnapshotAt(stamp_ns)};
  const double t_s = shots[0].t_s;
  cv::Mat bgr;
  if (half_s > 0) {
    const std::int64_t half_ns = static_cast<std::int64_t>(std::ceil(half_s * 1e9));
    shots.insert(shots.begin(), SnapshotAt(stamp_ns - half_ns));
    shots.front().t_s = t_s - static_cast<double>(half_ns) * 1e-9;
    shots.push_back(SnapshotAt(stamp_ns + half_ns));
    shots.back().t_s = t_s + static_cast<double>(half_ns) * 1e-9;
    const auto states = interpolator_.Of(shots, t_s - half_s, t_s + half_s);
    bgr = renderer_.Render(states, {t_s - readout_s / 2, exposure.time_s, exposure.line_s,
                                    exposure.time_s > 0 ? exposure.samples : 1});
  } else {
    const auto states = interpolator_.Of(shots, t_s, t_s);
    bgr = renderer_.Render(states.front().data, states.front().X_NC);
  }
  frame.image = sensor_.Expose(bgr, index, setting);
  if (!extras_.Surfaces()) return frame;
  std::vector<sim::Snapshot> ends{SnapshotAt(stamp_ns)};
  if (next_ns && extras_.flow) ends.push_back(SnapshotAt(*next_ns));
  const auto states = interpolator_.Of(ends, ends.front().t_s, ends.back().t_s);
  frame.surfaces = renderer_.Trace(states.front().data, states.front().X_NC);
  if (ends.size() > 1) frame.flow = renderer_.Flow(frame.surfaces, states.front(), states.back());
  if (extras_.boxes) frame.boxes = boxes_.Find(frame.surfaces.geom);
  return frame;
}

}  // namespace kestrel::flight
