// SPDX-License-Identifier: Apache-2.0
// A loop of one's own: the simulated aircraft step by step. The flight code below sees the frames and what the
// autopilot believes of itself, holds the aircraft over the pad, and is judged by the truth.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "flight/stepped/sim.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/camera_model.h"

namespace {

using namespace kestrel;

// The centre of what is white in a grey image, px: of the pad's frame and letter; none: too little is.
std::optional<Eigen::Vector2d> WhiteCentre(const cv::Mat& image) {
  constexpr double kWhite = 200, kFewest_px = 100;
  cv::Mat white;
  cv::threshold(image, white, kWhite, 255, cv::THRESH_BINARY);
  const cv::Moments m = cv::moments(white, true);
  if (m.m00 < kFewest_px) return std::nullopt;
  return Eigen::Vector2d(m.m10 / m.m00, m.m01 / m.m00);
}

// Where a pixel's ray meets the ground from this height, m ahead and to the right: without the aircraft's lean.
std::optional<Eigen::Vector2d> OnGround(const Eigen::Vector2d& px, const vision::CameraModel& camera,
                                        const Eigen::Quaterniond& R_BC, const control::VehicleState& state) {
  const auto ray_C = vision::Ray(camera, px);
  if (!ray_C) return std::nullopt;
  const Eigen::Quaterniond R_NH = HeadingRotation(YawOf(state.R_NB));
  const Eigen::Vector3d ray_H = R_NH.conjugate() * state.R_NB * R_BC * *ray_C;
  if (ray_H.z() < 0.1) return std::nullopt;  // to the horizon
  return Eigen::Vector2d(ray_H.head<2>() / ray_H.z() * -state.p_NB.z());
}

}  // namespace

int main(int argc, char** argv) {
  try {
#ifdef KESTREL_DATA_DIR  // where the scenarios and models are installed, for a program that lies elsewhere
    setenv("KESTREL_ROOT", KESTREL_DATA_DIR, 0);
#endif
    SimOptions options;
    options.seed = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1;
    options.overrides = {"duration_s=10"};
    Sim sim("hover", options);
    Observation now = sim.Reset();
    const vision::CameraModel& camera = sim.scenario().simulator.camera;
    constexpr double kGain_1_s = 0.7;
    int seen = 0;
    while (!sim.done()) {
      control::VelocitySetpoint setpoint;  // stands still where it sees nothing
      if (const auto centre = WhiteCentre(now.frame->image)) {
        ++seen;
        if (const auto pad_H = OnGround(*centre, camera, sim.simulator().X_BC().R, now.state))
          setpoint.v_H.head<2>() = kGain_1_s * *pad_H;
      }
      now = sim.Step(setpoint);
    }
    const records::Summary summary = sim.Summarise();
    const double off_m = (sim.truth().X_NB.p - sim.truth().X_NT.p).head<2>().norm();
    std::printf("%s after %.2f s, seen in %d of %zu frames\n", summary.outcome.c_str(), summary.sim_s, seen,
                sim.rows().size());
    std::printf("%.2f m beside the pad's middle, hash of all states %016llx\n", off_m,
                static_cast<unsigned long long>(summary.state_hash));
    return off_m < 0.3 ? 0 : 1;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "own_loop: %s\n", e.what());
    return 2;
  }
}
