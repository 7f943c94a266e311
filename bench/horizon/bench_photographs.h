// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "records/figures.h"
#include "vision/camera/pinhole.h"

namespace kestrel::bench {

// A photograph, and where its horizon is if somebody has said so: y = slope x + offset height, px; or that there is
// none in it.
struct Photograph {
  std::filesystem::path file;
  std::string flight;  // its name up to the last "_", of which there may be many photographs
  bool labelled = false, none = false;
  double slope = 0, offset = 0;
};

// The .jpg, .jpeg and .png files of a folder by their names, with the labels of its label.csv, if there is one
// (filename,slope,offset; none,none: there is no horizon in it). Mistakes: no such folder, no photograph, a line that cannot be read.
std::vector<Photograph> ReadPhotographs(const std::filesystem::path& folder, Mistakes& mistakes);

// A pinhole with that field of view along the longer side.
vision::Pinhole PhotographCamera(const cv::Size& size, double fov_deg);
// "Down" of a label: the plane through the eye and its line.
Eigen::Vector3d LabelledDown(const Photograph& photograph, const vision::Pinhole& camera);

// Attitude from each photograph alone, through a pinhole that looks ahead with that field of view along the longer
// side: by flight how many are answered, how far off, and why the others are refused. In the folder
// `out`: photographs.csv with a row for each, and each photograph with what was seen in it.
void BenchPhotographs(const std::vector<Photograph>& photographs, double fov_deg,
                      const std::filesystem::path& out, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
