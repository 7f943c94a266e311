// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/format/tum_format.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "flight/dataset/format/pictures.h"
#include "flight/dataset/format/tables.h"
#include "flight/dataset/trajectory/conventions.h"
#include "flight/simulated/images/truth_images.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::flight {
namespace {

constexpr double kTumDepth_per_m = 5000;

}  // namespace

void TumFormat::Check(const Sequence& s, Mistakes& mistakes) const {
  if (s.cameras.size() != 1)
    mistakes.Add("--format", "", fmt::format("tum holds one camera, and there are {}", s.cameras.size()),
                 "valid: euroc");
  try {
    vision::ToKalibr(s.cameras.front().model);
  } catch (const InputError& e) {
    mistakes.Add(e, "camera");
  }
}

std::vector<SetFile> TumFormat::Pictures(const Sequence& s, const SetFrame& frame) const {
  std::vector<SetFile> files;
  const auto add = [&](const char* what, const char* ending, std::string bytes) {
    files.push_back(
        {fmt::format("{}{}/{}.{}", s.folder, what, SecondsOf(frame.stamp_ns), ending), std::move(bytes)});
  };
  cv::Mat colour = frame.image;  // readers expect three channels
  if (colour.channels() == 1) cv::cvtColor(frame.image, colour, cv::COLOR_GRAY2BGR);
  add("rgb", "png", PngOf(colour));
  if (s.extras.depth)
    add("depth", "png", DepthPng(frame.surfaces.depth_m, s.cameras[frame.camera].axial, kTumDepth_per_m));
  if (s.extras.segmentation) add("segmentation", "png", PngOf(GeomPicture(frame.surfaces.geom)));
  if (s.extras.flow && !frame.flow.empty()) add("flow", "flo", FlowFile(frame.flow));
  return files;
}

std::vector<SetFile> TumFormat::Tables(const Sequence& s) const {
  std::vector<SetFile> files = KalibrFiles(s);
  const auto add = [&](const char* name, std::string text) {
    files.push_back({s.folder + name, std::move(text)});
  };
  const auto list = [&](const char* title, const char* folder, const char* ending, std::size_t without) {
    std::string text = fmt::format("# {}\n# simulated by Kestrel\n# timestamp filename\n", title);
    for (std::size_t i = 0; i + without < s.frames[0].size(); ++i) {
      const std::string stamp = SecondsOf(s.frames[0][i].stamp_ns);
      text += fmt::format("{} {}/{}.{}\n", stamp, folder, stamp, ending);
    }
    return text;
  };
  add("rgb.txt", list("color images", "rgb", "png", 0));
  if (s.extras.depth) add("depth.txt", list("depth maps", "depth", "png", 0));
  if (s.extras.segmentation) add("segmentation.txt", list("segmentation", "segmentation", "png", 0));
  if (s.extras.flow) add("flow.txt", list("optical flow to the next image", "flow", "flo", 1));
  if (s.extras.boxes) add("boxes.csv", BoxesCsv(s.frames[0]));
  std::string truth =
      "# ground truth trajectory\n# simulated by Kestrel\n# "
      "timestamp tx ty tz qx qy qz qw\n";
  for (const TruthRow& row : s.truth) {
    const Pose X_WC = TurnWorld(row.X_NB * s.cameras.front().X_BC);
    truth += fmt::format("{} {} {} {} {} {} {} {}\n", SecondsOf(row.stamp_ns), X_WC.p.x(), X_WC.p.y(),
                         X_WC.p.z(), X_WC.R.x(), X_WC.R.y(), X_WC.R.z(), X_WC.R.w());
  }
  add("groundtruth.txt", truth);
  std::string forces = "# accelerometer data\n# simulated by Kestrel\n# timestamp ax ay az\n";
  std::string rates = "# gyroscope data\n# simulated by Kestrel\n# timestamp wx wy wz\n";
  for (const sim::ImuReading& row : s.imu) {
    const auto line = [&](const Eigen::Vector3d& v) {
      return fmt::format("{} {} {} {}\n", SecondsOf(row.t_ns), v.x(), v.y(), v.z());
    };
    forces += line(row.specific_force_I), rates += line(row.w_I);
  }
  add("accelerometer.txt", forces);
  add("gyroscope.txt", rates);
  return files;
}

}  // namespace kestrel::flight
