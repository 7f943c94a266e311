// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>

#include "base/yaml/fields.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// What a lens does to the light beyond the geometry of its camera model.
// Soft dark spots, where grains lie on the lens or before the sensor.
struct DustParameters {
  int count = 0;          // of grains; their places are drawn by the seed
  double size_px = 6;     // standard deviation of the Gaussian of a spot
  double darkness = 0.3;  // of its middle
};

inline void Fields(FieldVisitor& v, DustParameters& p) {
  v({"count", "grains of dust on the lens, at places drawn by the seed"}, p.count, 0, 10000);
  v({"size_px", "size of a grain's spot: standard deviation of its Gaussian"}, p.size_px, 0.3, 500.0);
  v({"darkness", "share of the light that the middle of a spot loses"}, p.darkness, 0.0, 1.0);
}

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
  double glare = 0;  // share of the light that spreads over all of the image (veiling glare, ISO 18844)
  DustParameters dust;
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
  v({"glare", "share of the light that spreads evenly over the image: flare, haze on the lens"}, p.glare, 0.0,
    0.9);
  v({"dust", "dust on the lens"}, p.dust);
}

// The share of the light that reaches each pixel, CV_32FC1; the edges of rim and reflection are smooth over a
// pixel. seed: of the dust. Empty: all of it reaches all of them.
cv::Mat Shade(const LensParameters& lens, const vision::CameraModel& camera, std::uint64_t seed = 1);

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
