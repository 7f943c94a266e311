// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "flight/dataset/plan.h"

// Data sets: images with what is truly in them, IMU, truth and calibration, in a format that others read.
namespace kestrel::flight {

struct DatasetResult {
  std::size_t sequences = 0, frames = 0, files = 0;
  std::size_t found = 0;  // frames that were there already
  std::uint64_t bytes = 0;
};

// Makes the set in its folder, or goes on with it where it was broken off. The bytes are the same for any
// number of jobs. Last comes manifest.json: each file with its size and its XXH128, the settings, the
// seeds. Throws std::runtime_error where it breaks off, such as by a full disk: what is written stays, and
// is gone on from.
DatasetResult MakeDataset(const DatasetPlan& plan);

}  // namespace kestrel::flight
