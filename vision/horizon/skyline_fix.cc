// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/skyline_fix.h"

#include <algorithm>
#include <cmath>

namespace kestrel::vision {

const char* NameOf(NoSkyline reason) {
  switch (reason) {
    case NoSkyline::kWrongSize:
      return "wrong_size";
    case NoSkyline::kTooDark:
      return "too_dark";
    case NoSkyline::kWhiteOut:
      return "white_out";
    case NoSkyline::kNoContrast:
      return "no_contrast";
    case NoSkyline::kNoSky:
      return "no_sky";
    case NoSkyline::kNoGround:
      return "no_ground";
    case NoSkyline::kHazy:
      return "hazy_skyline";
    case NoSkyline::kUneven:
      return "uneven_skyline";
    case NoSkyline::kAmbiguous:
      return "ambiguous";
    case NoSkyline::kUpsideDown:
      return "upside_down";
    case NoSkyline::kTooLittle:
      return "too_little_skyline";
    case NoSkyline::kImplausible:
      return "implausible";
    case NoSkyline::kFrozen:
      return "frozen";
  }
  return "";
}

RollPitch RollPitchFromDown(const Eigen::Vector3d& d, const Eigen::Matrix3d& covariance_B) {
  RollPitch out;
  out.roll = std::atan2(d.y(), d.z());
  out.pitch = std::atan2(-d.x(), std::hypot(d.y(), d.z()));
  const double across2 = std::max(1e-12, d.y() * d.y() + d.z() * d.z());
  Eigen::Matrix<double, 2, 3> J;  // on the unit sphere, so the derivative along d does not matter
  J << 0, d.z() / across2, -d.y() / across2, -1 / std::sqrt(across2), 0, 0;
  out.covariance = J * covariance_B * J.transpose();
  return out;
}

}  // namespace kestrel::vision
