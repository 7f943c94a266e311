// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel render-board`: images of a board as a camera sees it, with the truth about both beside them, to
// try a calibration on.
struct RenderBoardArguments {
  std::string camera, camera_name, board = "chessboard", out;
  int count = 30;
  std::uint64_t seed = 1;
  double blur_px = 0.3, noise_grey = 2;
  std::string backend = "auto";
};

CLI::App* AddRenderBoardCommand(CLI::App& app, RenderBoardArguments& arguments);

// Writes to the folder: image_000.png and so on; to_print/board.png, the board's picture, and board.yaml,
// Kalibr's target file of it; truth.yaml, the camera as Kalibr's camchain with the poses of the board. Throws
// InputError with every mistake.
void RenderBoardCommand(const RenderBoardArguments& arguments);

}  // namespace kestrel::app
