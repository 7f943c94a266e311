// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
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
}  // namespace CLI

// What the verbs have in common that measure in the images of a camera: they read an image or a video, write a
// table of what they saw, and draw it.
namespace kestrel::app {

struct ImageArguments {
  std::string input, camera, camera_name, out, csv;
  std::string topic;              // which camera of a recording with several
  std::optional<double> rate_hz;  // of images without stamps
  std::optional<int> bits;        // of 16-bit pixels
  bool deinterlace = false, quiet = false;
};

// How a camera is mounted on the aircraft, as in a scenario: looking down with the top of the image forward, then
// turned.
struct MountAngles {
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
};
Pose PoseOf(const MountAngles& mount);  // X_BC, in B's origin

// --camera and --camera-name.
void AddCameraOptions(CLI::App& command, ImageArguments& arguments);
// --mount-yaw-deg, --mount-pitch-deg and --mount-roll-deg.
void AddMountOptions(CLI::App& command, MountAngles& mount);
// --frames, after which many `images` it ends; 0: with the input.
void AddFramesOption(CLI::App& command, const std::string& images, int& frames);
// --out and --csv, of which `csv_rows` says what it holds.
void AddOutputOptions(CLI::App& command, const std::string& csv_rows, ImageArguments& arguments);

// Where images come from, one after the other. Of a recording with stamps, an image's t_s is the time since the
// first image, to the nanosecond.
struct ImageInput {
  std::optional<cv::Size> size;  // none: a camera, of which only an image tells
  double rate_hz = 25;
  bool still = false;
  std::function<std::optional<vision::Frame>()> next;
  std::string note;
  std::optional<std::int64_t> first_ns;  // of a recording with stamps: that of the first image
  std::filesystem::path calibration;     // what a recording has of this camera; empty: none
  std::string calibration_text;          // the same, of a recording in one file
  bool has_calibration() const { return !calibration.empty() || !calibration_text.empty(); }
  std::string topic;           // which camera of a recording with several; empty: it has but one
  std::filesystem::path gyro;  // and of a gyro of the same clock; empty: none
};

// An image or a video in a file. What is neither is a mistake.
ImageInput OpenImageFile(const ImageArguments& arguments, Mistakes& mistakes);

// The camera of --camera, or else that of the recording, for images of the input's size. None: a mistake says
// why.
std::optional<vision::CameraModel> ReadCamera(const ImageArguments& arguments, const ImageInput& input,
                                              Mistakes& mistakes);
// Its file, where there is one.
std::optional<std::filesystem::path> CameraFile(const ImageArguments& arguments, const ImageInput& input,
                                                Mistakes& mistakes);

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
