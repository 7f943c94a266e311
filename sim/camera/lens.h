// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>

#include "base/yaml/fields.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// What a lens does to the light beyond the geometry of its camera model.
struct LensParameters {
  // Vignetting: light falls off as cos^cos_power of the angle between the ray and the axis (4: the natural
  // law of a plain lens), times 1 + a r^2 + b r^4 + c r^6 for vignetting = [a, b, c], r being the distance
  // from the principal point over half the diagonal of the image. Never below 0.
  double cos_power = 0;
  Eigen::Vector3d vignetting = Eigen::Vector3d::Zero();
  double defocus_px = 0;             // standard deviation of the Gaussian, or radius of the disc
  std::string defocus = "gaussian";  // or disc: what a point is spread over
  double rim_px = 0;          // radius of the lens's or the mirror's image about the principal point; 0: none
  double reflection_deg = 0;  // a mirror shows the camera itself, dark, up to this angle from the axis
};

inline void Fields(FieldVisitor& v, LensParameters& p) {
  v({"cos_power",
     "light falls off as this power of the cosine of the angle to the axis; 4: the natural law, 0: not at "
     "all"},
    p.cos_power, 0.0, 16.0);
  v({"vignetting",
     "a, b, c of the factor 1 + a r^2 + b r^4 + c r^6, r: distance from the principal point over half the "
     "diagonal"},
    p.vignetting, -4.0, 4.0);
  v({"defocus_px",
     "standard deviation of the Gaussian, or radius of the disc, over which a point is spread; 0: in focus"},
    p.defocus_px, 0.0, 20.0);
  v({"defocus", "what a point is spread over"}, p.defocus, {"gaussian", "disc"});
  v({"rim_px",
     "radius of the lens's or mirror's image about the principal point, outside of which all is dark; 0: "
     "none"},
    p.rim_px, 0.0, 1e4);
  v({"reflection_deg", "angle from the axis up to which a mirror shows the camera itself, dark; 0: none"},
    p.reflection_deg, 0.0, 90.0);
}

// The share of the light that reaches each pixel, CV_32FC1; the edges of rim and reflection are smooth over a
// pixel. Empty: all of it reaches all of them.
cv::Mat Shade(const LensParameters& lens, const vision::CameraModel& camera);

// Spreads each pixel of an image of floats over its neighbours. Beyond the border the image goes on as at it.
class Defocus {
 public:
  explicit Defocus(const LensParameters& lens);
  bool sharp() const { return kernel_.empty(); }
  cv::Mat Spread(const cv::Mat& light) const;

 private:
  cv::Mat kernel_;  // of the disc: both ways; of the Gaussian: one way
};

}  // namespace kestrel::sim
