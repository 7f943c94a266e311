// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <variant>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/horizon/border/skyline_fix.h"

namespace kestrel::vision {

// Where "down" could be, without any guess: every direction within reach is scored by how much better two
// bodies of colour and roughness, one on either side of its horizon, explain the image than one does (after
// Ettinger et al. 2002, on the sphere).
class SkylineSearch {
  static constexpr int kMoments = 16;  // 1, the features, their ten products; padded

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
    std::vector<std::array<float, kMoments>> moments;  // of the cells
  };
  // What lies above a horizon and below it: more like sky (over 0) or like ground. Near: the strip right
  // above it; far: all above that strip.
  struct Sides {
    double above = 0, below = 0, near = 0, far = 0;
    double strip_apart = 0;  // near from far, nats per cell
  };

  // down_C: of a level aircraft; only directions within max_tilt of it are tried.
  SkylineSearch(const CameraModel& camera, const cv::Mat& forbidden, const Eigen::Vector3d& down_C,
                double max_tilt);

  // half: the image (CV_8UC3) at half its size.
  Overview Look(const cv::Mat& half, std::size_t most) const;

  Sides SidesOf(const Overview& overview, const Eigen::Vector3d& down_C, double dip) const;

  // Share of the view that lies above the horizontal of a "down", of what lies well off it.
  double ShareAbove(const Eigen::Vector3d& down_C) const;

 private:
  static constexpr int kFeatures = 4;  // blue, green, red, roughness
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

}  // namespace kestrel::vision
