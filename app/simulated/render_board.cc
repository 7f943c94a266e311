// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/render_board.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "app/option/one_of.h"
#include "app/option/within.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "flight/simulated/scenario.h"
#include "sim/calibration/board_renderer.h"
#include "vision/calibration/board/board_file.h"
#include "vision/camera/calibration_file.h"
#include "vision/write_image.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

std::string PoseLine(const std::string& image, const Pose& X_CT) {
  const auto& q = X_CT.R;
  return fmt::format("  {}: {{q_wxyz: [{}, {}, {}, {}], p_m: [{}, {}, {}]}}\n", image, q.w(), q.x(), q.y(),
                     q.z(), X_CT.p.x(), X_CT.p.y(), X_CT.p.z());
}

}  // namespace

CLI::App* AddRenderBoardCommand(CLI::App& app, RenderBoardArguments& a) {
  CLI::App* command =
      app.add_subcommand("render-board", "Draw images of a calibration board as a camera sees it");
  command->add_option("--camera", a.camera, "One of models/cameras, or a camera's file")
      ->type_name("CAMERA")
      ->required();
  command->add_option("--camera-name", a.camera_name, "Which camera of a Kalibr file (default: its first)");
  command
      ->add_option("--board", a.board, "chessboard, aprilgrid, charuco, circles, or a target file of Kalibr")
      ->type_name("FILE")
      ->capture_default_str();
  command->add_option("--count", a.count, "Images")->check(WholeNumber(1, 1000))->capture_default_str();
  command->add_option("--seed", a.seed, "Of the poses and the noise")->capture_default_str();
  command->add_option("--blur", a.blur_px, "Of the lens: its standard deviation, px")
      ->check(Within(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--noise", a.noise_grey, "Of a pixel: its standard deviation, grey levels")
      ->check(Within(0.0, 60.0))
      ->capture_default_str();
  command->add_option("--backend", a.backend, "What draws")
      ->check(OneOf({"auto", "ray", "osmesa", "egl"}))
      ->capture_default_str();
  command->add_option("--out", a.out, "Folder for the images; new or empty")->type_name("DIR")->required();
  command->footer(
      "Examples:\n"
      "  kestrel render-board --camera fisheye --out boards\n"
      "  kestrel render-board --camera hyperbolic_mirror --board aprilgrid --seed 7 --blur 0.8 --out tags\n"
      "  kestrel calibrate tags/image_*.png --model unified --board aprilgrid --out calibration");
  return command;
}

void RenderBoardCommand(const RenderBoardArguments& a) {
  Mistakes mistakes;
  vision::CameraModel camera;
  std::string name = a.camera;
  if (const auto file = ModelFile(Model::kCamera, name, "", "--camera", mistakes))
    camera = vision::LoadCamera(*file, mistakes, a.camera_name);
  const vision::Board board = vision::LoadBoardNamed(a.board, "--board", mistakes);
  const fs::path folder = a.out;
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error))
    mistakes.Add("--out", "", fmt::format("'{}' is not an empty folder", a.out), "valid: a new one");
  else
    CheckWritableFolder(folder, "--out", mistakes);
  mistakes.ThrowIfAny();

  const std::string kalibr = vision::ToKalibr(camera);  // refuses what it cannot say
  std::vector<Pose> poses;
  try {
    poses = sim::SpreadPoses(camera, board, a.count, a.seed);
  } catch (const std::runtime_error& e) {
    throw InputError("--camera, --board", fmt::format("{}", e.what()));
  }
  sim::BoardRenderer board_renderer(board, camera,
                                    {.blur_px = a.blur_px, .noise_grey = a.noise_grey, .backend = a.backend});
  fs::create_directories(folder);
  // In a folder of its own, so that all pictures of this one are the camera's.
  fs::create_directories(folder / "to_print");
  vision::WriteImage(folder / "to_print" / "board.png", vision::DrawBoard(board).grey);
  WriteFile(folder / "board.yaml", vision::ToKalibr(board));
  std::string truth = fmt::format(
      "# The camera `{}` that drew these images, as Kalibr's camchain, and the poses of the {}\n"
      "# in it: the frame of the board has its origin in the lower left corner, x right, y up, z out of it.\n"
      "# Drawn by the {}: seed {}, blur {:g} px, noise {:g} grey levels.\n{}poses:\n",
      a.camera, vision::Describe(board), board_renderer.renderer(), a.seed, a.blur_px, a.noise_grey, kalibr);
  for (int i = 0; i < a.count; ++i) {
    if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[Kdrawing {} of {}", i + 1, a.count);
    const std::string image = fmt::format("image_{:03}.png", i);
    const Pose& X_CT = poses[static_cast<std::size_t>(i)];
    vision::WriteImage(folder / image, board_renderer.Render(X_CT, a.seed, i));
    truth += PoseLine(image, X_CT);
  }
  if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[K");
  WriteFile(folder / "truth.yaml", truth);
  fmt::print("{} images of {} x {} pixels, {}, drawn by {}\n{}\n", a.count, vision::WidthPx(camera),
             vision::HeightPx(camera), vision::Describe(board), board_renderer.renderer(), a.out);
}

}  // namespace kestrel::app
