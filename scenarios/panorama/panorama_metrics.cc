// SPDX-License-Identifier: Apache-2.0
#include "scenarios/panorama/panorama_metrics.h"

#include <Eigen/SVD>
#include <cmath>
#include <numbers>
#include <optional>

#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"
#include "mission/mosaic/mosaic_report.h"

namespace kestrel::scenarios {
namespace {

// An image's attitude in the panorama, and truly.
struct Seen {
  Eigen::Matrix3d R_WC, R_NC;
  double turned = 0;  // rad, since the first, by the truth
};

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double side = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * Eigen::Vector3d(1, 1, side).asDiagonal() * svd.matrixV().transpose();
}

double Angle_deg(const Eigen::Matrix3d& R) { return Degrees(LogRotation(Eigen::Quaterniond(R)).norm()); }

std::vector<Seen> ImagesOf(const std::vector<mission::LogRow>& rows,
                           const std::vector<mission::PlacedImage>& placed) {
  std::vector<Seen> images;
  auto next = placed.begin();
  double yaw = 0;
  for (const mission::LogRow& row : rows) {
    if (next == placed.end()) break;
    if (row.sequence != next->sequence) continue;
    const double yaw_now = YawOf(row.exposure.X_NB.R);
    const double turned = images.empty() ? 0 : images.back().turned + WrapAngle(yaw_now - yaw);
    images.push_back({next->M_WC, row.exposure.X_NC.R.toRotationMatrix(), turned});
    yaw = yaw_now;
    ++next;
  }
  return images;
}

std::vector<Eigen::Vector3d> RaysOf(const vision::Projection& projection) {
  const double right = projection.image_size().width - 1, bottom = projection.image_size().height - 1;
  std::vector<Eigen::Vector3d> rays;
  for (const Eigen::Vector2d& uv :
       {Eigen::Vector2d(right / 2, bottom / 2), Eigen::Vector2d(0, 0), Eigen::Vector2d(right, 0),
        Eigen::Vector2d(right, bottom), Eigen::Vector2d(0, bottom)})
    if (const auto ray = vision::Ray(projection.camera(), uv)) rays.push_back(ray->normalized());
  return rays;
}

void AddErrors(const std::vector<mission::LogRow>& rows, const mission::FinishedMosaic& mosaic,
               const std::vector<mission::PlacedImage>& placed, const std::string& prefix,
               std::map<std::string, double>& metrics) {
  const std::vector<Seen> images = ImagesOf(rows, placed);
  if (images.empty()) return;
  // Least squares over all axes of all cameras: the rotation nearest to the sum of R_NC R_CW.
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Seen& image : images) sum += image.R_NC * image.R_WC.transpose();
  const Eigen::Matrix3d R_NW = NearestRotation(sum);
  mission::MeanSquare direction;
  for (const Seen& image : images)
    for (const Eigen::Vector3d& ray : RaysOf(mosaic.projection)) {
      const Eigen::Vector3d is = image.R_NC * ray, has = R_NW * image.R_WC * ray;
      direction.Add(Degrees(std::atan2(is.cross(has).norm(), is.dot(has))));
    }
  metrics[prefix + "rms_deg"] = direction.Root();
  for (const Seen& image : images) {
    if (std::abs(image.turned) < 2 * std::numbers::pi) continue;
    const Eigen::Matrix3d has = images.front().R_WC.transpose() * image.R_WC;
    const Eigen::Matrix3d is = images.front().R_NC.transpose() * image.R_NC;
    metrics[prefix + "closure_deg"] = Angle_deg(is.transpose() * has);
    break;
  }
}

}  // namespace

std::vector<mission::Metric> PanoramaMetrics() {
  return {{"panorama_rms_deg", "deg", "RMS error of directions in the panorama"},
          {"panorama_closure_deg", "deg", "Error of the panorama where a whole turn closes"},
          {"chain_rms_deg", "deg", "RMS error of directions, by images that are chained alone"},
          {"chain_closure_deg", "deg", "Error where a whole turn closes, by images that are chained alone"}};
}

void AddPanoramaMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics) {
  for (const mission::LogRow& row : rows) {
    const auto* report = mission::ReportOf<mission::MosaicReport>(row.decision);
    if (!report || !report->finished) continue;
    AddErrors(rows, *report->finished, report->finished->placed, "panorama_", metrics);
    AddErrors(rows, *report->finished, report->finished->chained, "chain_", metrics);
  }
}

}  // namespace kestrel::scenarios
