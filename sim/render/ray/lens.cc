// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/lens.h"

#include <algorithm>
#include <cmath>

namespace kestrel::sim::ray {
namespace {

constexpr int kPadding = 64;  // no vector is wider

template <class T>
Aligned<T> Zeros(std::size_t size) {
  auto array = hwy::AllocateAligned<T>(size + kPadding);
  std::fill(array.get(), array.get() + size + kPadding, T{});
  return array;
}

}  // namespace

Lens MakeLens(const vision::CameraModel& camera) {
  Lens lens;
  lens.width = vision::WidthPx(camera);
  lens.height = vision::HeightPx(camera);
  lens.tiles_x = (lens.width + Lens::kTile - 1) / Lens::kTile;
  lens.tiles_y = (lens.height + Lens::kTile - 1) / Lens::kTile;
  lens.stride = (lens.tiles_x + 1) * Lens::kTile;
  const int rows = lens.tiles_y * Lens::kTile + 1;
  const std::size_t size = static_cast<std::size_t>(lens.stride) * rows;
  lens.x = Zeros<float>(size);
  lens.y = Zeros<float>(size);
  lens.z = Zeros<float>(size);
  lens.inside = Zeros<std::uint8_t>(size);

  std::vector<Eigen::Vector3d> ray(size, Eigen::Vector3d::Zero());
  const auto at = [&](int u, int v) { return static_cast<std::size_t>(v) * lens.stride + u; };
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      if (const auto r = vision::Ray(camera, {u, v})) {
        ray[at(u, v)] = *r;
        lens.inside[at(u, v)] = 1;
      }
    }
  }
  // One pixel on, where the table ends: the step of the pixel before, or of the only neighbour there is.
  const auto go_on = [&](int u, int v) {
    const auto known = [&](int uu, int vv) {
      return uu >= 0 && vv >= 0 && uu < lens.width && vv < lens.height && lens.inside[at(uu, vv)];
    };
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const auto& [du, dv] : {std::pair{-1, 0}, std::pair{0, -1}, std::pair{-1, -1}}) {
      if (known(u + du, v + dv) && known(u + 2 * du, v + 2 * dv)) {
        sum += 2 * ray[at(u + du, v + dv)] - ray[at(u + 2 * du, v + 2 * dv)];
        ++count;
      }
    }
    if (count > 0) {
      ray[at(u, v)] = sum / count;
      return;
    }
    for (const auto& [du, dv] : {std::pair{-1, 0}, std::pair{0, -1}, std::pair{1, 0}, std::pair{0, 1}})
      if (known(u + du, v + dv)) ray[at(u, v)] = ray[at(u + du, v + dv)];
  };
  for (int v = 0; v <= lens.height; ++v)
    for (int u = 0; u <= lens.width; ++u)
      if (u == lens.width || v == lens.height || !lens.inside[at(u, v)]) go_on(u, v);

  for (std::size_t i = 0; i < size; ++i) {
    lens.x[i] = static_cast<float>(ray[i].x());
    lens.y[i] = static_cast<float>(ray[i].y());
    lens.z[i] = static_cast<float>(ray[i].z());
  }

  const int tiles = lens.tiles_x * lens.tiles_y;
  lens.tiles_padded = (tiles + kPadding - 1) / kPadding * kPadding;
  lens.axis_x = Zeros<float>(lens.tiles_padded);
  lens.axis_y = Zeros<float>(lens.tiles_padded);
  lens.axis_z = Zeros<float>(lens.tiles_padded);
  lens.reach = Zeros<float>(lens.tiles_padded);
  std::fill(lens.reach.get(), lens.reach.get() + lens.tiles_padded, -1.0f);
  double widest = 0;
  for (int t = 0; t < tiles; ++t) {
    const int u0 = t % lens.tiles_x * Lens::kTile, v0 = t / lens.tiles_x * Lens::kTile;
    const int u1 = std::min(u0 + Lens::kTile, lens.width), v1 = std::min(v0 + Lens::kTile, lens.height);
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();
    for (int v = v0; v < v1; ++v)
      for (int u = u0; u < u1; ++u)
        if (lens.inside[at(u, v)]) axis += ray[at(u, v)];
    if (axis.norm() == 0) continue;
    axis.normalize();
    double reach = 0, pixel = 0;
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) {
        if (!lens.inside[at(u, v)]) continue;
        reach = std::max(reach, (ray[at(u, v)] - axis).norm());
        pixel = std::max(
            {pixel, (ray[at(u + 1, v)] - ray[at(u, v)]).norm(), (ray[at(u, v + 1)] - ray[at(u, v)]).norm()});
      }
    }
    widest = std::max(widest, pixel);
    lens.axis_x[t] = static_cast<float>(axis.x());
    lens.axis_y[t] = static_cast<float>(axis.y());
    lens.axis_z[t] = static_cast<float>(axis.z());
    lens.reach[t] = static_cast<float>((reach + pixel) * 1.0001);
  }
  lens.pixel_rad = static_cast<float>(widest);
  return lens;
}

}  // namespace kestrel::sim::ray
