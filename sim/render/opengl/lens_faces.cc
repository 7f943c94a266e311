// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/lens_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace kestrel::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kShareThatMayBeCoarser = 1e-3;
constexpr int kBorder_px = 2;           // beyond the outermost patches: interpolation reads one
constexpr double kWidestPatch = 0.1;    // on the plane one before a face: at a fold a pixel sees far and wide
constexpr int kMaxAcross = 16;          // of a patch: farther apart than a pixel where it is larger
constexpr double kMinForward = 0.2588;  // cos 75 deg: a plane grows with the tangent
// What a face costs beside its pixels: the geometry, in pixels that are drawn meanwhile. Measured with
// OSMesa.
constexpr double kFaceCost_px = 1e5;

struct LensPixel {
  bool seen = false;
  Vector3d ray;                         // unit, in C
  Eigen::Matrix<double, 3, 2> d_pixel;  // its derivative by the pixel
};

std::vector<LensPixel> PixelsOf(const vision::CameraModel& camera) {
  const int width = vision::WidthPx(camera), height = vision::HeightPx(camera);
  std::vector<LensPixel> pixels(static_cast<std::size_t>(width) * height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      LensPixel& pixel = pixels[static_cast<std::size_t>(v) * width + u];
      const auto ray = vision::Ray(camera, Vector2d(u, v), &pixel.d_pixel);
      if (!ray) continue;
      pixel.seen = true;
      pixel.ray = *ray;
    }
  }
  return pixels;
}

// The least of the singular values: by how much at least the place in the face moves with a pixel.
double MinStretch(const Eigen::Matrix2d& m) {
  const double a = m.squaredNorm(), b = std::abs(m.determinant());
  const double most = std::sqrt(a / 2 + std::sqrt(std::max(a * a / 4 - b * b, 0.0)));
  return most > 0 ? b / most : 0;
}

// A place on the plane one before the face, and how it moves with the pixel of the lens.
struct OnPlane {
  Vector2d at;
  Eigen::Matrix2d d_pixel;
};
OnPlane Tangent(const LensPixel& pixel, const Eigen::Matrix3d& R_VC) {
  const Vector3d ray = R_VC * pixel.ray;
  const Eigen::Matrix<double, 3, 2> d = R_VC * pixel.d_pixel;
  OnPlane place;
  place.at = ray.head<2>() / ray.z();
  place.d_pixel = (d.topRows<2>() - place.at * d.row(2)) / ray.z();
  for (int i = 0; i < 2; ++i)
    place.d_pixel.col(i) *= std::min(1.0, kWidestPatch / place.d_pixel.col(i).norm());
  return place;
}

Patch PatchOf(const OnPlane& place, const vision::Pinhole& c, std::size_t face) {
  const auto fixed = [](double px) { return static_cast<std::int32_t>(std::lround(px * 65536)); };
  const auto across = [](const Vector2d& side) {
    return static_cast<std::uint8_t>(std::clamp(static_cast<int>(std::ceil(side.norm())), 1, kMaxAcross));
  };
  const Eigen::Matrix2d d = c.fx * place.d_pixel;
  return {static_cast<std::uint16_t>(face),
          across(d.col(0)),
          across(d.col(1)),
          fixed(c.fx * place.at.x() + c.cx),
          fixed(c.height_px - 1 - (c.fy * place.at.y() + c.cy)),
          fixed(d(0, 0)),
          fixed(-d(1, 0)),
          fixed(d(0, 1)),
          fixed(-d(1, 1))};
}

std::optional<LensFaces> Plan(const vision::CameraModel& camera, const std::vector<LensPixel>& pixels,
                              const FaceLayout& layout, int max_side_px) {
  struct Use {
    Vector2d least = Vector2d::Constant(std::numeric_limits<double>::infinity());
    Vector2d most = -least;
    std::vector<float> stretches;
  };
  std::vector<Use> uses(layout.size());
  std::vector<Eigen::Matrix3d> R_VC;
  for (const Eigen::Quaterniond& R_CV : layout) R_VC.push_back(R_CV.conjugate().toRotationMatrix());

  LensFaces plan{vision::WidthPx(camera), vision::HeightPx(camera), {}, 0, {}, {}};
  plan.patches.resize(pixels.size());
  plan.stretch.resize(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i].seen) continue;
    std::size_t nearest = 0;
    double forward = -2;
    for (std::size_t k = 0; k < layout.size(); ++k) {
      const double z = R_VC[k].row(2).dot(pixels[i].ray);
      if (z > forward) forward = z, nearest = k;
    }
    if (forward < kMinForward) return std::nullopt;
    const OnPlane place = Tangent(pixels[i], R_VC[nearest]);
    Use& use = uses[nearest];
    const Vector2d reach = place.d_pixel.cwiseAbs().rowwise().sum() / 2;
    use.least = use.least.cwiseMin(place.at - reach);
    use.most = use.most.cwiseMax(place.at + reach);
    use.stretches.push_back(static_cast<float>(MinStretch(place.d_pixel)));
    plan.patches[i].face = static_cast<std::uint16_t>(nearest);
    plan.stretch[i] = static_cast<float>(1 / forward);
  }

  std::vector<std::size_t> index(layout.size());
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
    index[k] = plan.faces.size();
    plan.faces.push_back(
        {layout[k],
         {static_cast<int>(size.x()), static_cast<int>(size.y()), f, f, middle.x(), middle.y()},
         plan.pixels});
    plan.pixels += static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y());
  }

  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i].seen) continue;
    const std::size_t k = plan.patches[i].face;
    plan.patches[i] = PatchOf(Tangent(pixels[i], R_VC[k]), plan.faces[index[k]].camera, index[k]);
  }
  return plan;
}

}  // namespace

std::optional<LensFaces> OnlyFace(const vision::CameraModel& camera) {
  const vision::Pinhole* const c = std::get_if<vision::Pinhole>(&camera);
  if (!c || std::abs(c->fx - c->fy) > 1e-9 * c->fx) return std::nullopt;
  for (const int u : {0, c->width_px - 1})
    for (const int v : {0, c->height_px - 1})
      if (!c->Ray(Vector2d(u, v))) return std::nullopt;
  LensFaces lens{c->width_px, c->height_px, {{Eigen::Quaterniond::Identity(), *c, 0}}, 0, {}, {}};
  for (int v = 0; v < c->height_px; ++v) {
    for (int u = 0; u < c->width_px; ++u) {
      Patch& patch = lens.patches.emplace_back();
      patch.face = 0;
      patch.x = u << 16, patch.y = (c->height_px - 1 - v) << 16;
      lens.stretch.push_back(static_cast<float>(1 / c->Ray(Vector2d(u, v))->z()));
    }
  }
  lens.pixels = lens.patches.size();
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

std::optional<LensFaces> PlanFaces(const vision::CameraModel& camera, const FaceLayout& layout,
                                   int max_side_px) {
  return Plan(camera, PixelsOf(camera), layout, max_side_px);
}

LensFaces PlanFaces(const vision::CameraModel& camera, int max_side_px) {
  const std::vector<LensPixel> pixels = PixelsOf(camera);
  const auto cost = [](const LensFaces& f) {
    return static_cast<double>(f.pixels) + kFaceCost_px * static_cast<double>(f.faces.size());
  };
  std::optional<LensFaces> plane = Plan(camera, pixels, {Eigen::Quaterniond::Identity()}, max_side_px);
  LensFaces cube = *Plan(camera, pixels, Cube(), max_side_px);
  return plane && cost(*plane) <= cost(cube) ? std::move(*plane) : std::move(cube);
}

}  // namespace kestrel::sim
