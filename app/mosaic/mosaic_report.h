// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/mosaic/mosaic_command.h"
#include "app/simulated/interlace_watch.h"
#include "vision/enhance/mosaic/mosaic.h"

// What `kestrel mosaic` says to people.
namespace kestrel::app {

struct MosaicCount {
  InterlaceWatch interlace;
  int frames = 0, placed = 0, without_pose = 0, below_ground = 0, against_pose = 0, poses_over = 0;
  double read_s = 0, add_s = 0;
  std::map<std::string, int> of_state;  // images, by what became of them
  std::string broke_off;
  // Images that have a place beside others. The first of a mosaic has it by itself.
  int joined() const;
};

// What becomes of memory is said before it is used.
std::string MosaicMemory(int memory_mb, const vision::MosaicOptions& options, const cv::Size& size);

// What became of the images, and what to do about those that are in no mosaic. written: a sentence for each picture.
std::string MosaicReport(const MosaicArguments& arguments, const MosaicCount& count, double compose_s,
                         const std::vector<std::string>& written);

}  // namespace kestrel::app
