// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vision/calibration/calibrate.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel calibrate`: a camera from images of a board.
struct CalibrateArguments {
  std::vector<std::string> images;
  std::string board = "chessboard", model, out;
  std::optional<int> bits;            // of 16-bit pixels
  std::optional<double> accepted_px;  // none: vision::AcceptedResidual
};

CLI::App* AddCalibrateCommand(CLI::App& app, CalibrateArguments& arguments);

// Finds the board in every image, calibrates, and writes to the folder what app/camera/calibration_report.h
// says. Throws InputError: images that cannot be read or differ in size, all of them by name, or that do not
// determine the camera, or leave more residual than is accepted; then nothing is written.
void CalibrateCommand(const CalibrateArguments& arguments);

}  // namespace kestrel::app
