// SPDX-License-Identifier: Apache-2.0
#include "mission/horizon_observer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/stopwatch.h"
#include "geometry/tait_bryan.h"

namespace kestrel::mission {
namespace {

// Of the attitude that gyros predict from image to image: they are heard once an image.
constexpr double kPredictionSigma = 0.02;  // rad

}  // namespace

HorizonObserver::HorizonObserver(const vision::CameraModel& camera, const Pose& X_BC,
                                 const cv::Mat& forbidden)
    : horizon_(camera, X_BC.R.toRotationMatrix(), forbidden, {}, {}),
      filter_(control::HorizonFilterOptions{}) {}

// What gyros and barometer say of the moment of the exposure: to choose and to refuse by.
vision::HorizonAttitude::Expected HorizonObserver::Expect(const vision::Frame& frame,
                                                          const control::VehicleState& state) {
  vision::HorizonAttitude::Expected expected;
  if (const auto now = filter_.Now()) {
    const Eigen::Quaterniond since = ExpRotation(state.w_B * (state.t_s - frame.t_s));
    const Eigen::Quaterniond R_NB = now->R_NB * since.conjugate();
    expected.down_B = R_NB.conjugate() * Eigen::Vector3d::UnitZ();
    expected.down_sigma = std::hypot(std::sqrt(now->P.topLeftCorner<2, 2>().trace()), kPredictionSigma);
    // From image to image, since without a heading the aircraft may turn by more than half a turn.
    const double yaw = YawOf(R_NB);
    since_turned_ += WrapAngle(yaw - yaw_);
    yaw_ = yaw;
    if (last_turned_) expected.turn = *last_turned_ + since_turned_;
  }
  expected.height_m = std::max(0.0, -state.p_NB.z());
  return expected;
}

HorizonReport HorizonObserver::Observe(const vision::Frame& frame, const control::VehicleState& state,
                                       Decision& decision) {
  HorizonReport report;
  const auto start = std::chrono::steady_clock::now();
  filter_.Add({state.t_s, state.w_B});
  measured_ = horizon_.Measure(frame.image, Expect(frame, state));
  const vision::HorizonAttitude::Measurement& m = *measured_;
  decision.target = "horizon";
  if (const auto* reason = std::get_if<vision::NoSkyline>(&m.skyline))
    decision.target = vision::NameOf(*reason);
  if (m.attitude) {
    seen_ = true;
    AttitudeFix fix{m.attitude->roll,
                    m.attitude->pitch,
                    std::sqrt(m.attitude->covariance(0, 0)),
                    std::sqrt(m.attitude->covariance(1, 1)),
                    {},
                    0};
    control::HorizonFilter::Attitude raw{frame.t_s, *m.down_B, m.covariance_B, {}, 0};
    if (const auto* heading = std::get_if<vision::CompassHeading>(&m.compass)) {
      fix.turned = heading->turned;
      fix.turned_sigma = std::sqrt(heading->variance);
      raw.heading = WrapAngle(heading->turned);
      raw.heading_variance = heading->variance;
      last_turned_ = heading->turned, since_turned_ = 0;
    }
    filter_.Correct(raw);
    report.attitude = fix;
  }
  if (const auto now = filter_.Now()) report.coasting_s = coasting_s_ = m.attitude ? 0 : now->coasting_s;
  decision.target_state = m.attitude ? TargetState::kInSight : TargetState::kLost;
  decision.vision_s = SecondsSince(start);
  return report;
}

void HorizonObserver::Draw(cv::Mat& bgr) const {
  if (measured_) bgr = horizon_.Draw(bgr, *measured_);
}

std::vector<Caption> HorizonObserver::Captions(std::string_view phase) const {
  std::vector<Caption> captions = {{std::string(phase)}};
  if (!measured_) return captions;
  for (const std::string& words : horizon_.Words(*measured_))
    captions.push_back({words, words.starts_with("no ")});
  if (coasting_s_ > 0) captions.push_back({cv::format("by gyros for %.1f s", coasting_s_)});
  return captions;
}

}  // namespace kestrel::mission
