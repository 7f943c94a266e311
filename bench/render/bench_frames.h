// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// OpenGL by one backend (osmesa or egl) beside the ray renderer, by the clock on the wall: frames a second of one
// that draws and of `jobs` at once, of the landing's world, each read back to memory. And how far the pictures of
// three worlds differ, through a pinhole, a fisheye and a mirror; they are written to the folder, and held against
// those that a run with the other backend has left there. Poses depend on the seed.
void BenchFrames(std::uint64_t first_seed, std::uint64_t last_seed, int jobs, const std::string& opengl,
                 const std::filesystem::path& folder, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
