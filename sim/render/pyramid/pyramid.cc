// SPDX-License-Identifier: Apache-2.0
#include "sim/render/pyramid/pyramid.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel::sim::ray {
namespace {

template <class Texel>
constexpr Texel Packed(const std::uint8_t* pixel) {
  if constexpr (sizeof(Texel) == 1)
    return pixel[0];
  else
    return {pixel[2], pixel[1], pixel[0]};
}

template <class Texel>
constexpr int kChannels = sizeof(Texel) == 1 ? 1 : 3;

bool IsGrey(const cv::Mat& rgb) {
  for (int y = 0; y < rgb.rows; ++y) {
    const std::uint8_t* row = rgb.ptr(y);
    unsigned differs = 0;
    for (int x = 0; x < 3 * rgb.cols; x += 3)
      differs |= static_cast<unsigned>(row[x] ^ row[x + 1]) | static_cast<unsigned>(row[x] ^ row[x + 2]);
    if (differs) return false;
  }
  return true;
}

// Writes some rows, from the one at top on, of one level of a picture that repeats, so many rows high; with a
// border of what repeats.
template <class Texel>
void StoreRepeating(const cv::Mat& picture, int top, int height, Texel* origin, int stride) {
  const int width = picture.cols;
  for (int y = 0; y < picture.rows; ++y) {
    const std::uint8_t* pixels = picture.ptr(y);
    Texel* row = origin + static_cast<std::ptrdiff_t>(top + y) * stride;
    for (int x = 0; x < width; ++x) row[x] = Packed<Texel>(pixels + kChannels<Texel> * x);
    row[-1] = row[width - 1];
    row[width] = row[0];
    const auto again = [&](int at) {
      std::copy_n(row - 1, width + 2, origin + static_cast<std::ptrdiff_t>(at) * stride - 1);
    };
    if (top + y == 0) again(height);
    if (top + y == height - 1) again(-1);
  }
}

// The faces of a cube in OpenGL's order: where (sc, tc) on the face of a major axis 1 away points to, and
// back.
Eigen::Vector3d DirectionOn(int face, double sc, double tc) {
  switch (face) {
    case 0:
      return {1, -tc, -sc};
    case 1:
      return {-1, -tc, sc};
    case 2:
      return {sc, 1, tc};
    case 3:
      return {sc, -1, -tc};
    case 4:
      return {sc, -tc, 1};
    default:
      return {-sc, -tc, -1};
  }
}
int FaceOf(const Eigen::Vector3d& d, double& sc, double& tc) {
  int axis = 0;
  d.cwiseAbs().maxCoeff(&axis);
  const double major = std::abs(d[axis]), sign = d[axis] < 0 ? -1 : 1;
  sc = (axis == 0 ? -sign * d.z() : axis == 1 ? d.x() : sign * d.x()) / major;
  tc = (axis == 1 ? sign * d.z() : -d.y()) / major;
  return 2 * axis + (sign < 0 ? 1 : 0);
}

// Writes one level of one face; its border is the nearest texels of the faces beside it, or its own if it is alone.
template <class Texel>
void StoreFace(const std::vector<cv::Mat>& faces, int face, Texel* origin, int stride) {
  const int size = faces[face].cols;
  for (int y = -1; y <= size; ++y) {
    for (int x = -1; x <= size; ++x) {
      int of = face, column = std::clamp(x, 0, size - 1), row = std::clamp(y, 0, size - 1);
      if (faces.size() > 1 && (column != x || row != y)) {
        double sc = 0, tc = 0;
        of = FaceOf(DirectionOn(face, (2 * x + 1.0) / size - 1, (2 * y + 1.0) / size - 1), sc, tc);
        const auto texel = [&](double c) {
          return std::clamp(static_cast<int>(std::floor((c + 1) / 2 * size)), 0, size - 1);
        };
        column = texel(sc);
        row = texel(tc);
      }
      origin[static_cast<std::ptrdiff_t>(y) * stride + x] = Packed<Texel>(faces[of].ptr(row, column));
    }
  }
}

// Rows of the picture at another size, its larger neighbour's texels between its own.
cv::Mat Enlarged(const cv::Mat& small, cv::Size size, cv::Range rows, bool repeats) {
  const cv::Size2d ratio(static_cast<double>(small.cols) / size.width,
                         static_cast<double>(small.rows) / size.height);
  cv::Mat x(rows.size(), size.width, CV_32F), y(x.size(), CV_32F), large;
  for (int v = 0; v < x.rows; ++v) {
    for (int u = 0; u < x.cols; ++u) {
      x.at<float>(v, u) = static_cast<float>((u + 0.5) * ratio.width - 0.5);
      y.at<float>(v, u) = static_cast<float>((rows.start + v + 0.5) * ratio.height - 0.5);
    }
  }
  cv::remap(small, large, x, y, cv::INTER_LINEAR, repeats ? cv::BORDER_WRAP : cv::BORDER_REPLICATE);
  return large;
}

// log2 of the footprint in the middle of each of the four parts of an octave.
constexpr double kMiddles[4] = {0.146, 0.396, 0.646, 0.896};

// Fills the levels, which have their sizes and places.
template <class Texel>
void Fill(std::vector<cv::Mat> faces, bool cube, const std::vector<cv::Size>& octaves,
          std::vector<Texel, Uncleared<Texel>>& texels, Pyramid& p) {
  const auto store = [&](const std::vector<cv::Mat>& pictures, int level, int top = 0) {
    Texel* origin = texels.data() + p.offset[level];
    if (!cube)
      return StoreRepeating(pictures[0], top, static_cast<int>(p.height[level]), origin, p.stride[level]);
    for (int face = 0; face < static_cast<int>(pictures.size()); ++face)
      StoreFace(pictures, face, origin + static_cast<std::ptrdiff_t>(face) * p.face_stride, p.stride[level]);
  };
  store(faces, 0);
  for (std::size_t octave = 0; octave + 1 < octaves.size(); ++octave) {
    std::vector<cv::Mat> halves(faces.size());
    for (std::size_t face = 0; face < faces.size(); ++face)
      cv::resize(faces[face], halves[face], octaves[octave + 1], 0, 0, cv::INTER_AREA);
    // A few rows at a time, for a large picture and all that is made of it on the way would take much room;
    // the faces of a cube, which are small, need each other.
    const cv::Size size = octaves[octave];
    const int rows_at_once = cube ? size.height : 64;
    for (int top = 0; top < size.height; top += rows_at_once) {
      const cv::Range strip(top, std::min(top + rows_at_once, size.height));
      std::vector<cv::Mat> blurred, mixed(faces.size());
      for (const cv::Mat& half : halves) blurred.push_back(Enlarged(half, size, strip, !cube));
      for (int part = 0; part < 4; ++part) {
        for (std::size_t face = 0; face < faces.size(); ++face)
          cv::addWeighted(faces[face].rowRange(strip), 1 - kMiddles[part], blurred[face], kMiddles[part], 0,
                          mixed[face]);
        store(mixed, 1 + 4 * static_cast<int>(octave) + part, top);
      }
    }
    faces = halves;
  }
  store(faces, p.levels - 1);
}

}  // namespace

Pyramid MakePyramid(const mjModel* model, int texture) {
  Pyramid p;
  const int type = model->tex_type[texture];
  const int width = model->tex_width[texture];
  const int rows = model->tex_height[texture];
  mjtByte* data = model->tex_rgb + model->tex_adr[texture];
  const bool cube = type != mjTEXTURE_2D;
  const int height = cube ? width : rows;

  std::vector<cv::Size> octaves = {{width, height}};
  while (octaves.back() != cv::Size(1, 1))
    octaves.emplace_back(std::max(1, octaves.back().width / 2), std::max(1, octaves.back().height / 2));
  p.levels = 4 * static_cast<int>(octaves.size() - 1) + 2;
  std::int32_t total = 0;
  for (int l = 0; l < p.levels; ++l) {
    const cv::Size size = octaves[l == 0 ? 0 : (l - 1) / 4];
    p.width[l] = static_cast<float>(size.width);
    p.height[l] = static_cast<float>(size.height);
    p.stride[l] = size.width + 2;
    p.offset[l] = total + p.stride[l] + 1;
    total += (size.width + 2) * (size.height + 2);
  }
  // A cube of one picture shows it on all sides.
  const int pictures = cube && rows != width ? 6 : 1;
  p.face_stride = pictures == 6 ? total : 0;
  std::vector<cv::Mat> faces;
  for (int face = 0; face < pictures; ++face)
    faces.emplace_back(height, width, CV_8UC3, data + static_cast<std::size_t>(face) * 3 * width * width);
  const std::size_t texels = static_cast<std::size_t>(total) * static_cast<std::size_t>(pictures);
  if (std::all_of(faces.begin(), faces.end(), IsGrey)) {
    for (cv::Mat& face : faces) cv::extractChannel(face, face, 0);
    p.grey_texels.resize(texels + 7);
    std::fill_n(p.grey_texels.end() - 7, 7, std::uint8_t{0});
    Fill(faces, cube, octaves, p.grey_texels, p);
  } else {
    p.texels.resize(texels + 2);
    std::fill_n(p.texels.end() - 2, 2, ColourTexel{});
    Fill(faces, cube, octaves, p.texels, p);
  }
  return p;
}

}  // namespace kestrel::sim::ray
