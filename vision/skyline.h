// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "vision/band_sampler.h"
#include "vision/circle_fit.h"
#include "vision/skyline_fix.h"
#include "vision/skyline_search.h"

namespace kestrel {

struct SkylineOptions {
  double max_tilt_deg = 60;      // of the aircraft: rules out what would be upside down
  int candidates = 5;            // directions of the overview that are looked at closely
  double most_sigma_deg = 2.5;   // of the tilt; worse is no answer
  double least_agreement = 0.5;  // of the contour with one circle; more where less of the circle is seen
  double most_rival = 0.9;       // a second answer so nearly as good makes it ambiguous
  double least_circle = 0.10;    // share of the azimuths with a contour
};

// Attitude from the skyline of one image of any central camera, thesis 6.3.1 to 6.3.3 in its purpose, not its
// means (SkylineBaseline has those): an overview of the sphere for candidates, the contour on their
// meridians, and a small circle under it, all by directions. Each image on its own.
class Skyline {
 public:
  // R_BC of the camera's mount. forbidden: CV_8UC1 of the image's size, not 0 where the aircraft itself is
  // seen; or empty.
  Skyline(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden,
          const SkylineOptions& options);

  // image: CV_8UC3 (blue, green, red) or CV_8UC1. expected_down_C: one more candidate, if something else
  // knows it, and what decides between two that are nearly as good.
  SkylineResult Measure(const cv::Mat& image,
                        const std::optional<Eigen::Vector3d>& expected_down_C = {}) const;

  const BandSampler& sampler() const { return sampler_; }

 private:
  struct Close {  // a candidate after a close look
    Horizontal horizontal;
    double support = 0, dip = 0;
    double shown = 0, found = 0;
  };
  std::optional<Close> LookClosely(const cv::Mat& half, const Eigen::Vector3d& down_C) const;
  SkylineResult Refine(const cv::Mat& image, const Close& close) const;

  CameraModel camera_;
  Eigen::Matrix3d R_BC_;
  SkylineOptions options_;
  BandSampler sampler_;
  SkylineSearch search_;
};

}  // namespace kestrel
