// SPDX-License-Identifier: Apache-2.0
#include "scenarios/survey/survey_metrics.h"

#include <Eigen/LU>
#include <limits>
#include <optional>

#include "mission/mean_square.h"
#include "mission/mosaic/mosaic_report.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::scenarios {
namespace {

constexpr int kColumns = 20, kRows = 10;  // of the grid of places: 200
constexpr double kPass_s = 10;            // between two images that are not of one pass over a place

// An image of the mosaic with where its camera truly was.
struct Seen {
  double t_s;
  Pose X_CN;
  Eigen::Vector2d centre_N;  // of the ground in the middle of the image, m
  Eigen::Matrix3d M_WC;
};

std::vector<Seen> ImagesOf(const std::vector<mission::LogRow>& rows, const vision::Projection& projection,
                           const std::vector<mission::PlacedImage>& placed) {
  const cv::Size size = projection.image_size();
  const auto axis = vision::Ray(projection.camera(), {(size.width - 1) / 2.0, (size.height - 1) / 2.0});
  std::vector<Seen> images;
  auto next = placed.begin();
  for (const mission::LogRow& row : rows) {
    if (next == placed.end()) break;
    if (row.sequence != next->sequence) continue;
    const Pose& X_NC = row.exposure.X_NC;
    const Eigen::Vector3d ray_N = X_NC.R * axis.value_or(Eigen::Vector3d::UnitZ());
    if (ray_N.z() > 0) {
      const Eigen::Vector3d centre = X_NC.p - X_NC.p.z() / ray_N.z() * ray_N;
      images.push_back({row.exposure.t_s, X_NC.Inverse(), centre.head<2>(), next->M_WC});
    }
    ++next;
  }
  return images;
}

// What the mosaic makes of a place on the ground.
struct GroundPlace {
  Eigen::Vector2d ground_N, in_mosaic;  // m, px
  std::optional<Eigen::Vector2d> first,
      last;  // by the first and the last image that show it, if of two passes
};

std::optional<GroundPlace> PlaceIn(const std::vector<Seen>& images, const vision::Projection& projection,
                                   const Eigen::Vector2d& ground_N) {
  const cv::Size size = projection.image_size();
  const Eigen::Vector2d middle((size.width - 1) / 2.0, (size.height - 1) / 2.0);
  const Seen *first = nullptr, *last = nullptr;
  std::optional<Eigen::Vector2d> nearest, at_first, at_last;
  double nearest_px = std::numeric_limits<double>::infinity();
  for (const Seen& image : images) {
    const auto uv =
        vision::Project(projection.camera(), image.X_CN * Eigen::Vector3d(ground_N.x(), ground_N.y(), 0));
    if (!uv || !vision::InImage(size, *uv)) continue;
    const auto place = projection.ToSurface(image.M_WC, *uv);
    if (!place) continue;
    if (!first) first = &image, at_first = place;
    last = &image, at_last = place;
    if (const double px = (*uv - middle).norm(); px < nearest_px) nearest = place, nearest_px = px;
  }
  if (!nearest) return std::nullopt;
  GroundPlace found{ground_N, *nearest, std::nullopt, std::nullopt};
  if (last->t_s - first->t_s > kPass_s) found.first = at_first, found.last = at_last;
  return found;
}

// On a grid over the ground that was flown over.
std::vector<GroundPlace> PlacesOf(const std::vector<Seen>& images, const vision::Projection& projection) {
  Eigen::Vector2d low = images.front().centre_N, high = low;
  for (const Seen& image : images) low = low.cwiseMin(image.centre_N), high = high.cwiseMax(image.centre_N);
  std::vector<GroundPlace> places;
  for (int i = 0; i < kColumns; ++i)
    for (int j = 0; j < kRows; ++j) {
      const Eigen::Vector2d share((i + 0.5) / kColumns, (j + 0.5) / kRows);
      if (const auto place = PlaceIn(images, projection, low + share.cwiseProduct(high - low)))
        places.push_back(*place);
    }
  return places;
}

// None: they are too few or on a line.
std::optional<double> Rms_px(const std::vector<GroundPlace>& places) {
  std::vector<vision::PointPair> pairs;
  for (const GroundPlace& place : places) pairs.push_back({place.ground_N, place.in_mosaic});
  const auto H = vision::FitHomography(pairs);
  if (!H) return std::nullopt;
  mission::MeanSquare error;
  for (const vision::PointPair& pair : pairs) error.Add((vision::Transfer(*H, pair.from) - pair.to).norm());
  return error.Root();
}

void AddRms(const std::vector<mission::LogRow>& rows, const mission::FinishedMosaic& mosaic,
            const std::vector<mission::PlacedImage>& placed, const std::string& prefix,
            std::map<std::string, double>& metrics) {
  const std::vector<Seen> images = ImagesOf(rows, mosaic.projection, placed);
  if (images.empty()) return;
  const std::vector<GroundPlace> places = PlacesOf(images, mosaic.projection);
  const auto rms_px = Rms_px(places);
  if (!rms_px) return;
  metrics[prefix + "rms_px"] = *rms_px;
  mission::MeanSquare closure, georeference;
  for (const GroundPlace& place : places) {
    if (place.first) closure.Add((*place.last - *place.first).norm());
    if (prefix == "mosaic_" && mosaic.ground_from_surface)
      georeference.Add(
          (vision::Transfer(*mosaic.ground_from_surface, place.in_mosaic) - place.ground_N).norm());
  }
  if (closure.count > 0) metrics[prefix + "closure_px"] = closure.Root();
  if (georeference.count > 0) metrics["georeference_rmse_m"] = georeference.Root();
}

}  // namespace

std::vector<mission::Metric> SurveyMetrics() {
  return {
      {"mosaic_rms_px", "px", "RMS error of places on the ground in the mosaic, in its pixels"},
      {"mosaic_closure_px", "px", "RMS distance of two passes over a place in the mosaic"},
      {"chain_rms_px", "px", "RMS error of places on the ground, by images that are chained alone"},
      {"chain_closure_px", "px", "RMS distance of two passes over a place, by images that are chained alone"},
      {"georeference_rmse_m", "m", "RMS error of where the mosaic says on the map that places are"}};
}

void AddSurveyMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics) {
  for (const mission::LogRow& row : rows) {
    const auto* report = mission::ReportOf<mission::MosaicReport>(row.decision);
    if (!report || !report->finished) continue;
    AddRms(rows, *report->finished, report->finished->placed, "mosaic_", metrics);
    AddRms(rows, *report->finished, report->finished->chained, "chain_", metrics);
  }
}

}  // namespace kestrel::scenarios
