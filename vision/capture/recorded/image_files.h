// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace kestrel::vision {

// The image files of a folder, or those of them whose names a pattern with one number matches
// ("image%04d.png"), or the one file alone: by name, numbers in the names by their value. What is not an image,
// nor named as one, is passed over.
std::vector<std::filesystem::path> ImageFilesOf(const std::filesystem::path& images);

// The folders in a folder, by name.
std::vector<std::filesystem::path> FoldersIn(const std::filesystem::path& folder);

}  // namespace kestrel::vision
