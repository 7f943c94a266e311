// SPDX-License-Identifier: Apache-2.0
#include "app/stabilise/gyro_input.h"

#include <fmt/format.h>

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

#include "app/simulated/images_input.h"
#include "geometry/pose.h"
#include "vision/camera/calibration_file.h"
#include "vision/capture/recorded/mcap_frames.h"
#include "vision/capture/recorded/mcap_images.h"
#include "vision/capture/recorded/recorded_gyro.h"
#include "vision/enhance/stabilisation/gyro_file.h"
#include "vision/enhance/stabilisation/gyro_offset.h"
#include "vision/enhance/stabilisation/image_follower.h"

namespace kestrel::app {
namespace {

// How the camera turned from image to image. The input is read to its end.
std::vector<vision::ImageTurn> TurnsOf(const StabiliseArguments& a, const vision::CameraModel& camera,
                                       const std::atomic<bool>& stopped, ImageInput input) {
  vision::StabiliserOptions sphere = a.options;
  sphere.by = "sphere";
  vision::ImageFollower follower(sphere, camera, {}, false);
  std::vector<vision::ImageTurn> turns;
  std::optional<Eigen::Quaterniond> before;
  double before_s = 0;
  constexpr int kEnough = 600;
  const auto next = [&](int number) -> std::optional<vision::Frame> {
    try {
      return NextImage(input, number, true);
    } catch (const std::runtime_error&) {  // told when it is met again, to be stabilised
      return std::nullopt;
    }
  };
  for (int i = 0; i < kEnough && !stopped; ++i) {
    const auto frame = next(i);
    if (!frame) break;
    if (frame->image.empty()) continue;
    cv::Mat grey = frame->image;
    if (grey.channels() == 3) cv::cvtColor(frame->image, grey, cv::COLOR_BGR2GRAY);
    const vision::FollowedImage followed = follower.Step(grey, frame->t_s, {});
    const bool known = followed.state == vision::StabilisedState::kFollowed;
    if (known && before)
      turns.push_back({before_s, frame->t_s, LogRotation(before->conjugate() * followed.R_NC)});
    before = followed.R_NC, before_s = frame->t_s;
  }
  return turns;
}

struct GyroSamples {
  std::vector<vision::GyroSample> all;
  bool same_clock = false;  // as the images'
};

// X_IC, by the calibration or else by what an MCAP says of it.
std::optional<Pose> PoseOnImu(const StabiliseArguments& a, const ImageInput& input, Mistakes& mistakes) {
  if (!a.camera.empty() || !input.calibration.empty())
    if (const auto file = CameraFile(a, input, mistakes))
      if (const auto X_IC = vision::LoadPoseOnImu(*file, mistakes, a.camera_name)) return X_IC;
  if (!vision::IsMcap(a.imu) || a.imu != input.gyro) return std::nullopt;
  return vision::PoseOnImuInMcap(a.imu, input.topic, a.imu_topic);
}

// Of an IMU that was recorded: in the camera's axes, from the first image on, or else from its own first sample.
GyroSamples SamplesOfImu(const StabiliseArguments& a, const ImageInput& input, Mistakes& mistakes) {
  const std::vector<vision::RecordedRate> rates = vision::ReadRecordedGyro(a.imu, a.imu_topic, mistakes);
  if (rates.empty()) return {};
  const auto X_IC = PoseOnImu(a, input, mistakes);
  if (!X_IC) {
    mistakes.Add(
        "--camera", "", "how the camera stands on the IMU, in whose axes the rates are, is not said",
        "valid: a calibration with T_BS of EuRoC or T_cam_imu of Kalibr, or an MCAP whose transforms join "
        "their frames");
    return {};
  }
  GyroSamples samples;
  samples.same_clock =
      input.first_ns && *input.first_ns >= rates.front().stamp_ns && *input.first_ns <= rates.back().stamp_ns;
  const std::int64_t from_ns = samples.same_clock ? *input.first_ns : rates.front().stamp_ns;
  const Eigen::Matrix3d R_CI = X_IC->R.inverse().toRotationMatrix();
  for (const vision::RecordedRate& each : rates)
    samples.all.push_back({static_cast<double>(each.stamp_ns - from_ns) / 1e9, R_CI * each.w_I});
  return samples;
}

GyroSamples SamplesOf(const StabiliseArguments& a, const ImageInput& input, Mistakes& mistakes) {
  if (vision::IsRecordedGyro(a.imu)) return SamplesOfImu(a, input, mistakes);
  return {vision::ReadGyroFile(a.imu, mistakes)};
}

}  // namespace

std::optional<Gyro> OpenGyro(const StabiliseArguments& a, const vision::CameraModel& camera,
                             const ImageInput& input, const std::atomic<bool>& stopped, Mistakes& mistakes) {
  const std::size_t before = mistakes.all().size();
  const GyroSamples samples = SamplesOf(a, input, mistakes);
  if (mistakes.all().size() > before) return std::nullopt;
  Gyro gyro{vision::GyroTrack(samples.all), a.imu_offset_s.value_or(0)};
  if (a.imu_offset_s || samples.same_clock) return gyro;
  const auto offset = vision::EstimateGyroOffset(
      TurnsOf(a, camera, stopped, OpenImages(a, stopped, mistakes)), gyro.track, a.max_offset_s);
  if (!offset) {
    mistakes.Add(
        "--imu", "",
        fmt::format("'{}', from {:.3f} to {:.3f} s, turns as the video does at no offset of up to {} s",
                    a.imu, gyro.track.begin_s(), gyro.track.end_s(), a.max_offset_s),
        "valid: the rates in the camera's axes while it was filmed, of the same clock within --max-offset-s; "
        "--imu-offset-s where the offset is known");
    return std::nullopt;
  }
  gyro.offset_s = offset->offset_s;
  if (!a.quiet)
    fmt::print(
        "the gyro's clock is {:+.4f} s from the video's, by {} turns of which it leaves {:.1f} % "
        "unexplained\n",
        offset->offset_s, offset->turns, 100 * offset->unlike);
  if (!a.quiet && offset->other_s)
    fmt::print(
        "at {:+.2f} s it explains them about as well, since they repeat themselves; --imu-offset-s where it "
        "is known, "
        "or a smaller --max-offset-s\n",
        *offset->other_s);
  return gyro;
}

}  // namespace kestrel::app
