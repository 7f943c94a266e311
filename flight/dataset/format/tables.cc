// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/format/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "flight/dataset/trajectory/conventions.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::flight {
namespace {

std::string Numbers(const Eigen::Vector3d& v) {
  return fmt::format("{},{},{}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);  // no -0
}

}  // namespace

std::string ImuCsv(const std::vector<sim::ImuReading>& rows) {
  std::string text =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad "
      "s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
      "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  for (const sim::ImuReading& row : rows)
    text += fmt::format("{},{},{}\n", row.t_ns, Numbers(row.w_I), Numbers(row.specific_force_I));
  return text;
}

std::string TruthCsv(const std::vector<TruthRow>& rows) {
  std::string text =
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], "
      "q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
      "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], "
      "b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad "
      "s^-1], "
      "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y "
      "[m s^-2], b_a_RS_S_z [m s^-2]\n";
  for (const TruthRow& row : rows) {
    const Pose X_WB = TurnWorld(row.X_NB);
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", row.stamp_ns, Numbers(X_WB.p), X_WB.R.w(), X_WB.R.x(),
                        X_WB.R.y(), X_WB.R.z(), Numbers(TurnWorld(row.v_N)), Numbers(row.gyroscope_bias),
                        Numbers(row.accelerometer_bias));
  }
  return text;
}

std::string BoxesCsv(const std::vector<FrameRow>& frames) {
  std::string text = "#timestamp [ns],label,u_min,v_min,u_max,v_max,pixels\n";
  for (const FrameRow& frame : frames)
    for (const Box& b : frame.boxes)
      text += fmt::format("{},{},{},{},{},{},{}\n", frame.stamp_ns, b.label, b.u_min, b.v_min, b.u_max,
                          b.v_max, b.pixels);
  return text;
}

std::string SecondsOf(std::int64_t stamp_ns) {
  return fmt::format("{}.{:09}", stamp_ns / 1'000'000'000, stamp_ns % 1'000'000'000);
}

std::string MatrixOf(const Pose& X) {
  const Eigen::Matrix3d R = X.R.toRotationMatrix();
  std::vector<std::string> rows;
  for (int i = 0; i < 3; ++i)
    rows.push_back(fmt::format("{}, {}, {}, {}", R(i, 0), R(i, 1), R(i, 2), X.p[i]));
  rows.emplace_back("0, 0, 0, 1");
  return fmt::format("{}", fmt::join(rows, ",\n         "));
}

std::vector<SetFile> KalibrFiles(const Sequence& s) {
  const auto matrix = [](const char* key, const Pose& X) {
    const Eigen::Matrix3d R = X.R.toRotationMatrix();
    std::string text = fmt::format("  {}:\n", key);
    for (int i = 0; i < 3; ++i)
      text += fmt::format("  - [{}, {}, {}, {}]\n", R(i, 0), R(i, 1), R(i, 2), X.p[i]);
    return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
  };
  std::string cameras;
  for (std::size_t i = 0; i < s.cameras.size(); ++i) {
    std::string text = vision::ToKalibr(s.cameras[i].model);
    for (std::size_t at; (at = text.find("cam0")) != std::string::npos && i > 0;)
      text.replace(at, 4, fmt::format("cam{}", i));
    cameras +=
        text + "  timeshift_cam_imu: 0.0\n" + matrix("T_cam_imu", s.cameras[i].X_BC.Inverse() * s.X_BI);
    if (i > 0) cameras += matrix("T_cn_cnm1", s.cameras[i].X_BC.Inverse() * s.cameras[i - 1].X_BC);
  }
  const sim::ImuParameters& noise = s.imu_parameters;
  const std::string imu = fmt::format(
      "accelerometer_noise_density: {}\naccelerometer_random_walk: "
      "{}\ngyroscope_noise_density: {}\n"
      "gyroscope_random_walk: {}\nrostopic: /imu0\nupdate_rate: {}\n",
      noise.accelerometer_noise_density, noise.accelerometer_random_walk, noise.gyroscope_noise_density,
      noise.gyroscope_random_walk, noise.rate_hz);
  return {{s.folder + "camchain.yaml", cameras}, {s.folder + "imu.yaml", imu}};
}

}  // namespace kestrel::flight
