// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <variant>
#include <vector>

#include "vision/camera_model.h"
#include "vision/skyline_fix.h"

namespace kestrel {

// Where "down" could be, without any guess: every direction within reach is scored by how much better two
// bodies of colour and roughness, one on either side of its horizon, explain the image than one does (after
// Ettinger et al. 2002, on the sphere).
class SkylineSearch {
 public:
  struct Candidate {
    Eigen::Vector3d down_C;
    double score = 0;                     // nats per cell
    double sky_above = 0, sky_below = 0;  // whether its two sides look more like sky (over 0) or ground
  };
  // What the whole picture looks like, and the best directions, well apart.
  struct Overview {
    double dark = 0, white = 0;  // share of the cells
    double spread = 0;           // of the grey between cells, of 255
    double rough = 0;            // median of the grey's deviation within a cell
    double sky = 0;              // more like sky than like ground, on the whole: over 0
    std::vector<Candidate> candidates;
  };

  // down_C: of a level aircraft; only directions within max_tilt of it are tried.
  SkylineSearch(const CameraModel& camera, const cv::Mat& forbidden, const Eigen::Vector3d& down_C,
                double max_tilt);

  // half: the image (CV_8UC3) at half its size.
  Overview Look(const cv::Mat& half, std::size_t most) const;

  // Share of the view that lies above the horizontal of a "down", of what lies well off it.
  double ShareAbove(const Eigen::Vector3d& down_C) const;

 private:
  static constexpr int kFeatures = 4;  // blue, green, red, roughness
  static constexpr int kMoments = 16;  // 1, the features, their ten products; padded
  struct Cell {
    cv::Rect place;  // in the half image
    Eigen::Vector3f ray;
    float weight;  // solid angle
  };
  struct Split {
    Eigen::Vector3d down_C;
    std::vector<int> sky, ground;  // cells
  };

  std::vector<Cell> cells_;
  std::vector<Split> splits_;
};

}  // namespace kestrel
