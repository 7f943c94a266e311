// SPDX-License-Identifier: Apache-2.0
#include "sim/world/ground_photo.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "base/user_file.h"
#include "geometry/tait_bryan.h"
#include "sim/world/texture.h"
#include "vision/image_file.h"

namespace kestrel::sim {
namespace {

constexpr int kTile_px = 4096;
constexpr int kMargin_px =
    16;  // of a tile round what is seen of it: a texture repeats, and is blurred from afar
constexpr double kMaxPixels = 1 << 27;
constexpr double kHeight_m = 0.006;  // above a landscape's lawn, below a pad's face

cv::Mat ReadPhoto(const GroundPhotoParameters& p) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error(fmt::format("The ground photo {} {}.", p.file, why));
  };
  const FileContent content = ReadUserFile(p.file, kMaxDataBytes);
  if (!content.error.empty()) refuse(content.error);
  const vision::ImageFile image =
      vision::DecodeImage(content.bytes, vision::ImageColours::kColour, kMaxPhotoSide_px);
  if (image.pixels.empty()) refuse(image.error);
  cv::Mat rgb = image.pixels;
  if (static_cast<double>(rgb.total()) > kMaxPixels)
    refuse(
        fmt::format("has {} x {} pixels; valid: up to {:.0f} million", rgb.cols, rgb.rows, kMaxPixels / 1e6));
  const double shape = static_cast<double>(rgb.rows) / rgb.cols, wanted = p.size_m.x() / p.size_m.y();
  if (std::abs(std::log(shape / wanted)) > 0.2 && std::abs(std::log(shape * wanted)) < 0.05)
    refuse(
        fmt::format("has {} x {} pixels, and size_m is [{:g}, {:g}]; valid: its height first, [{:g}, {:g}]",
                    rgb.cols, rgb.rows, p.size_m.x(), p.size_m.y(), p.size_m.y(), p.size_m.x()));
  if (rgb.depth() == CV_16U) rgb.convertTo(rgb, CV_8U, 1 / 257.0);
  cv::cvtColor(rgb, rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

}  // namespace

void AddGroundPhoto(const GroundPhotoParameters& p, AdditionsModel& model) {
  const cv::Mat photo = ReadPhoto(p);
  constexpr int kSeen_px = kTile_px - 2 * kMargin_px;
  const int columns = (photo.cols + kSeen_px - 1) / kSeen_px, rows = (photo.rows + kSeen_px - 1) / kSeen_px;
  cv::Mat framed;
  cv::copyMakeBorder(photo, framed, kMargin_px, kMargin_px, kMargin_px, kMargin_px, cv::BORDER_REPLICATE);
  const double turn = Radians(p.yaw_deg);
  std::string assets, geoms;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int left = photo.cols * column / columns, right = photo.cols * (column + 1) / columns;
      const int top = photo.rows * row / rows, bottom = photo.rows * (row + 1) / rows;
      const cv::Size seen(right - left, bottom - top);
      const cv::Mat tile =
          framed(cv::Rect(left, top, seen.width + 2 * kMargin_px, seen.height + 2 * kMargin_px));
      const std::string name = fmt::format("ground photo {}.{}", row, column);
      model.textures.emplace_back(name, TexturePicture(tile));
      const cv::Mat& texture = model.textures.back().second;
      // MuJoCo spreads a picture over a box with its right along x and its up along y of the geom.
      const double north_m = (0.5 - 0.5 * (top + bottom) / photo.rows) * p.size_m.x(),
                   east_m = (0.5 * (left + right) / photo.cols - 0.5) * p.size_m.y();
      assets += fmt::format(
          R"(<texture name="{0}" type="2d" builtin="flat" width="{1}" height="{2}"/>
    <material name="{0}" texture="{0}" specular="0" texrepeat="{3} {4}"/>)",
          name, texture.cols, texture.rows, static_cast<double>(seen.width) / tile.cols,
          static_cast<double>(seen.height) / tile.rows);
      const Eigen::Vector2d middle_N =
          p.position_m + Eigen::Rotation2Dd(turn) * Eigen::Vector2d(north_m, east_m);
      const Eigen::Quaterniond R(Eigen::AngleAxisd(-turn - std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
      geoms += fmt::format(
          R"(<geom name="{0}" type="box" pos="{1} {2} {3}" quat="{4} 0 0 {5}" size="{6} {7} {3}" material="{0}"
            contype="0" conaffinity="0"/>)",
          name, middle_N.x(), -middle_N.y(), kHeight_m / 2, R.w(), R.z(),
          0.5 * p.size_m.y() * seen.width / photo.cols, 0.5 * p.size_m.x() * seen.height / photo.rows);
    }
  }
  model.mjcf += fmt::format("<asset>{}</asset><worldbody>{}</worldbody>", assets, geoms);
}

}  // namespace kestrel::sim
