// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/format/kitti_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "flight/dataset/format/pictures.h"
#include "flight/dataset/format/tables.h"
#include "flight/simulated/images/truth_images.h"

namespace kestrel::flight {
namespace {

constexpr double kKittiDepth_per_m = 256;

std::string FolderOf(const Sequence& s) { return fmt::format("sequences/{:02}/", s.number); }

std::string RowsOf(const Pose& X) {
  const Eigen::Matrix3d R = X.R.toRotationMatrix();
  std::vector<std::string> rows;
  for (int i = 0; i < 3; ++i)
    rows.push_back(fmt::format("{:.12e} {:.12e} {:.12e} {:.12e}", R(i, 0), R(i, 1), R(i, 2), X.p[i]));
  return fmt::format("{}", fmt::join(rows, " "));
}

// fx, fy, cx, cy and no more: what calib.txt can say.
bool IsUndistorted(const vision::CameraModel& camera) {
  const Eigen::VectorXd all = vision::Parameters(camera);
  const std::string model = vision::NameOf(camera);
  return (model == "pinhole" || model == "brown_conrady") && all.tail(all.size() - 4).isZero(0);
}

std::string ProjectionOf(const RigCamera& camera, const RigCamera& first) {
  const Eigen::VectorXd k = vision::Parameters(camera.model);
  const Eigen::Vector3d t = (camera.X_BC.Inverse() * first.X_BC).p;
  Eigen::Matrix<double, 3, 4> P;
  P << k[0], 0, k[2], k[0] * t.x() + k[2] * t.z(), 0, k[1], k[3], k[1] * t.y() + k[3] * t.z(), 0, 0, 1, t.z();
  std::vector<std::string> numbers;
  for (int i = 0; i < 12; ++i) numbers.push_back(fmt::format("{:.12e}", P(i / 4, i % 4)));
  return fmt::format("{}", fmt::join(numbers, " "));
}

}  // namespace

void KittiFormat::Check(const Sequence& s, Mistakes& mistakes) const {
  if (s.cameras.size() > 2)
    mistakes.Add("--format", "",
                 fmt::format("kitti holds a stereo pair, and there are {} cameras", s.cameras.size()),
                 "valid: euroc");
  if (s.number > 99) mistakes.Add("--count", "", "kitti counts sequences to 99", "valid: up to 100");
  for (const RigCamera& camera : s.cameras)
    if (!IsUndistorted(camera.model))
      mistakes.Add("--format", "",
                   fmt::format("kitti's images are rectified, and its "
                               "calib.txt cannot say a camera of the model {}",
                               vision::NameOf(camera.model)),
                   "valid: euroc or tum, or a camera without distortion such "
                   "as thesis_6mm");
  if (s.cameras.size() == 2 && (s.cameras[0].X_BC.R.angularDistance(s.cameras[1].X_BC.R) > 1e-9 ||
                                s.cameras[0].rate_hz != s.cameras[1].rate_hz))
    mistakes.Add("--format", "",
                 "kitti's pair looks the same way at the same instants, and "
                 "these cameras do not",
                 "valid: euroc");
}

std::vector<SetFile> KittiFormat::Pictures(const Sequence& s, const SetFrame& frame) const {
  std::vector<SetFile> files;
  const auto add = [&](const char* what, std::size_t number, std::string bytes) {
    files.push_back(
        {fmt::format("{}{}_{}/{:06}.png", FolderOf(s), what, number, frame.index), std::move(bytes)});
  };
  add("image", frame.camera + (frame.image.channels() == 3 ? 2 : 0), PngOf(frame.image));
  if (s.extras.depth)
    add("depth", frame.camera,
        DepthPng(frame.surfaces.depth_m, s.cameras[frame.camera].axial, kKittiDepth_per_m));
  if (s.extras.segmentation) add("segmentation", frame.camera, PngOf(GeomPicture(frame.surfaces.geom)));
  if (s.extras.flow && !frame.flow.empty()) add("flow", frame.camera, FlowPng(frame.flow));
  return files;
}

std::vector<SetFile> KittiFormat::Tables(const Sequence& s) const {
  std::vector<SetFile> files;
  const std::string folder = FolderOf(s);
  for (SetFile& file : KalibrFiles(s))
    files.push_back({folder + file.path.substr(s.folder.size()), file.bytes});
  std::string times, poses, calibration;
  for (const FrameRow& frame : s.frames[0]) {
    const FrameRow& first = s.frames[0].front();
    times += SecondsOf(frame.stamp_ns - first.stamp_ns) + "\n";
    poses += RowsOf(first.X_NC.Inverse() * frame.X_NC) + "\n";
  }
  for (std::size_t i = 0; i < 4; ++i)  // grey and colour of the left, and of the right
    calibration += fmt::format("P{}: {}\n", i,
                               ProjectionOf(s.cameras[std::min(i % 2, s.cameras.size() - 1)], s.cameras[0]));
  calibration += "Tr: " + RowsOf(s.cameras.front().X_BC.Inverse()) + "\n";
  files.push_back({folder + "times.txt", times});
  files.push_back({folder + "calib.txt", calibration});
  files.push_back({fmt::format("poses/{:02}.txt", s.number), poses});
  files.push_back({folder + "imu.csv", ImuCsv(s.imu)});
  files.push_back({folder + "truth.csv", TruthCsv(s.truth)});
  if (s.extras.boxes)
    for (std::size_t i = 0; i < s.cameras.size(); ++i)
      files.push_back({fmt::format("{}boxes_{}.csv", folder, i), BoxesCsv(s.frames[i])});
  return files;
}

}  // namespace kestrel::flight
