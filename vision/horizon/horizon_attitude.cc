// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/horizon_attitude.h"

#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

namespace {

// Fowler, Noll, Vo 1a over whole words of every fourth row: noise changes each of them from image to image.
std::uint64_t HashOf(const cv::Mat& image) {
  std::uint64_t hash = 14695981039346656037u;
  const auto bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
  for (int y = 0; y < image.rows; y += 4) {
    const uchar* row = image.ptr<uchar>(y);
    for (std::size_t at = 0; at + 8 <= bytes; at += 8) {
      std::uint64_t word;
      std::memcpy(&word, row + at, 8);
      hash = (hash ^ word) * 1099511628211u;
    }
  }
  return hash;
}

}  // namespace

HorizonAttitude::HorizonAttitude(const CameraModel& camera, const Eigen::Matrix3d& R_BC,
                                 const cv::Mat& forbidden, const SkylineOptions& skyline,
                                 const CompassOptions& compass)
    : camera_(camera),
      R_BC_(R_BC),
      skyline_(camera, R_BC, forbidden, skyline),
      compass_(camera, R_BC, forbidden, compass) {}

HorizonAttitude::Measurement HorizonAttitude::Measure(const cv::Mat& image, const Expected& expected) {
  Measurement out{NoSkyline::kFrozen, {}, {}, Eigen::Matrix3d::Zero(), NoHeading::kNoVertical};
  const std::uint64_t hash = HashOf(image);
  const bool frozen = last_hash_ && *last_hash_ == hash;
  last_hash_ = hash;
  if (frozen) return out;
  SkylineExpected beforehand{{}, expected.down_sigma, expected.height_m};
  if (expected.down_B) beforehand.down_C = R_BC_.transpose() * *expected.down_B;
  cv::Mat colour = image;
  if (image.channels() == 1) cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  out.skyline = skyline_.Measure(colour, beforehand);
  std::optional<VisualCompass::Expected> turn;
  if (expected.turn) turn = {*expected.turn, expected.turn_sigma};
  if (const auto* fix = std::get_if<SkylineFix>(&out.skyline)) {
    out.down_B = R_BC_ * fix->down_C;
    out.covariance_B = R_BC_ * fix->covariance * R_BC_.transpose();
    out.attitude = RollPitchFromDown(*out.down_B, out.covariance_B);
    out.compass = compass_.Turn(colour, fix->down_C, turn);
  } else if (beforehand.down_C && expected.down_sigma < Radians(3)) {
    out.compass = compass_.Turn(colour, beforehand.down_C, turn);
  }
  return out;
}

cv::Mat HorizonAttitude::Draw(const cv::Mat& image, const Measurement& m) const {
  return DrawHorizon(image, camera_, R_BC_, m.skyline, m.compass);
}

std::vector<std::string> HorizonAttitude::Words(const Measurement& m) const {
  return HorizonWords(R_BC_, m.skyline, m.compass);
}

}  // namespace kestrel::vision
