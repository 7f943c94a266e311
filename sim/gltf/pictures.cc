// SPDX-License-Identifier: Apache-2.0
#include "sim/gltf/pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/html/html.h"

namespace kestrel::sim::gltf {
namespace {

constexpr int kSkyRows = 256;
constexpr int kSkyFace = 256;  // texels to a side of the cube that it is taken from
constexpr int kSkyQuality = 80;

}  // namespace

cv::Mat PictureOf(const mjModel* m, int texture, int most_texels) {
  const int rows = m->tex_height[texture], columns = m->tex_width[texture];
  const cv::Mat whole(rows, columns, CV_8UC3, m->tex_rgb + m->tex_adr[texture]);
  cv::Mat picture;
  cv::cvtColor(whole, picture, cv::COLOR_RGB2BGR);
  const int parts = m->tex_type[texture] == mjTEXTURE_2D ? 1 : 6;
  const int side = std::max(rows / parts, columns);
  if (side <= most_texels) return picture;
  // Powers of two, which some viewers would make of them anyway, and worse.
  const auto fewer = [&](int count) {
    const double wanted = std::max(1.0, static_cast<double>(count) * most_texels / side);
    return 1 << static_cast<int>(std::lround(std::log2(wanted)));
  };
  cv::resize(picture, picture, {fewer(columns), parts * fewer(rows / parts)}, 0, 0, cv::INTER_AREA);
  return picture;
}

int FaceOf(const Eigen::Vector3f& direction) {
  Eigen::Index axis;
  direction.cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(2 * axis) + (direction[axis] < 0 ? 1 : 0);
}

// OpenGL 4.6, table 8.19.
Eigen::Vector2f PlaceInCube(const Eigen::Vector3f& d, int face) {
  if (face < 0) face = FaceOf(d);
  const float along = std::max(std::abs(d[face / 2]), 1e-9f);
  Eigen::Vector2f q;
  switch (face) {
    case 0:
      q = {-d.z(), -d.y()};
      break;
    case 1:
      q = {d.z(), -d.y()};
      break;
    case 2:
      q = {d.x(), d.z()};
      break;
    case 3:
      q = {d.x(), -d.z()};
      break;
    case 4:
      q = {d.x(), -d.y()};
      break;
    default:
      q = {-d.x(), -d.y()};
  }
  q = ((q / along).array().max(-1.0f).min(1.0f) + 1) / 2;
  return {q.x(), (q.y() + static_cast<float>(face)) / 6};
}

std::string SkyUrl(const mjModel* m) {
  int sky = 0;
  while (sky < m->ntex && m->tex_type[sky] != mjTEXTURE_SKYBOX) ++sky;
  if (sky == m->ntex) return "";
  const cv::Mat cube = PictureOf(m, sky, kSkyFace);
  cv::Mat picture(kSkyRows, 2 * kSkyRows, CV_8UC3);
  for (int row = 0; row < picture.rows; ++row) {
    const float elevation = std::numbers::pi_v<float> * (0.5f - (static_cast<float>(row) + 0.5f) / kSkyRows);
    for (int column = 0; column < picture.cols; ++column) {
      const float azimuth = std::numbers::pi_v<float> * ((static_cast<float>(column) + 0.5f) / kSkyRows - 1);
      // The sky's cube has x north, y up, z east.
      const Eigen::Vector2f st = PlaceInCube({std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                                              std::cos(elevation) * std::sin(azimuth)});
      picture.at<cv::Vec3b>(row, column) = cube.at<cv::Vec3b>(
          std::min(static_cast<int>(st.y() * static_cast<float>(cube.rows)), cube.rows - 1),
          std::min(static_cast<int>(st.x() * static_cast<float>(cube.cols)), cube.cols - 1));
    }
  }
  std::vector<unsigned char> file;
  cv::imencode(".jpg", picture, file, {cv::IMWRITE_JPEG_QUALITY, kSkyQuality});
  return "data:image/jpeg;base64," + Base64({reinterpret_cast<const char*>(file.data()), file.size()});
}

}  // namespace kestrel::sim::gltf
