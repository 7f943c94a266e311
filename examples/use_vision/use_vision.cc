// SPDX-License-Identifier: Apache-2.0
// Finds a landing pad in a video and follows it: where the camera is over the pad, frame by frame.
//   use_vision VIDEO CAMERA.yaml PAD.yaml
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "base/diagnostics.h"
#include "vision/camera/calibration_file.h"
#include "vision/camera/views.h"
#include "vision/landmark/pad_file.h"
#include "vision/landmark/pad_tracker.h"

namespace {

constexpr double kMaxField_rad = 1.75;  // of what the tracker looks at, in a camera that sees more

int Follow(const char* video, const char* camera_file, const char* pad_file) {
  kestrel::Mistakes mistakes;
  const auto camera = kestrel::vision::LoadCamera(camera_file, mistakes);
  const auto pad = kestrel::vision::LoadPad(pad_file, mistakes);
  mistakes.ThrowIfAny();

  // The tracker takes images without distortion: those of a virtual pinhole along the camera's own axis.
  const auto pinhole = kestrel::vision::CentralPinhole(camera, kMaxField_rad);
  if (!pinhole) throw kestrel::InputError(camera_file, "the camera does not see along its own axis");
  const auto view = kestrel::vision::MakeViewTable(kestrel::vision::PerspectiveView{*pinhole}, camera);
  kestrel::vision::PadTracker tracker(pad.reference, *pinhole, {});

  cv::VideoCapture frames(video);
  int seen = 0, number = 0;
  for (cv::Mat image; frames.read(image); ++number) {
    cv::Mat grey;
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
    const auto found = tracker.Track(kestrel::vision::Look(view, grey), std::nullopt);
    if (!found) {
      std::printf("%5d  not seen\n", number);
      continue;
    }
    const Eigen::Vector3d p_TC = found->X_CT.Inverse().p;  // the camera in the pad's frame, m, z down
    std::printf("%5d  x %6.3f  y %6.3f  height %6.3f m  (%d points)\n", number, p_TC.x(), p_TC.y(), -p_TC.z(),
                found->inliers);
    ++seen;
  }
  std::printf("seen in %d of %d frames\n", seen, number);
  return seen > 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fputs("use_vision VIDEO CAMERA.yaml PAD.yaml\n", stderr), 2;
  try {
    return Follow(argv[1], argv[2], argv[3]);
  } catch (const kestrel::InputError& e) {
    return std::fprintf(stderr, "%s\n", e.what()), 2;
  }
}
