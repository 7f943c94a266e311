// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "flight/dataset/trajectory/way_file.h"
#include "geometry/pose.h"

namespace kestrel::flight {

// Poses with stamps, in W of conventions.h, by the ending of the file:
// - .csv as EuRoC's state_groundtruth_estimate0/data.csv: stamp in ns, p of the body, q w x y z, and anything
//   behind that, separated by commas;
// - .txt as TUM's groundtruth.txt: stamp in s, p of the camera, q x y z w, separated by blanks.
// What begins with # is passed over. X_BC: where the camera is on the body. The stamps stay as they are. Throws
// InputError with every mistake: too few poses, what is no number, quaternions that are not of length 1, stamps
// that do not rise.
LoadedTrajectory LoadPoses(const std::filesystem::path& file, const Pose& X_BC);
bool IsPoseFile(const std::filesystem::path& file);

}  // namespace kestrel::flight
