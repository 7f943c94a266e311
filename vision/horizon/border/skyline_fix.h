// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <variant>
#include <vector>

// What the skyline says of the attitude, thesis 6.3.
namespace kestrel::vision {

// A place on the contour between sky and ground.
struct SkylineRay {
  Eigen::Vector3d ray_C;
  double weight = 0;  // how far it is taken for the horizon and not for what stands before it, 0 to 1
};

// "Down" as one image gives it, without memory of any other.
struct SkylineFix {
  Eigen::Vector3d down_C;      // unit vector
  Eigen::Matrix3d covariance;  // of down_C, rad^2; of rank 2: none along down_C
  double dip = 0;              // of the horizon below the horizontal, rad
  double circle_seen = 0;      // share of the azimuths in which the contour was found, 0 to 1
  double agreement = 0;        // share of those whose contour lies within a degree of the fitted circle
  double contrast = 0;         // of sky and ground at the contour, median, grey levels of all channels
  double rival = 0;            // how nearly as good the best answer elsewhere is, 0 to 1
  std::vector<SkylineRay> points;
};

// Why an image gives no attitude.
enum class NoSkyline {
  kWrongSize,  // of the image: the calibration is not this camera's
  kTooDark,
  kWhiteOut,     // nearly all of it saturated
  kNoContrast,   // one even surface: a capped lens, dense fog
  kNoSky,        // ground alone in view
  kNoGround,     // sky alone in view
  kHazy,         // sky and ground melt into each other: where the horizon is cannot be seen
  kUneven,       // the contour lies on no one circle: hills or houses nearly all round
  kNoLine,       // what is likest to a horizon is not likely to be one
  kAmbiguous,    // two answers are nearly as good
  kUpsideDown,   // ground above, sky below
  kTooLittle,    // so little of the skyline is seen that its tilt is not known
  kImplausible,  // what is seen lies too far from what was expected
  kFrozen,       // the very image of the last time: only a wrapper with a memory says so
};
const char* NameOf(NoSkyline reason);
const char* MeaningOf(NoSkyline reason);  // what was seen, and a remedy where there is one

using SkylineResult = std::variant<SkylineFix, NoSkyline>;

// From "down" in B, rad: that of R_NB is (-sin(pitch), sin(roll) cos(pitch), cos(roll) cos(pitch)). Thesis
// (6.16) prints arccosines of the components of the normal, which give 90 degrees for level flight: meant are
// the complements, and the second is the roll only at pitch 0.
struct RollPitch {
  double roll = 0, pitch = 0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of (roll, pitch), rad^2
};
RollPitch RollPitchFromDown(const Eigen::Vector3d& down_B,
                            const Eigen::Matrix3d& covariance_B = Eigen::Matrix3d::Zero());

}  // namespace kestrel::vision
