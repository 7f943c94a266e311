// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "flight/dataset/format/format.h"
#include "flight/dataset/format/sequence.h"

// Tables and calibration files that several formats have.
namespace kestrel::flight {

std::string ImuCsv(const std::vector<sim::ImuReading>& rows);  // as EuRoC's imu0
std::string TruthCsv(const std::vector<TruthRow>& rows);       // as its state_groundtruth_estimate0
// #timestamp [ns],label,u_min,v_min,u_max,v_max,pixels: a line for each thing in view, corners inclusive.
std::string BoxesCsv(const std::vector<FrameRow>& frames);

// Stamps in s with nine decimals.
std::string SecondsOf(std::int64_t stamp_ns);

// Kalibr's camchain.yaml and imu.yaml, in the folder of the sequence.
std::vector<SetFile> KalibrFiles(const Sequence& sequence);

// The rows of the 4 x 4 matrix of a pose, separated by commas.
std::string MatrixOf(const Pose& X);

}  // namespace kestrel::flight
