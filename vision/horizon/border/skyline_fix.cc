// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/border/skyline_fix.h"

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
    case NoSkyline::kNoLine:
      return "no_clear_line";
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

const char* MeaningOf(NoSkyline reason) {
  switch (reason) {
    case NoSkyline::kWrongSize:
      return "the image has another size than the camera's file";
    case NoSkyline::kTooDark:
      return "nearly all of the image is black";
    case NoSkyline::kWhiteOut:
      return "nearly all of the image is saturated";
    case NoSkyline::kNoContrast:
      return "the image is one even surface";
    case NoSkyline::kNoSky:
      return "what is seen looks like ground alone";
    case NoSkyline::kNoGround:
      return "what is seen looks like sky alone";
    case NoSkyline::kHazy:
      return "sky and ground melt into each other";
    case NoSkyline::kUneven:
      return "the border between sky and ground is no even line: hills, trees or houses stand along it";
    case NoSkyline::kNoLine:
      return "the line that is likest to a horizon is as likely something else";
    case NoSkyline::kAmbiguous:
      return "two lines are nearly as likely to be the horizon";
    case NoSkyline::kUpsideDown:
      return "ground is seen above and sky below; a camera mounted so wants --mount-yaw-deg, "
             "--mount-pitch-deg "
             "and --mount-roll-deg";
    case NoSkyline::kTooLittle:
      return "too little of the skyline is seen, or it is tilted by more than an aircraft is";
    case NoSkyline::kImplausible:
      return "the skyline lies too far from where it was expected";
    case NoSkyline::kFrozen:
      return "it is the image before over again";
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
