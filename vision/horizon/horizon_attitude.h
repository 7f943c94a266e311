// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vision/horizon/horizon_drawing.h"
#include "vision/horizon/skyline.h"
#include "vision/horizon/visual_compass.h"

namespace kestrel::vision {

// Attitude and heading from one camera, image by image: the skyline's raw "down", with the one thing that
// takes a memory (an image that is the last one over again tells nothing new), and the compass on top of it.
class HorizonAttitude {
 public:
  struct Measurement {
    SkylineResult skyline;
    std::optional<RollPitch> attitude;  // of B; none as skyline says
    std::optional<Eigen::Vector3d> down_B;
    Eigen::Matrix3d covariance_B = Eigen::Matrix3d::Zero();  // of down_B
    CompassResult compass;
  };

  HorizonAttitude(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden,
                  const SkylineOptions& skyline, const CompassOptions& compass);

  // What other sensors say, if they do, such as a filter with gyros; it helps to choose and to refuse and is
  // not mixed into the attitude. An image without a skyline gives its heading by the expected "down"; for
  // the turn see VisualCompass.
  struct Expected {
    std::optional<Eigen::Vector3d> down_B;
    double down_sigma = 0.05;        // rad
    std::optional<double> height_m;  // over the ground
    std::optional<double> turn;      // since the first image, rad
    double turn_sigma = 0.05;        // rad
  };
  Measurement Measure(const cv::Mat& image, const Expected& expected);
  Measurement Measure(const cv::Mat& image) { return Measure(image, Expected()); }

  cv::Mat Draw(const cv::Mat& image, const Measurement& measurement) const;
  std::vector<std::string> Words(const Measurement& measurement) const;  // as HorizonWords

 private:
  CameraModel camera_;
  Eigen::Matrix3d R_BC_;
  Skyline skyline_;
  VisualCompass compass_;
  std::optional<std::uint64_t> last_hash_;
};

}  // namespace kestrel::vision
