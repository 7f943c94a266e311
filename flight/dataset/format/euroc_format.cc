// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/format/euroc_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "flight/dataset/format/pictures.h"
#include "flight/dataset/format/tables.h"
#include "flight/simulated/images/truth_images.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::flight {
namespace {

std::string PoseText(const Pose& X_BS) {
  return fmt::format("T_BS:\n  cols: 4\n  rows: 4\n  data: [{}]\n", MatrixOf(X_BS));
}

// Kalibr's words for the distortion, as EuRoC's files have them, which know no camera without.
std::string DistortionName(const std::string& kalibr) {
  return kalibr == "equi"                         ? "equidistant"
         : kalibr == "radtan" || kalibr == "none" ? "radial-tangential"
                                                  : kalibr;
}

std::string CameraSheet(const RigCamera& camera) {
  Mistakes none;
  const Config kalibr = ParseConfig(vision::ToKalibr(camera.model), "camchain", {}, none);
  const ConfigNode& cam0 = kalibr.root.members.front().node;
  const auto member = [&](const char* key) -> const ConfigNode& {
    for (const auto& each : cam0.members)
      if (each.key == key) return each.node;
    throw std::runtime_error(fmt::format("a camera without {}", key));
  };
  const auto list = [&](const char* key) {
    std::vector<std::string> numbers;
    for (const auto& each : member(key).members) numbers.push_back(each.node.text);
    return fmt::format("[{}]", fmt::join(numbers, ", "));
  };
  const std::string distortion = member("distortion_model").text;
  return fmt::format(
      "sensor_type: camera\ncomment: simulated by Kestrel\n{}rate_hz: "
      "{}\nresolution: {}\ncamera_model: {}\n"
      "intrinsics: {}\ndistortion_model: {}\ndistortion_coefficients: {}\n",
      PoseText(camera.X_BC), camera.rate_hz, list("resolution"), member("camera_model").text,
      list("intrinsics"), DistortionName(distortion),
      distortion == "none" ? "[0, 0, 0, 0]" : list("distortion_coeffs"));
}

std::string ImuSheet(const Sequence& s) {
  const sim::ImuParameters& noise = s.imu_parameters;
  return fmt::format(
      "sensor_type: imu\ncomment: simulated by "
      "Kestrel\n{}rate_hz: {}\ngyroscope_noise_density: {}\n"
      "gyroscope_random_walk: {}\naccelerometer_noise_density: "
      "{}\naccelerometer_random_walk: {}\n",
      PoseText(s.X_BI), noise.rate_hz, noise.gyroscope_noise_density, noise.gyroscope_random_walk,
      noise.accelerometer_noise_density, noise.accelerometer_random_walk);
}

}  // namespace

void EurocFormat::Check(const Sequence& s, Mistakes& mistakes) const {
  for (const RigCamera& camera : s.cameras) {
    try {
      vision::ToKalibr(camera.model);
    } catch (const InputError& e) {
      mistakes.Add(e, "camera");
    }
  }
}

std::vector<SetFile> EurocFormat::Pictures(const Sequence& s, const SetFrame& frame) const {
  std::vector<SetFile> files;
  const auto add = [&](const char* what, const char* ending, std::string bytes) {
    files.push_back(
        {fmt::format("{}mav0/{}{}/data/{}.{}", s.folder, what, frame.camera, frame.stamp_ns, ending),
         std::move(bytes)});
  };
  add("cam", "png", PngOf(frame.image));
  if (s.extras.depth) add("depth", "tiff", DepthTiff(frame.surfaces.depth_m));
  if (s.extras.segmentation) add("segmentation", "png", PngOf(GeomPicture(frame.surfaces.geom)));
  if (s.extras.flow && !frame.flow.empty()) add("flow", "flo", FlowFile(frame.flow));
  return files;
}

std::vector<SetFile> EurocFormat::Tables(const Sequence& s) const {
  std::vector<SetFile> files = KalibrFiles(s);
  const std::string mav = s.folder + "mav0/";
  for (std::size_t i = 0; i < s.cameras.size(); ++i) {
    const auto path = [&](const char* what, const char* file) {
      return fmt::format("{}{}{}/{}", mav, what, i, file);
    };
    const auto names = [&](std::size_t without, const char* ending) {
      std::string text = "#timestamp [ns],filename\n";
      for (std::size_t k = 0; k + without < s.frames[i].size(); ++k)
        text += fmt::format("{0},{0}.{1}\n", s.frames[i][k].stamp_ns, ending);
      return text;
    };
    files.push_back({path("cam", "data.csv"), names(0, "png")});
    files.push_back({path("cam", "sensor.yaml"), CameraSheet(s.cameras[i])});
    if (s.extras.depth) files.push_back({path("depth", "data.csv"), names(0, "tiff")});
    if (s.extras.segmentation) files.push_back({path("segmentation", "data.csv"), names(0, "png")});
    if (s.extras.flow) files.push_back({path("flow", "data.csv"), names(1, "flo")});
    if (s.extras.boxes) files.push_back({path("boxes", "data.csv"), BoxesCsv(s.frames[i])});
  }
  files.push_back({mav + "imu0/data.csv", ImuCsv(s.imu)});
  files.push_back({mav + "imu0/sensor.yaml", ImuSheet(s)});
  files.push_back({mav + "state_groundtruth_estimate0/data.csv", TruthCsv(s.truth)});
  files.push_back({mav + "state_groundtruth_estimate0/sensor.yaml",
                   "sensor_type: visual-inertial\ncomment: the truth of the simulator\n" + PoseText({})});
  files.push_back({mav + "body.yaml", "comment: simulated by Kestrel; forward, right, down\n"});
  return files;
}

}  // namespace kestrel::flight
