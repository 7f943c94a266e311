// SPDX-License-Identifier: Apache-2.0
#include "app/camera/calibrate_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <thread>

#include "app/camera/calibration_report.h"
#include "app/option/bits_option.h"
#include "app/option/one_of.h"
#include "app/option/within.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/in_parallel.h"
#include "vision/calibration/board/board_file.h"
#include "vision/calibration/calibrate.h"
#include "vision/image_file.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

// Grey images of one size and one depth. What is not is a mistake.
std::vector<cv::Mat> ReadImages(const CalibrateArguments& a, Mistakes& mistakes) {
  const std::vector<std::string>& files = a.images;
  std::vector<vision::ImageFile> read;
  vision::PixelDepth depth(a.bits);
  for (const std::string& file : files) {
    const vision::ImageFile& image =
        read.emplace_back(vision::ReadImageFile(file, vision::ImageColours::kGrey));
    const std::string error = image.pixels.empty() ? image.error : depth.Include(image);
    if (!error.empty()) mistakes.Add(file, "", error);
  }
  if (depth.guessed()) fmt::print("{}\n", depth.Note());
  std::vector<cv::Mat> images;
  std::map<std::pair<int, int>, int> sizes;
  for (vision::ImageFile& image : read) {
    if (!image.pixels.empty()) ++sizes[{image.pixels.cols, image.pixels.rows}];
    images.push_back(image.pixels.empty() ? cv::Mat() : depth.EightBits(image));
    image.pixels.release();
  }
  if (sizes.size() > 1) {
    const auto usual = std::max_element(sizes.begin(), sizes.end(),
                                        [](const auto& x, const auto& y) { return x.second < y.second; });
    const auto [width, height] = usual->first;
    for (std::size_t i = 0; i < files.size(); ++i) {
      if (images[i].empty() || (images[i].cols == width && images[i].rows == height)) continue;
      mistakes.Add(
          files[i], "",
          fmt::format("{} x {} pixels, where others have {} x {}: images of one camera have one size",
                      images[i].cols, images[i].rows, width, height));
    }
  }
  return images;
}

}  // namespace

CLI::App* AddCalibrateCommand(CLI::App& app, CalibrateArguments& a) {
  CLI::App* command = app.add_subcommand("calibrate", "Find a camera's parameters from images of a board");
  command->add_option("images", a.images, "Image files, all of one camera and one board")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--board", a.board, "chessboard, aprilgrid, charuco, circles, or a target file of Kalibr")
      ->type_name("FILE")
      ->capture_default_str();
  command
      ->add_option(
          "--model", a.model,
          "pinhole (to some 120 degrees of view), unified (mirrors, most fisheyes), fisheye, double_sphere")
      ->required()
      ->check(OneOf(vision::CalibratedModels()));
  command->add_option("--out", a.out, "Folder for camchain.yaml, report.txt and pictures")
      ->type_name("DIR")
      ->required();
  command
      ->add_option(
          "--accept-residual", a.accepted_px,
          "What may be left between the camera and what is seen, root mean square, px: with more "
          "nothing is written (default: a thousandth of the image's diagonal, more where it is blurred)")
      ->check(Within(0.001, 1000.0));
  AddBitsOption(*command, a.bits);
  command->footer(
      "Examples:\n"
      "  kestrel calibrate photos/*.jpg --model pinhole --out calibration\n"
      "  kestrel calibrate boards/*.png --model fisheye --board my_target.yaml --out calibration\n"
      "Show the board everywhere in the image and to its rim, near and far, tilted by 20 to 50 degrees this "
      "way "
      "and that: some 30 images.");
  return command;
}

void CalibrateCommand(const CalibrateArguments& a) {
  Mistakes mistakes;
  const vision::Board board = vision::LoadBoardNamed(a.board, "--board", mistakes);
  const std::vector<cv::Mat> images = ReadImages(a, mistakes);
  CheckWritableFolder(a.out, "--out", mistakes);
  mistakes.ThrowIfAny();

  const bool terminal = isatty(STDERR_FILENO);
  std::vector<vision::BoardView> views(images.size());
  InParallel(images.size(), static_cast<int>(std::max(1u, std::thread::hardware_concurrency())), "calibrate",
             "images", [&](std::size_t i) {
               views[i] = {a.images[i], vision::FindBoard(images[i], board)};
             });
  if (terminal) fmt::print(stderr, "\r\033[Kcalibrating");
  const vision::CameraModel like = vision::CameraLike(a.model, images.front().size());
  const vision::Calibration calibration = [&] {
    try {
      const vision::Calibration first = vision::Calibrate(board, views, like, a.accepted_px);
      return vision::Calibrate(board, vision::Refit(board, images, views, first), like, a.accepted_px);
    } catch (const vision::PoorFit& e) {
      if (terminal) fmt::print(stderr, "\r\033[K");
      throw InputError({}, std::string(e.what()) + "; --accept-residual PX takes more");
    } catch (const InputError&) {
      if (terminal) fmt::print(stderr, "\r\033[K");
      throw;
    }
  }();
  if (terminal) fmt::print(stderr, "\r\033[K");
  fs::create_directories(a.out);
  WriteCalibration(a.out, calibration, board, images);
  fmt::print("{}{}\n", CalibrationReport(calibration, board, images), a.out);
}

}  // namespace kestrel::app
