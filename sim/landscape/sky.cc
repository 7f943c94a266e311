// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/sky.h"

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::sim::landscape {
namespace {

constexpr float kCloudBase_m = 1500;
constexpr float kCloudSize_m = 2600;
constexpr float kThin = 0.05f, kThick = 0.10f;  // of the noise round its threshold: no cloud, and all of it
constexpr float kSunRadius = 0.265f * 0.0174533f;
constexpr float kDegree = 0.0174533f;
// Under Koschmieder's law contrast is exp(-kFade distance / visibility): 2 % at the visibility.
constexpr float kFade = 3.912f;

Eigen::Vector3f Towards(double azimuth_deg, double elevation_deg) {
  const double a = Radians(azimuth_deg), e = Radians(elevation_deg);
  return Eigen::Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)).cast<float>();
}

float AngleBetween(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return 2 * std::asin(std::min(1.0f, 0.5f * (a - b).norm()));
}

}  // namespace

Sky::Sky(const LandscapeParameters& p, std::uint64_t seed)
    : p_(p),
      clouds_(seed, "landscape clouds"),
      bands_(seed, "landscape bands"),
      sun_(Towards(p.sun_azimuth_deg, p.sun_elevation_deg)),
      glow_(p.sun.cast<float>()),
      sunlight_(p.sunlight.cast<float>()),
      ambient_(p.ambient.cast<float>()),
      zenith_(p.zenith.cast<float>()),
      horizon_(p.horizon.cast<float>()),
      sunward_(p.horizon_sunward.cast<float>()),
      bright_(p.cloud_bright.cast<float>()),
      dark_(p.cloud_dark.cast<float>()),
      threshold_(Threshold(p.cloud_cover)),
      open_(1 - Step(0.75f, 1.0f, static_cast<float>(p.cloud_cover))),
      salt_(RandomStream(seed, "landscape bands' heights").Bits()) {}

float Sky::Cloud(float north_m, float east_m, int octaves) const {
  return clouds_.Fractal(north_m / kCloudSize_m, east_m / kCloudSize_m, octaves);
}

float Sky::Density(float noise) const { return Step(threshold_ - kThin, threshold_ + kThick, noise); }

Colour Sky::Haze(float azimuth) const {
  // Towards the sun the haze takes its colour; under a closed cover there is no such side.
  const float facing = 0.5f + 0.5f * std::cos(azimuth - std::atan2(sun_.y(), sun_.x()));
  return static_cast<float>(p_.light) * Mixed(horizon_, sunward_, facing * facing * facing);
}

Colour Sky::At(const Eigen::Vector3f& d) const {
  const float light = static_cast<float>(p_.light);
  const float azimuth = std::atan2(d.y(), d.x());
  if (d.z() < -0.05f) return Haze(azimuth);  // behind the ground
  const float up = std::max(d.z(), 0.0f);
  const float elevation = std::asin(std::min(up, 1.0f));
  const Colour haze = Haze(azimuth) / light;
  const float sunwards = AngleBetween(d, sun_);

  // Clear air: the haze's colour gives way to the zenith's.
  Colour colour = Mixed(zenith_, haze, std::exp(-elevation / (14 * kDegree)));
  const float shine = 0.75f * std::exp(-sunwards / (2.5f * kDegree)) +
                      0.35f * std::exp(-sunwards / (9 * kDegree)) +
                      0.12f * std::exp(-sunwards / (30 * kDegree));
  colour += open_ * shine * glow_;
  const float disc = p_.sun_elevation_deg > -0.3 ? Step(1.15f * kSunRadius, 0.85f * kSunRadius, sunwards) : 0;
  colour += disc * open_ * 2 * glow_;

  if (p_.cloud_cover > 0) {
    // Where the line of sight meets the clouds' layer, above a round Earth.
    constexpr float kRadius = static_cast<float>(kEarth_m);
    const float reach = std::sqrt(kRadius * kRadius * up * up + 2 * kRadius * kCloudBase_m) - kRadius * up;
    const float north = reach * d.x(), east = reach * d.y();
    // Far clouds are seen edge on: their small parts melt into each other.
    const int octaves = std::clamp(static_cast<int>(6.5f - std::log2(std::max(1.0f, reach / 6000))), 2, 6);
    const float here = Cloud(north, east, octaves);
    const float density = Density(here) * (0.9f + 0.1f * here);
    if (density > 0) {
      const Eigen::Vector2f level = sun_.head<2>() / std::max(sun_.head<2>().norm(), 0.1f);
      const float beside = Cloud(north + 350 * level.x(), east + 350 * level.y(), octaves);
      // Bright where the layer thins towards the sun and round it, dark where it is thick.
      const float thick = Step(threshold_, threshold_ + 0.3f, here);
      float lit = 0.72f + 2.6f * (here - beside) - 0.65f * thick;
      lit += 0.35f * std::exp(-sunwards / (25 * kDegree));
      if (p_.sun_elevation_deg < 12) lit *= 0.55f + 0.75f * std::exp(-sunwards / (55 * kDegree));
      const Colour cloud = Mixed(dark_, bright_, std::clamp(lit, 0.0f, 1.0f)) +
                           0.3f * open_ * std::exp(-sunwards / (6 * kDegree)) * glow_;
      colour = Mixed(colour, cloud, density);
    }
    const float far = 1 - std::exp(-kFade * reach / (3 * static_cast<float>(p_.haze_m) + 20000));
    colour = Mixed(colour, haze + open_ * 0.5f * shine * glow_, far);
  }
  colour = WithBands(colour, elevation, azimuth);
  if (p_.haze_layer.top_deg > 0) {
    // Its edge is a quarter of a degree wide, and somewhat darker than the haze below it.
    const float top = static_cast<float>(p_.haze_layer.top_deg) * kDegree, soft = 0.12f * kDegree;
    const float within = 1 - Step(top - soft, top + soft, elevation);
    colour = Mixed(colour, 0.88f * haze, static_cast<float>(p_.haze_layer.density) * within);
  }
  // The band of haze over the horizon.
  const float band =
      std::exp(-elevation / (1.2f * kDegree * std::sqrt(20000 / static_cast<float>(p_.haze_m))));
  colour = Mixed(colour, haze, 0.85f * band * (1 - disc * open_));
  return light * colour;
}

// Dark streaks and lit ones in turn, a fifth to four fifths as wide as they lie apart, here and there broken.
Colour Sky::WithBands(const Colour& colour, float elevation, float azimuth) const {
  Colour with = colour;
  for (int k = 0; k < p_.bands.count; ++k) {
    const float share = (static_cast<float>(k) + Hashed(k, 1, salt_)) / static_cast<float>(p_.bands.count);
    const float middle = static_cast<float>(p_.bands.top_deg) * kDegree * share;
    const float half = static_cast<float>(p_.bands.top_deg) * kDegree * (0.1f + 0.3f * Hashed(k, 2, salt_)) /
                       static_cast<float>(p_.bands.count);
    const float turn = 3 + 4 * Hashed(k, 3, salt_), row = 11 * static_cast<float>(k);
    const float here =
        Step(0.40f, 0.55f, bands_.Fractal(turn * std::cos(azimuth) + row, turn * std::sin(azimuth), 4));
    const float soft = 0.06f * kDegree;  // of its edges
    const float within = Step(-half - soft, -half + soft, elevation - middle) *
                         (1 - Step(half - soft, half + soft, elevation - middle));
    const Colour streak = k % 2 == 0 ? dark_ : Colour(0.6f * bright_ + 0.4f * glow_);
    with = Mixed(with, streak,
                 static_cast<float>(p_.bands.contrast) * (0.5f + 0.5f * Hashed(k, 4, salt_)) * here * within);
  }
  return with;
}

Colour Sky::LevelLight() const {
  return static_cast<float>(p_.light) * (ambient_ + std::max(sun_.z(), 0.0f) * sunlight_);
}

Colour Sky::Lit(const Colour& albedo, const Eigen::Vector3f& normal, float north, float east) const {
  float clear = 1;
  if (p_.cloud_cover > 0 && p_.cloud_cover < 1) {
    // The cloud between here and the sun.
    const float shift = kCloudBase_m / std::max(sun_.z(), 0.1f);
    const float above =
        clouds_.Fractal((north + shift * sun_.x()) / kCloudSize_m, (east + shift * sun_.y()) / kCloudSize_m,
                        3, threshold_ - kThin, threshold_ + kThick);
    clear = 1 - 0.75f * Density(above);
  }
  const float facing = std::max(0.0f, normal.dot(sun_));
  return static_cast<float>(p_.light) *
         albedo.cwiseProduct(ambient_ * (0.75f + 0.25f * normal.z()) + clear * facing * sunlight_);
}

Colour Sky::Hazed(const Colour& colour, float distance_m, float azimuth) const {
  return Mixed(Haze(azimuth), colour, std::exp(-kFade * distance_m / static_cast<float>(p_.haze_m)));
}

}  // namespace kestrel::sim::landscape
