// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "vision/horizon/band_sampler.h"
#include "vision/horizon/border/skyline_fix.h"
#include "vision/horizon/border/straight_skyline.h"
#include "vision/horizon/circle_fit.h"
#include "vision/horizon/skyline_search.h"

namespace kestrel::vision {

struct SkylineOptions {
  double max_tilt_deg = 60;    // of the aircraft: rules out what would be upside down
  int candidates = 4;          // directions of the overview that are looked at closely
  double max_sigma_deg = 2.5;  // of the tilt; worse is no answer
  // Of the contour with one circle; more where less of the circle is seen. The second where "down" was
  // expected: then less has to be told from the contour.
  double min_agreement = 0.55, min_agreement_expected = 0.35;
  double max_rival = 0.85;   // a second answer so nearly as good makes it ambiguous
  double min_circle = 0.10;  // share of the azimuths with a contour
  double gate = 3;           // deviations from what is expected, beyond which an answer is refused
};

// What else is known at the time of the image. It says where to look and what to refuse, and is not mixed
// into the measurement.
struct SkylineExpected {
  std::optional<Eigen::Vector3d> down_C;
  double down_sigma = 0.05;        // rad
  std::optional<double> height_m;  // over the ground: tells the dip of the horizon
};

// Attitude from the skyline of one image of any central camera, thesis 6.3.1 to 6.3.3 in its purpose, not its
// means (SkylineBaseline has those): an overview of the sphere for candidates, the contour on their
// meridians, and a small circle under it, all by directions. Each image on its own. Through a lens that looks
// one way, and with nothing expected, it is the straight line of StraightSkyline instead.
class Skyline {
 public:
  // R_BC of the camera's mount. forbidden: CV_8UC1 of the image's size, not 0 where the aircraft itself is
  // seen; or empty.
  Skyline(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden,
          const SkylineOptions& options);

  // image: CV_8UC3 (blue, green, red) or CV_8UC1. If "down" is expected, its horizon is looked at first; all
  // others only if nothing is found there.
  SkylineResult Measure(const cv::Mat& image, const SkylineExpected& expected = {}) const;

  const BandSampler& sampler() const { return sampler_; }

 private:
  struct Close {  // a candidate after a close look
    Horizontal horizontal;
    double support = 0, dip = 0;
  };
  struct Refined {
    SkylineResult result;
    double quality = 0;  // about 0 to 1
    double in_view = 0;  // of the circle, share of the azimuths
  };
  std::optional<Close> LookClosely(const cv::Mat& half, const Eigen::Vector3d& down_C) const;
  Refined Refine(const cv::Mat& image, const Close& close, const SkylineExpected& expected) const;

  CameraModel camera_;
  Eigen::Matrix3d R_BC_;
  SkylineOptions options_;
  BandSampler sampler_;
  SkylineSearch search_;
  std::optional<StraightSkyline> straight_;  // of a lens that suits it, for images alone
  bool one_sided_ = false;  // the lens sees no more than an arc of a level aircraft's horizon
};

}  // namespace kestrel::vision
