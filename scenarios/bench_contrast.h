// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "scenarios/bench.h"

namespace kestrel {

// Another aircraft found by its contrast to the sky (vision/contrast_tracker.h), through the fisheye that
// looks forward: balls of 0.5 m and 1 m, dark grey, white and red (models/targets/intruders.xml), come head
// on at 5 m/s from 60 m to 4 m, at bearings up to 60 degrees to either side and 1 to 25 degrees above the
// horizontal as they are reached, over each landscape; and a flight as long over each without any. The camera
// sways, flies at 2 to 60 m and the attitude that is given errs by 1 degree, slowly, and by 0.1 degree from
// image to image. At most five seeds; each draws another landscape of each kind. Printed as a table of its
// own, by landscape, size and colour; the figures are over all. out: a folder for pictures of false targets
// and of those that were found late; empty: none.
void BenchContrast(std::uint64_t first_seed, std::uint64_t last_seed, int jobs,
                   const std::filesystem::path& out, std::vector<Figure>& table);

}  // namespace kestrel
