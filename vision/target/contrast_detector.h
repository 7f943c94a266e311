// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/camera/camera_model.h"
#include "vision/horizon/sky_mask.h"
#include "vision/target/balloon_fit.h"
#include "vision/target/contrast_blob.h"

namespace kestrel::vision {

struct ContrastDetectorOptions {
  double min_contrast = 16;
  double light_factor = 2.5;
  double min_diameter_px = 1.6;
  double max_diameter_px = 60;
  double margin_deg = 0.7;
  double min_score = 9;
  double max_aspect = 3;
  double min_fill = 0.6;
  double min_sharpness = 0.45;  // SharpnessOf
  int max_candidates = 12;      // half as many in the coarse ones
};

inline void Fields(FieldVisitor& v, ContrastDetectorOptions& o) {
  v(Renamed("min_contrast", "least_contrast",
            "minimum contrast with the sky in the strongest channel, in grey levels of 255"),
    o.min_contrast, 1.0, 200.0);
  v({"light_factor", "factor on min_contrast for what is lighter than the sky, as clouds are"},
    o.light_factor, 1.0, 20.0);
  v(Renamed("min_diameter_px", "least_diameter_px", "minimum diameter of a detection"), o.min_diameter_px,
    1.0, 50.0);
  v(Renamed("max_diameter_px", "most_diameter_px", "maximum diameter of a detection"), o.max_diameter_px, 2.0,
    70.0);
  v({"margin_deg", "strip above the skyline in which nothing is looked for"}, o.margin_deg, 0.0, 20.0);
  v(Renamed("min_score", "least_score", "minimum contrast in standard deviations of the sky right around"),
    o.min_score, 1.0, 1000.0);
  v(Renamed("max_aspect", "most_aspect", "maximum ratio of length to width of a detection"), o.max_aspect,
    1.0, 20.0);
  v(Renamed("min_fill", "least_fill",
            "minimum share of the ellipse of its second moments that a detection fills, 0 to 1"),
    o.min_fill, 0.0, 1.0);
  v(Renamed("min_sharpness", "least_sharpness",
            "minimum edge sharpness of detections from 8 px on: a solid thing has about 1, a cloud less"),
    o.min_sharpness, 0.0, 2.0);
  v(Renamed("max_candidates", "most_candidates",
            "maximum number of candidates measured in each of five image sizes; bounds the computing time"),
    o.max_candidates, 1, 1000);
}

enum class SkySearchState {
  kSearched,  // detections or none
  kNoSky,     // none in view above the contour
  kTooDark,   // where the sky should be
  kWhiteOut,  // nearly all of the sky saturated
  kBadImage   // not CV_8UC3 or CV_8UC1 of the camera's size, or "down" is no unit vector
};
const char* NameOf(SkySearchState state);

struct ContrastDetection {
  OutlineCone cone;                                     // around the thing's solid angle, as if it were round
  double axis_sigma = 0;                                // rad, along one side
  double half_angle_sigma = 0;                          // rad
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  // of its area in the image
  double diameter_px = 0;                               // of the circle of its area
  double contrast = 0;  // its mean inside less the sky around, grey levels; under 0: darker
  double score = 0;     // strongest contrast of any channel, in deviations of the sky right around
};

struct SkySearch {
  SkySearchState state = SkySearchState::kBadImage;
  std::vector<ContrastDetection> detections;  // by their score, best first
};

// Compact things before the sky, of any colour that is not the sky's: other aircraft. Each image on its own.
//
// A place is a candidate if its mean over 3 x 3 px is darker, or lighter, than those of all eight places
// around it, 4 px off, in the blue or the red channel: the local contrast measure of infrared search (Chen et
// al. 2014; Wei et al. 2016), on a pyramid of five sizes. Edges and ridges of clouds have no such contrast on
// all sides. Each candidate is then measured as a blob (vision/target/contrast_blob.h), which tells the sun's
// glow, clouds, and what hangs together with the ground.
class ContrastDetector {
 public:
  // forbidden: CV_8UC1 of the image's size, not 0 where the aircraft itself is seen; or empty.
  ContrastDetector(const CameraModel& camera, const cv::Mat& forbidden,
                   const ContrastDetectorOptions& options);

  // image: CV_8UC3 (blue, green, red) or CV_8UC1. down_C: unit vector, down_sigma its deviation, rad.
  // expected: where things are known to be, in C: right around them what stands up from the ground counts as
  // sky, as the contour may have taken them for the ground when they are near it. They are looked for as all
  // others.
  SkySearch Search(const cv::Mat& image, const Eigen::Vector3d& down_C, double down_sigma,
                   const std::vector<OutlineCone>& expected = {}) const;

  const CameraModel& camera() const { return camera_; }

 private:
  struct Candidate {
    cv::Point place;  // in its level
    int level = 0;
    int response = 0;
  };
  std::optional<ContrastDetection> Measured(const Blob& blob, int level, double sigma_px) const;

  CameraModel camera_;
  ContrastDetectorOptions options_;
  SkyMask mask_;
};

}  // namespace kestrel::vision
