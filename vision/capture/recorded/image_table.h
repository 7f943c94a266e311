// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/diagnostics.h"

// The tables of data sets that say when each image was taken.
namespace kestrel::vision {

struct StampedImage {
  std::int64_t stamp_ns = 0;
  std::filesystem::path file;
};

// Rows "stamp in ns,name in data/" of a camera of EuRoC: camera_folder/data.csv.
std::vector<StampedImage> ReadEurocTable(const std::filesystem::path& camera_folder, Mistakes& mistakes);

// Rows "stamp in s, path from the table's folder" of TUM: rgb.txt.
std::vector<StampedImage> ReadTumTable(const std::filesystem::path& table, Mistakes& mistakes);

// Rows "stamp in s" of KITTI, one for each of the images: times.txt.
std::vector<StampedImage> ReadKittiTable(const std::filesystem::path& table,
                                         const std::vector<std::filesystem::path>& images,
                                         Mistakes& mistakes);

}  // namespace kestrel::vision
