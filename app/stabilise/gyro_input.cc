// SPDX-License-Identifier: Apache-2.0
#include "app/stabilise/gyro_input.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

#include "app/simulated/images_input.h"
#include "geometry/pose.h"
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

}  // namespace

std::optional<Gyro> OpenGyro(const StabiliseArguments& a, const vision::CameraModel& camera,
                             const std::atomic<bool>& stopped, Mistakes& mistakes) {
  const std::size_t before = mistakes.all().size();
  Gyro gyro{vision::GyroTrack(vision::ReadGyroFile(a.imu, mistakes)), a.imu_offset_s.value_or(0)};
  if (mistakes.all().size() > before) return std::nullopt;
  if (a.imu_offset_s) return gyro;
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
