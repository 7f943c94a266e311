// SPDX-License-Identifier: Apache-2.0
#include "sim/lens_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace kestrel {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFinerThanLens = 2;
constexpr double kShareThatMayBeCoarser = 1e-3;
constexpr int kBorder_px = 2;             // beyond the outermost rays: interpolation reads one
constexpr double kLeastForward = 0.2588;  // cos 75 deg: a plane grows with the tangent
// What a face costs beside its pixels: the geometry, in pixels that are drawn meanwhile. Measured with
// OSMesa.
constexpr double kFaceCost_px = 1e5;

struct LensPixel {
  bool seen = false;
  Vector3d ray;                         // unit, in C
  Eigen::Matrix<double, 3, 2> d_pixel;  // its derivative by the pixel
};

std::vector<LensPixel> PixelsOf(const CameraModel& camera) {
  const int width = WidthPx(camera), height = HeightPx(camera);
  std::vector<LensPixel> pixels(static_cast<std::size_t>(width) * height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      LensPixel& pixel = pixels[static_cast<std::size_t>(v) * width + u];
      const auto ray = Ray(camera, Vector2d(u, v), &pixel.d_pixel);
      if (!ray) continue;
      pixel.seen = true;
      pixel.ray = *ray;
    }
  }
  return pixels;
}

// The least of the singular values: by how much at least the place in the face moves with a pixel.
double LeastStretch(const Eigen::Matrix2d& m) {
  const double a = m.squaredNorm(), b = std::abs(m.determinant());
  const double most = std::sqrt(a / 2 + std::sqrt(std::max(a * a / 4 - b * b, 0.0)));
  return most > 0 ? b / most : 0;
}

// A place on the plane one before the face, and how it moves with the pixel of the lens.
struct OnPlane {
  Vector2d at;
  double least_stretch;
};
OnPlane Tangent(const LensPixel& pixel, const Eigen::Matrix3d& R_VC) {
  const Vector3d ray = R_VC * pixel.ray;
  const Eigen::Matrix<double, 3, 2> d = R_VC * pixel.d_pixel;
  const Vector2d at = ray.head<2>() / ray.z();
  return {at, LeastStretch((d.topRows<2>() - at * d.row(2)) / ray.z())};
}

std::optional<LensFaces> Plan(const CameraModel& camera, const std::vector<LensPixel>& pixels,
                              const FaceLayout& layout, int max_side_px) {
  struct Use {
    Vector2d least = Vector2d::Constant(std::numeric_limits<double>::infinity());
    Vector2d most = -least;
    std::vector<float> stretches;
  };
  std::vector<Use> uses(layout.size());
  std::vector<Eigen::Matrix3d> R_VC;
  for (const Eigen::Quaterniond& R_CV : layout) R_VC.push_back(R_CV.conjugate().toRotationMatrix());

  LensFaces plan{WidthPx(camera), HeightPx(camera), {}, 0, {}, {}};
  plan.texels.resize(pixels.size());
  plan.stretch.resize(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i].seen) continue;
    std::size_t nearest = 0;
    double forward = -2;
    for (std::size_t k = 0; k < layout.size(); ++k) {
      const double z = R_VC[k].row(2).dot(pixels[i].ray);
      if (z > forward) forward = z, nearest = k;
    }
    if (forward < kLeastForward) return std::nullopt;
    const OnPlane place = Tangent(pixels[i], R_VC[nearest]);
    Use& use = uses[nearest];
    use.least = use.least.cwiseMin(place.at);
    use.most = use.most.cwiseMax(place.at);
    use.stretches.push_back(static_cast<float>(place.least_stretch));
    plan.texels[i].face = static_cast<std::uint32_t>(nearest);
    plan.stretch[i] = static_cast<float>(1 / forward);
  }

  std::vector<std::uint32_t> index(layout.size());
  for (std::size_t k = 0; k < layout.size(); ++k) {
    Use& use = uses[k];
    if (use.stretches.empty()) continue;
    const auto densest =
        use.stretches.begin() +
        static_cast<std::ptrdiff_t>(kShareThatMayBeCoarser * static_cast<double>(use.stretches.size()));
    std::nth_element(use.stretches.begin(), densest, use.stretches.end());
    const Vector2d range = (use.most - use.least).cwiseMax(1e-9);
    const double f = std::min(kFinerThanLens / std::max<double>(*densest, 1e-9),
                              (max_side_px - 2 * kBorder_px - 2) / range.maxCoeff());
    const Vector2d size = (f * range).array().ceil() + 1 + 2 * kBorder_px;
    const Vector2d middle = Vector2d::Constant(kBorder_px) - f * use.least;
    index[k] = static_cast<std::uint32_t>(plan.faces.size());
    plan.faces.push_back(
        {layout[k],
         {static_cast<int>(size.x()), static_cast<int>(size.y()), f, f, middle.x(), middle.y()},
         plan.pixels});
    plan.pixels += static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y());
  }

  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i].seen) continue;
    Texel& texel = plan.texels[i];
    const Vector3d ray = R_VC[texel.face] * pixels[i].ray;
    texel.face = index[texel.face];
    const Face& face = plan.faces[texel.face];
    const Pinhole& c = face.camera;
    const double x = c.fx * ray.x() / ray.z() + c.cx;
    const double y = c.height_px - 1 - (c.fy * ray.y() / ray.z() + c.cy);
    // The nearest 65536th, with care that it does not become a whole.
    const auto fixed_x = static_cast<std::int64_t>(std::lround(x * 65536));
    const auto fixed_y = static_cast<std::int64_t>(std::lround(y * 65536));
    texel.at = static_cast<std::uint32_t>(face.first + static_cast<std::size_t>(fixed_y >> 16) * c.width_px +
                                          static_cast<std::size_t>(fixed_x >> 16));
    texel.right = static_cast<std::uint16_t>(fixed_x & 0xFFFF);
    texel.up = static_cast<std::uint16_t>(fixed_y & 0xFFFF);
  }
  return plan;
}

}  // namespace

std::optional<LensFaces> OnlyFace(const CameraModel& camera) {
  const Pinhole* const c = std::get_if<Pinhole>(&camera);
  if (!c || std::abs(c->fx - c->fy) > 1e-9 * c->fx) return std::nullopt;
  for (const int u : {0, c->width_px - 1})
    for (const int v : {0, c->height_px - 1})
      if (!c->Ray(Vector2d(u, v))) return std::nullopt;
  LensFaces lens{c->width_px, c->height_px, {{Eigen::Quaterniond::Identity(), *c, 0}}, 0, {}, {}};
  for (int v = 0; v < c->height_px; ++v) {
    for (int u = 0; u < c->width_px; ++u) {
      lens.texels.push_back({static_cast<std::uint32_t>((c->height_px - 1 - v) * c->width_px + u), 0, 0, 0});
      lens.stretch.push_back(static_cast<float>(1 / c->Ray(Vector2d(u, v))->z()));
    }
  }
  lens.pixels = lens.texels.size();
  return lens;
}

FaceLayout Cube(const Eigen::Quaterniond& R_CK) {
  FaceLayout layout;
  for (const double yaw : {0.0, 0.5, 1.0, 1.5})
    layout.push_back(R_CK * Eigen::AngleAxisd(yaw * std::numbers::pi, Vector3d::UnitY()));
  for (const double pitch : {0.5, -0.5})
    layout.push_back(R_CK * Eigen::AngleAxisd(pitch * std::numbers::pi, Vector3d::UnitX()));
  return layout;
}

std::optional<LensFaces> PlanFaces(const CameraModel& camera, const FaceLayout& layout, int max_side_px) {
  return Plan(camera, PixelsOf(camera), layout, max_side_px);
}

LensFaces PlanFaces(const CameraModel& camera, int max_side_px) {
  const std::vector<LensPixel> pixels = PixelsOf(camera);
  const auto cost = [](const LensFaces& f) {
    return static_cast<double>(f.pixels) + kFaceCost_px * static_cast<double>(f.faces.size());
  };
  std::optional<LensFaces> plane = Plan(camera, pixels, {Eigen::Quaterniond::Identity()}, max_side_px);
  LensFaces cube = *Plan(camera, pixels, Cube(), max_side_px);
  return plane && cost(*plane) <= cost(cube) ? std::move(*plane) : std::move(cube);
}

}  // namespace kestrel
