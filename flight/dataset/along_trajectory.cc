// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/along_trajectory.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "base/process/in_parallel.h"
#include "base/random.h"
#include "flight/dataset/frame_maker.h"
#include "sim/instrument/instrument_noise.h"

namespace kestrel::flight {
namespace {

// The k-th stamp of a clock, reckoned from k each time, so that nothing adds up.
std::vector<std::int64_t> StampsUntil(std::int64_t begin_ns, std::int64_t end_ns, double phase_s,
                                      double rate_hz) {
  std::vector<std::int64_t> stamps;
  for (std::size_t k = 0;; ++k) {
    const std::int64_t t =
        begin_ns + std::llround(phase_s * 1e9) + std::llround(static_cast<double>(k) * 1e9 / rate_hz);
    if (t > end_ns) return stamps;
    stamps.push_back(t);
  }
}

// Makers of frames that nobody uses now: as many as there are threads, each made when it is first needed.
class Makers {
 public:
  template <class Make>
  std::unique_ptr<FrameMaker> Take(const Make& make) {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<FrameMaker> maker = std::move(idle_.back());
        idle_.pop_back();
        return maker;
      }
    }
    return make();
  }
  void Give(std::unique_ptr<FrameMaker> maker) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(maker));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<FrameMaker>> idle_;
};

std::vector<FrameMakerParameters> CamerasOf(const sim::SimulatorParameters& p) {
  std::vector<FrameMakerParameters> all{
      {0, {"", p.camera, p.mount, p.image, {}}, p.render, p.targets, p.seed}};
  for (const sim::CarriedCameraParameters& camera : p.cameras)
    all.push_back({all.size(), camera, p.render, p.targets, p.seed});
  return all;
}

// The acceleration of the IMU where it is on the body, and what it measures of that.
Eigen::Vector3d SpecificForce_I(const Trajectory& trajectory, std::int64_t t_ns, const Motion& motion,
                                const Pose& X_BI) {
  Eigen::Vector3d force_B = motion.SpecificForce_B();
  if (!X_BI.p.isZero()) {
    constexpr std::int64_t kHalf_ns = 100'000;
    const std::int64_t before = std::max(t_ns - kHalf_ns, trajectory.begin_ns());
    const std::int64_t after = std::min(t_ns + kHalf_ns, trajectory.end_ns());
    const Eigen::Vector3d w_rate_B =
        (trajectory.At(after).w_B - trajectory.At(before).w_B) / (1e-9 * static_cast<double>(after - before));
    force_B += w_rate_B.cross(X_BI.p) + motion.w_B.cross(motion.w_B.cross(X_BI.p));
  }
  return X_BI.R.conjugate() * force_B;
}

void AddImu(const Trajectory& trajectory, std::int64_t end_ns, std::uint64_t seed, Sequence& s) {
  const sim::ImuParameters& p = s.imu_parameters;
  RandomStream random(seed, "trajectory imu");
  sim::InertialNoise gyroscope(p.gyroscope_noise_density, p.gyroscope_random_walk, p.gyroscope_turn_on_rad_s,
                               p.rate_hz, random);
  sim::InertialNoise accelerometer(p.accelerometer_noise_density, p.accelerometer_random_walk,
                                   p.accelerometer_turn_on_m_s2, p.rate_hz, random);
  for (const std::int64_t t : StampsUntil(trajectory.begin_ns(), end_ns, p.phase_s, p.rate_hz)) {
    const Motion motion = trajectory.At(t);
    const Eigen::Vector3d gyroscope_error = gyroscope.Next(random), force_error = accelerometer.Next(random);
    s.imu.push_back({t + std::llround(p.clock_offset_s * 1e9),
                     s.X_BI.R.conjugate() * motion.w_B + gyroscope_error,
                     SpecificForce_I(trajectory, t, motion, s.X_BI) + force_error});
    s.truth.push_back({t, motion.X_NB, motion.v_N, gyroscope.bias(), accelerometer.bias()});
  }
}

}  // namespace

void FlyTrajectory(const DatasetPlan& plan, const sim::SimulatorParameters& simulator, Journal& journal,
                   Sequence& s) {
  const DatasetArguments& a = plan.arguments;
  const Trajectory& trajectory = plan.trajectory->trajectory;
  const std::vector<FrameMakerParameters> cameras = CamerasOf(simulator);
  const std::int64_t begin_ns = trajectory.begin_ns();
  std::int64_t end_ns = trajectory.end_ns();
  if (a.duration_s) end_ns = std::min<std::int64_t>(end_ns, begin_ns + std::llround(*a.duration_s * 1e9));
  if (a.frames)
    end_ns = std::min<std::int64_t>(
        end_ns, begin_ns + std::llround(static_cast<double>(*a.frames - 1) * 1e9 / simulator.image.rate_hz));

  std::vector<std::pair<std::size_t, std::size_t>> missing;  // camera, frame
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const sim::CameraTiming& timing = cameras[c].camera.timing;
    const sim::Vibration vibration(cameras[c].camera.mount.vibration, SeedOf(cameras[c]));
    const auto shaken = [&](std::int64_t t_ns, const Pose& X_NC) {
      return vibration.still() ? X_NC : X_NC * vibration.At(static_cast<double>(t_ns - begin_ns) * 1e-9);
    };
    const double rate_hz = cameras[c].camera.image.rate_hz * (1 + 1e-6 * timing.drift_ppm);
    for (const std::int64_t stamp : StampsUntil(begin_ns, end_ns, timing.phase_s, rate_hz))
      s.frames[c].push_back({stamp, shaken(stamp, trajectory.At(stamp).X_NB * s.cameras[c].X_BC), {}});
    for (std::size_t i = 0; i < s.frames[c].size(); ++i) {
      if (const auto* entry = journal.Find({s.number, static_cast<int>(i), c}))
        s.frames[c][i].boxes = entry->boxes;
      else
        missing.emplace_back(c, i);
    }
  }
  if (!missing.empty()) {
    sim::SceneParameters scene = simulator.scene;
    scene.targets = simulator.targets;
    const sim::ModelPtr model = sim::MakeModel(scene);
    std::vector<Makers> makers(cameras.size());
    InParallel(missing.size(), a.jobs, "data set", "frames", [&](std::size_t k) {
      const auto [c, i] = missing[k];
      std::vector<FrameRow>& rows = s.frames[c];
      std::unique_ptr<FrameMaker> maker = makers[c].Take([&, number = c] {
        return std::make_unique<FrameMaker>(model.get(), cameras[number], trajectory, s.extras);
      });
      std::optional<std::int64_t> next;
      if (i + 1 < rows.size()) next = rows[i + 1].stamp_ns;
      SetFrame frame = maker->Make(static_cast<int>(i), rows[i].stamp_ns, next);
      makers[c].Give(std::move(maker));
      journal.Write({s.number, frame.index, c}, plan.format->Pictures(s, frame), frame.boxes);
      rows[i].boxes = std::move(frame.boxes);
    });
  }
  AddImu(trajectory, end_ns, simulator.seed, s);
  std::vector<TruthRow> of_frames;
  for (const FrameRow& row : s.frames[0]) {
    const Motion motion = trajectory.At(row.stamp_ns);
    of_frames.push_back({.stamp_ns = row.stamp_ns, .X_NB = motion.X_NB, .v_N = motion.v_N});
  }
  MergeTruth(of_frames, s);
}

}  // namespace kestrel::flight
