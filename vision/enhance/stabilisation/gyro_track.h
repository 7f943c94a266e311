// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace kestrel::vision {

struct GyroSample {
  double t_s = 0;
  Eigen::Vector3d w_C = Eigen::Vector3d::Zero();  // rad/s, in C
};

// The attitude of a camera by its gyro: R_NC, where N is C at the first sample. The rate goes on evenly between two
// samples. What the gyro has of a bias remains in it as a slow turn.
class GyroTrack {
 public:
  // In the order of time, which the samples have; one that is not later than that before it is left out. A gap longer
  // than max_gap_s is none of the track.
  explicit GyroTrack(double max_gap_s = 0.1) : max_gap_s_(max_gap_s) {}
  explicit GyroTrack(const std::vector<GyroSample>& samples, double max_gap_s = 0.1);
  void Add(const GyroSample& sample);

  bool empty() const { return nodes_.empty(); }
  double begin_s() const { return nodes_.front().t_s; }
  double end_s() const { return nodes_.back().t_s; }

  // None: before the first sample, after the last one, or in a gap.
  std::optional<Eigen::Quaterniond> At(double t_s) const;
  // While the rows of an image were exposed: at `times` even times about the middle row's, from readout_s / 2 before to
  // readout_s / 2 after it. Negative: the last row is exposed first. Empty: not all of them are known.
  std::vector<Eigen::Quaterniond> Rows(double t_s, double readout_s, int times = 16) const;

 private:
  struct Node {
    double t_s;
    Eigen::Vector3d w_C;
    Eigen::Quaterniond R_NC;
  };
  double max_gap_s_;
  std::vector<Node> nodes_;
};

}  // namespace kestrel::vision
