// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "base/diagnostics.h"
#include "geometry/pose.h"
#include "records/video/video.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

// What the verbs have in common that measure in the images of a camera: they read an image or a video, write a
// table of what they saw, and draw it.
namespace kestrel::app {

struct ImageArguments {
  std::string input, camera, camera_name, out, csv;
  std::optional<int> bits;  // of 16-bit pixels
  bool deinterlace = false, quiet = false;
};

// How a camera is mounted on the aircraft, as in a scenario: looking down with the top of the image forward, then
// turned.
struct MountAngles {
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
};
Pose PoseOf(const MountAngles& mount);  // X_BC, in B's origin

// --camera, which may be asked for by CLI::Option::required(), and --camera-name.
CLI::Option* AddCameraOptions(CLI::App& command, ImageArguments& arguments);
// --mount-yaw-deg, --mount-pitch-deg and --mount-roll-deg.
void AddMountOptions(CLI::App& command, MountAngles& mount);
// --frames, after which many `images` it ends; 0: with the input.
void AddFramesOption(CLI::App& command, const std::string& images, int& frames);
// --out and --csv, of which `csv_rows` says what it holds.
void AddOutputOptions(CLI::App& command, const std::string& csv_rows, ImageArguments& arguments);

// Where images come from, one after the other.
struct ImageInput {
  std::optional<cv::Size> size;  // none: a camera, of which only an image tells
  double rate_hz = 25;
  bool still = false;
  std::function<std::optional<vision::Frame>()> next;
  std::string note;
};

// An image or a video in a file. What is neither is a mistake.
ImageInput OpenImageFile(const ImageArguments& arguments, Mistakes& mistakes);

// The camera of images of this size. None: a mistake says why.
std::optional<vision::CameraModel> ReadCamera(const ImageArguments& arguments,
                                              const std::optional<cv::Size>& size, Mistakes& mistakes);

// Whether --out and --csv can be written and are none of the files that are read: the input, the camera's and
// this one. still: the input is one image.
void CheckOutputFiles(const ImageArguments& arguments, bool still, const std::string& also_read,
                      Mistakes& mistakes);

// The file of --out: one image, or a video of all.
class DrawnFile {
 public:
  DrawnFile(const ImageArguments& arguments, const ImageInput& input);
  bool wanted() const { return !file_.empty(); }
  void Write(const cv::Mat& bgr);
  void Close();

 private:
  std::string file_;
  std::optional<records::Video> video_;
};

// The number of every tenth frame, on a terminal.
class FrameProgress {
 public:
  explicit FrameProgress(bool wanted);
  void Show(int frames);
  void Clear();

 private:
  bool wanted_, shown_ = false;
};

}  // namespace kestrel::app
