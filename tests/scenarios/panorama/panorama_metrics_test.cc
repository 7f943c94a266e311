// SPDX-License-Identifier: Apache-2.0
#include "scenarios/panorama/panorama_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "geometry/tait_bryan.h"
#include "mission/mosaic/mosaic_report.h"

namespace kestrel::scenarios {
namespace {

const vision::Pinhole kCamera{640, 480, 800, 800, 319.5, 239.5};

// A turn of 380 degrees in steps of one, of a camera that looks ahead; in the panorama each image is turned about
// the vertical by error(turned in degrees), in degrees.
std::map<std::string, double> MetricsOf(const std::function<double(int)>& error_deg) {
  Eigen::Matrix3d looks_ahead;
  looks_ahead << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const Eigen::Matrix3d R_WN = RotationFromTaitBryan({0.4, -0.2, 1});
  mission::FinishedMosaic finished{{kCamera, vision::Surface::kSphere, kCamera.fx}, {}, {}, std::nullopt};
  std::vector<mission::LogRow> rows;
  for (int i = 0; i <= 380; ++i) {
    mission::LogRow row;
    row.sequence = i;
    row.exposure.X_NB.R = Eigen::Quaterniond(RotationFromTaitBryan({Radians(100 + i), 0.02, -0.03}));
    row.exposure.X_NC.R = row.exposure.X_NB.R * Eigen::Quaterniond(looks_ahead);
    finished.placed.push_back({i, R_WN * HeadingRotation(Radians(error_deg(i))).toRotationMatrix() *
                                      row.exposure.X_NC.R.toRotationMatrix()});
    row.decision.report = std::make_shared<mission::MosaicReport>();
    rows.push_back(row);
  }
  auto last = std::make_shared<mission::MosaicReport>();
  last->finished = std::make_shared<mission::FinishedMosaic>(finished);
  rows.back().decision.report = last;
  std::map<std::string, double> metrics;
  AddPanoramaMetrics(rows, metrics);
  return metrics;
}

TEST(PanoramaMetrics, ATrueOneHasNoErrorsHoweverItLies) {
  const auto metrics = MetricsOf([](int) { return 0; });
  EXPECT_LT(metrics.at("panorama_rms_deg"), 1e-6);
  EXPECT_LT(metrics.at("panorama_closure_deg"), 1e-5);
  EXPECT_FALSE(metrics.count("chain_rms_deg"));
}

TEST(PanoramaMetrics, ADriftDoesNotClose) {
  const auto metrics = MetricsOf([](int turned) { return 0.5 * turned / 360; });
  EXPECT_NEAR(metrics.at("panorama_closure_deg"), 0.5, 0.01);
  // The yaw of directions near the horizon: that of a ramp of 0.528 degrees about its mean.
  EXPECT_NEAR(metrics.at("panorama_rms_deg"), 0.5 * 380 / 360 / std::sqrt(12), 0.01);
}

TEST(PanoramaMetrics, OneImageThatIsOffIsSeen) {
  const auto metrics = MetricsOf([](int turned) { return turned == 50 ? 3 : 0; });
  EXPECT_NEAR(metrics.at("panorama_rms_deg"), 3 / std::sqrt(381.0), 0.02);
  EXPECT_LT(metrics.at("panorama_closure_deg"), 1e-5);
}

}  // namespace
}  // namespace kestrel::scenarios
