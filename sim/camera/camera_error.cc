// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/camera_error.h"

#include <cmath>

#include "base/random.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

Eigen::Vector3d NormalOfRms(RandomStream& random, double rms) {
  Eigen::Vector3d v;
  for (double& each : v) each = random.Normal() * rms / std::sqrt(3.0);
  return v;
}

}  // namespace

CameraError::CameraError(const CameraErrorParameters& parameters, std::uint64_t seed)
    : parameters_(parameters), seed_(seed) {
  RandomStream lens(seed, "camera error lens"), mount(seed, "camera error mount"),
      clock(seed, "camera error clock");
  focal_ = 1 + parameters.focal * lens.Normal();
  for (double& each : centre_px_) each = parameters.centre_px * lens.Normal();
  X_MC_.p = NormalOfRms(mount, parameters.position_m);
  const Eigen::Vector3d turn = NormalOfRms(mount, Radians(parameters.angle_deg));
  if (turn.norm() > 0) X_MC_.R = Eigen::AngleAxisd(turn.norm(), turn.normalized());
  clock_offset_s_ = parameters.clock_offset_s * clock.Normal();
  clock_rate_ = 1e-6 * parameters.clock_drift_ppm * clock.Normal();
}

vision::CameraModel CameraError::Of(vision::CameraModel camera) const {
  if (parameters_.focal <= 0 && parameters_.centre_px <= 0) return camera;
  Eigen::VectorXd all = vision::Parameters(camera);  // fx, fy, cx, cy, then the model's own
  all.head<2>() *= focal_;
  all.segment<2>(2) += centre_px_;
  vision::SetParameters(camera, all);
  return camera;
}

Pose CameraError::Of(const Pose& X_BC) const {
  if (parameters_.position_m <= 0 && parameters_.angle_deg <= 0) return X_BC;
  return X_BC * X_MC_;
}

double CameraError::Stamp(double t_s, std::int64_t sequence) const {
  double stamp_s = t_s + clock_offset_s_ + clock_rate_ * t_s;
  if (parameters_.clock_jitter_s > 0)
    stamp_s +=
        parameters_.clock_jitter_s *
        RandomStream(RandomStream::Mix(seed_) + static_cast<std::uint64_t>(sequence), "camera error jitter")
            .Normal();
  return stamp_s;
}

}  // namespace kestrel::sim
