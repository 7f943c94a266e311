// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// Another aircraft found by its contrast to the sky (vision/target/contrast_tracker.h), through the fisheye
// that looks forward: balls of 0.5 m and 1 m, dark grey, white and red (models/targets/intruders.xml), six at
// once, come head on at 5 m/s from 60 m to 4 m, at bearings up to 67 degrees to either side and 1 to 25
// degrees high, over each landscape; and a flight as long over each without any. The camera sways, at 5 to 60
// m over the ground; the attitude that is given errs by 1 degree, slowly, and by 0.1 degree from image to
// image; each pixel by 2 grey levels. At most five seeds; each draws another landscape of each kind.
//
// Printed as a table of its own, by landscape, size and colour, of those with nothing but sky right around
// them all the time; all others are one row. Bearings are judged in C, so that the attitude's error is not in
// them. The figures are over all landscapes. out: a folder for pictures of false targets and of what is
// missed; empty: none.
void BenchContrast(std::uint64_t first_seed, std::uint64_t last_seed, int jobs,
                   const std::filesystem::path& out, std::vector<records::Figure>& table);

}  // namespace kestrel::bench
