// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hand_held/hand_held_metrics.h"

#include <Eigen/Dense>

#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"
#include "scenarios/hand_held/hand_held_report.h"

namespace kestrel::scenarios {
namespace {

constexpr double kWithin95 = 12.592;  // quantile of chi squared of six degrees of freedom

// Of the landmark from the camera in C, and of the camera in the room.
struct Errors {
  mission::MeanSquare landmark[3], camera[3], yaw;
  double last_m = 0;  // distance of the landmark from where it is, in the last image

  void Add(const Truth& exposure, const HandHeldReport& report, const vision::PadObservation& seen) {
    const Pose X_NC = TrueCamera(exposure, report);
    const Eigen::Vector3d in_image = seen.X_CT.p - (X_NC.Inverse() * exposure.X_NT).p;
    const RoomPlace truth = InRoom(X_NC), place = InRoom(SeenCamera(exposure, seen));
    for (int axis = 0; axis < 3; ++axis)
      landmark[axis].Add(in_image[axis]), camera[axis].Add(place.p[axis] - truth.p[axis]);
    yaw.Add(Degrees(WrapAngle(place.yaw - truth.yaw)));
    last_m = in_image.norm();
  }
  void Tell(const std::string& prefix, std::map<std::string, double>& metrics) const {
    constexpr const char* kAxes[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
      metrics[prefix + "landmark_" + kAxes[axis] + "_rmse_m"] = landmark[axis].Root();
      metrics[prefix + "camera_" + kAxes[axis] + "_rmse_m"] = camera[axis].Root();
    }
    metrics[prefix + "camera_yaw_rmse_deg"] = yaw.Root();
  }
};

// By its own covariance.
bool IsWithin95(const Truth& exposure, const HandHeldReport& report, const vision::PadObservation& seen) {
  const Pose X_CT = TrueCamera(exposure, report).Inverse() * exposure.X_NT;
  Eigen::Matrix<double, 6, 1> error;
  error << seen.X_CT.p - X_CT.p, LogRotation(seen.X_CT.R * X_CT.R.conjugate());
  return error.dot(seen.covariance.ldlt().solve(error)) <= kWithin95;
}

}  // namespace

std::vector<mission::TelemetryColumn> HandHeldColumns() {
  const auto column = [](const char* name, auto get) {
    return mission::TelemetryColumn{name, [get](const records::LogRow& row) -> std::optional<double> {
                                      const auto* report = mission::ReportOf<HandHeldReport>(row.decision);
                                      if (!report || !report->seen) return std::nullopt;
                                      return get(row.exposure, *report->seen);
                                    }};
  };
  std::vector<mission::TelemetryColumn> columns;
  constexpr const char* kLandmark[] = {"landmark_x_m", "landmark_y_m", "landmark_z_m"};
  constexpr const char* kSigma[] = {"landmark_sigma_x_m", "landmark_sigma_y_m", "landmark_sigma_z_m"};
  constexpr const char* kCamera[] = {"camera_x_m", "camera_y_m", "camera_z_m"};
  for (int axis = 0; axis < 3; ++axis)
    columns.push_back(column(kLandmark[axis], [axis](const Truth&, const vision::PadObservation& seen) {
      return seen.X_CT.p[axis];
    }));
  for (int axis = 0; axis < 3; ++axis)
    columns.push_back(column(kSigma[axis], [axis](const Truth&, const vision::PadObservation& seen) {
      return std::sqrt(seen.covariance(axis, axis));
    }));
  for (int axis = 0; axis < 3; ++axis)
    columns.push_back(column(kCamera[axis], [axis](const Truth& t, const vision::PadObservation& seen) {
      return InRoom(SeenCamera(t, seen)).p[axis];
    }));
  columns.push_back(column("camera_yaw_deg", [](const Truth& t, const vision::PadObservation& seen) {
    return Degrees(InRoom(SeenCamera(t, seen)).yaw);
  }));
  return columns;
}

std::vector<mission::Metric> HandHeldMetrics() {
  std::vector<mission::Metric> metrics;
  const auto add = [&](const std::string& prefix, const std::string& of) {
    metrics.insert(
        metrics.end(),
        {{prefix + "landmark_x_rmse_m", "m", "RMS error of the landmark across the image, to the right" + of},
         {prefix + "landmark_y_rmse_m", "m", "RMS error of the landmark across the image, downwards" + of},
         {prefix + "landmark_z_rmse_m", "m", "RMS error of the landmark in depth" + of},
         {prefix + "camera_x_rmse_m", "m", "RMS error of the camera in the room along the wall" + of},
         {prefix + "camera_y_rmse_m", "m", "RMS error of the camera in the room towards the wall" + of},
         {prefix + "camera_z_rmse_m", "m", "RMS error of the camera in the room in height" + of},
         {prefix + "camera_yaw_rmse_deg", "deg", "RMS error of the camera's yaw in the room" + of}});
  };
  add("", "");
  metrics.push_back({"landmark_share", "1", "Share of the frames in which the landmark was seen", 0, 1});
  metrics.push_back({"within_95_share", "1",
                     "Share of the poses that are within 95 % of what their own covariance allows", 0, 1});
  add("chain_", ", by the chain of homographies alone");
  metrics.push_back(
      {"chain_landmark_share", "1", "Share of the frames until the chain of homographies alone broke", 0, 1});
  metrics.push_back(
      {"chain_drift_m", "m", "How far off the landmark was in the last image before the chain alone broke"});
  return metrics;
}

void AddHandHeldMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics) {
  Errors registered, chained;
  int frames = 0, seen = 0, in_chain = 0, within = 0;
  for (const records::LogRow& row : rows) {
    const auto* report = mission::ReportOf<HandHeldReport>(row.decision);
    if (!report) continue;
    ++frames;
    if (report->seen) {
      ++seen, within += IsWithin95(row.exposure, *report, *report->seen);
      registered.Add(row.exposure, *report, *report->seen);
    }
    if (report->chained) ++in_chain, chained.Add(row.exposure, *report, *report->chained);
  }
  if (frames == 0) return;
  metrics["landmark_share"] = static_cast<double>(seen) / frames;
  if (seen > 0) {
    registered.Tell("", metrics);
    metrics["within_95_share"] = static_cast<double>(within) / seen;
  }
  if (in_chain > 0) {
    chained.Tell("chain_", metrics);
    metrics["chain_landmark_share"] = static_cast<double>(in_chain) / frames;
    metrics["chain_drift_m"] = chained.last_m;
  }
}

}  // namespace kestrel::scenarios
