// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/lens.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <variant>

#include "base/recent/recent.h"

namespace kestrel::sim::ray {
namespace {

constexpr int kPadding = 64;  // no vector is wider

template <class T>
Aligned<T> Zeros(std::size_t size) {
  auto array = hwy::AllocateAligned<T>(size + kPadding);
  std::fill(array.get(), array.get() + size + kPadding, T{});
  return array;
}

void SetEmpty(Lens::Plane& plane) {
  plane = {};
  plane.bounded = true;
  plane.low_x = plane.low_y = 1e9f, plane.high_x = plane.high_y = -1e9f;
  std::fill_n(plane.column_low_x, Lens::kTile, 1e9f), std::fill_n(plane.column_high_x, Lens::kTile, -1e9f);
  std::fill_n(plane.row_low_y, Lens::kTile, 1e9f), std::fill_n(plane.row_high_y, Lens::kTile, -1e9f);
}

// By a ray of the tile's pixel, and by what rounding does.
void Extend(Lens::Plane& plane, int column, int row, const Eigen::Vector3d& d, const Eigen::Vector3d& axis,
            const Eigen::Vector3d& across, const Eigen::Vector3d& down) {
  constexpr double kRoom = 1e-6, kLeastAlong = 0.05;
  const double along = std::max(d.dot(axis), kLeastAlong);
  if (d.dot(axis) < kLeastAlong) plane.bounded = false;
  const double x = d.dot(across) / along, y = d.dot(down) / along;
  const auto extend = [](float& low, float& high, double by) {
    low = std::min(low, static_cast<float>(by - kRoom));
    high = std::max(high, static_cast<float>(by + kRoom));
  };
  extend(plane.low_x, plane.high_x, x);
  extend(plane.low_y, plane.high_y, y);
  extend(plane.column_low_x[column], plane.column_high_x[column], x);
  extend(plane.row_low_y[row], plane.row_high_y[row], y);
}

// Which model, and all of its numbers. Empty: it is not known what there is to it.
std::string KeyOf(const vision::CameraModel& camera) {
  return std::visit(
      [&](const auto& model) {
        std::string key;
        if constexpr (std::is_trivially_copyable_v<std::decay_t<decltype(model)>>) {
          key = std::to_string(camera.index()) + ' ';
          key.append(reinterpret_cast<const char*>(&model), sizeof model);
        }
        return key;
      },
      camera);
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
  lens.planes.resize(static_cast<std::size_t>(tiles));
  for (int t = 0; t < tiles; ++t) {
    const int u0 = t % lens.tiles_x * Lens::kTile, v0 = t / lens.tiles_x * Lens::kTile;
    const int u1 = std::min(u0 + Lens::kTile, lens.width), v1 = std::min(v0 + Lens::kTile, lens.height);
    Lens::Plane& plane = lens.planes[static_cast<std::size_t>(t)];
    SetEmpty(plane);
    Eigen::Vector3d axis = Eigen::Vector3d::Zero(), across = axis;
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) {
        if (!lens.inside[at(u, v)]) continue;
        axis += ray[at(u, v)];
        across += ray[at(u + 1, v)] - ray[at(u, v)];
      }
    }
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

    across = (across - axis.dot(across) * axis).normalized();
    if (!across.allFinite()) across = axis.unitOrthogonal();
    const Eigen::Vector3d down = axis.cross(across);
    for (int k = 0; k < 3; ++k) {
      plane.axis[k] = static_cast<float>(axis[k]);
      plane.across[k] = static_cast<float>(across[k]);
      plane.down[k] = static_cast<float>(down[k]);
    }
    // By the corners of its pixels.
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) {
        if (!lens.inside[at(u, v)]) continue;
        const Eigen::Vector3d& d = ray[at(u, v)];
        const Eigen::Vector3d half_u = 0.5 * (ray[at(u + 1, v)] - d), half_v = 0.5 * (ray[at(u, v + 1)] - d);
        for (const int i : {-1, 1})
          for (const int j : {-1, 1})
            Extend(plane, u - u0, v - v0, d + i * half_u + j * half_v, axis, across, down);
      }
    }
  }
  lens.pixel_rad = static_cast<float>(widest);
  return lens;
}

std::shared_ptr<const Lens> LensOf(const vision::CameraModel& camera) {
  static Recent<std::string, Lens> recent(2);  // the aircraft's, and that on the ground
  const std::string key = KeyOf(camera);
  if (key.empty()) return std::make_shared<const Lens>(MakeLens(camera));
  return recent.Of(key, [&] { return MakeLens(camera); });
}

}  // namespace kestrel::sim::ray
