// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/ground.h"

#include <cmath>

namespace kestrel::sim::landscape {
namespace {

constexpr float kField_m = 260, kStrip_m = 130;
constexpr float kWoods_m = 1300, kLakes_m = 2400;
constexpr float kWave_m = 45;  // the longest
constexpr float kEye_m = 60;   // height from which water is seen, over it
const Colour kSnow(0.93f, 0.94f, 0.97f), kPath(0.55f, 0.51f, 0.45f);

int Octaves(float largest_m, float texel_m, int most) {
  return std::clamp(static_cast<int>(std::log2(std::max(1.0f, largest_m / texel_m))), 1, most);
}

}  // namespace

Ground::Ground(const LandscapeParameters& p, std::uint64_t seed, const Terrain& terrain, const Sky& sky)
    : p_(p),
      salt_(RandomStream(seed, "landscape fields").Bits()),
      terrain_(terrain),
      sky_(sky),
      detail_(seed, "landscape grass"),
      woods_(seed, "landscape woods"),
      lakes_(seed, "landscape lakes"),
      drifts_(seed, "landscape snow"),
      waves_(seed, "landscape waves"),
      grass_(p.grass.cast<float>()),
      crop_(p.crop.cast<float>()),
      soil_(p.soil.cast<float>()),
      forest_(p.forest.cast<float>()),
      forest_above_(Threshold(p.forest_share)),
      water_above_(Threshold(p.water_share)),
      snow_above_(Threshold(p.snow_share)) {}

bool Ground::IsWater(float north, float east) const {
  if (p_.water_share <= 0 || north * north + east * east < 150 * 150) return false;
  return lakes_.Fractal(north / kLakes_m, east / kLakes_m, 5, water_above_, water_above_) > water_above_ &&
         terrain_.HillHeight(north, east) < 0.004f * std::hypot(north, east);
}

Colour Ground::Albedo(float north, float east, float texel) const {
  // Fields: strips that bend a little, cut across at places of their own.
  const float bend = 60 * (detail_.At(north / 700 + 5, east / 700 + 9) - 0.5f);
  const float x = (0.92f * north + 0.39f * east + bend) / kField_m;
  const float y = (-0.39f * north + 0.92f * east - bend) / kStrip_m;
  const int column = static_cast<int>(std::floor(y));
  const float shifted = x + Hashed(column, 7, salt_);
  const int row = static_cast<int>(std::floor(shifted));
  const float kind = Hashed(row, column, salt_), shade = Hashed(row, column, salt_ + 1);
  Colour colour = kind < 0.45f   ? grass_
                  : kind < 0.75f ? crop_
                  : kind < 0.9f  ? soil_
                                 : Mixed(grass_, crop_, 0.5f);
  colour *= 0.85f + 0.3f * shade;
  // Fields smaller than a texel melt together.
  const float blend = Step(60, 400, texel);
  if (blend > 0) {
    const float wide = detail_.Fractal(north / 5000, east / 5000, Octaves(5000, texel, 5));
    colour = Mixed(colour, Mixed(Mixed(grass_, crop_, Step(0.35f, 0.65f, wide)), soil_, 0.15f), blend);
  }
  const float across = (y - static_cast<float>(column)) * kStrip_m,
              along = (shifted - static_cast<float>(row)) * kField_m;
  const float edge = std::min({across, kStrip_m - across, along, kField_m - along});
  const float rim =
      (1 - blend) * (1 - Step(1.2f, 1.2f + std::max(1.2f, texel), edge)) / std::max(1.0f, texel / 3);
  colour = Mixed(colour, Hashed(column, 3, salt_) < 0.5f ? kPath : forest_, 0.8f * rim);

  float wooded = Step(60, 160, std::hypot(north, east));  // the start stays free
  if (wooded > 0) {
    const float low = forest_above_ - 0.004f, high = forest_above_ + 0.008f;
    wooded *= Step(low, high,
                   woods_.Fractal(north / kWoods_m, east / kWoods_m, Octaves(kWoods_m, texel, 6), low, high));
  }
  if (wooded > 0) {
    // The crowns of trees, seen as mottle.
    const float crowns = detail_.Fractal(north / 9, east / 9, Octaves(9, texel, 2));
    colour = Mixed(colour, forest_ * (0.55f + 0.9f * crowns), wooded);
  }

  const float rough = detail_.Fractal(north / 40, east / 40, Octaves(40, texel, 7));
  float blades = 0;  // round the origin alone, where the picture is fine
  if (texel < 0.2f) {
    const float inner = 1 - Step(12, 29, std::max(std::abs(north), std::abs(east)));
    blades = inner * (detail_.Fractal(north / 0.4f, east / 0.4f, 3) - 0.5f);
  }
  colour *= std::max(0.2f, 0.4f + 1.2f * rough + 0.6f * blades * (1 - wooded));
  const float dry =
      Step(0.45f, 0.7f, detail_.Fractal(north / 15 + 100, east / 15, Octaves(15, texel, 4), 0.45f, 0.7f));
  colour = Mixed(colour, soil_ * (0.7f + 0.6f * rough), 0.35f * dry * (1 - wooded));

  if (p_.snow_share > 0) {
    const float height = 0.0006f * terrain_.HillHeight(north, east);
    const float low = snow_above_ - 0.03f, high = snow_above_ + 0.03f;
    const float here = height - 0.12f * wooded + 0.1f * (shade - 0.5f) * (1 - blend);
    const float noise =
        drifts_.Fractal(north / 170, east / 170, Octaves(170, texel, 8), low - here, high - here);
    const float drift = noise + height - 0.12f * wooded + 0.1f * (shade - 0.5f) * (1 - blend);
    colour = Mixed(colour, kSnow * (0.92f + 0.16f * (rough - 0.5f)), Step(low, high, drift));
  }
  return colour;
}

// Facets of all slopes: each mirrors the sky by Fresnel's law, as Schlick approximates it, and shows the water else. How
// many of them mirror the sun into the eye is by Cox and Munk: their slopes are normally distributed.
Colour Ground::Waves(float north, float east, float texel) const {
  const float r = std::hypot(north, east), azimuth = std::atan2(east, north);
  const float sigma = static_cast<float>(p_.waves.slope), down = std::atan2(kEye_m, r);
  const int octaves = Octaves(kWave_m, texel, 6);
  const float field = waves_.Fractal(north / kWave_m, east / (2.5f * kWave_m), octaves) - 0.5f;
  const float slope =
      5 * sigma * field * Step(1, 4, static_cast<float>(octaves));  // towards the eye; seen as such
  const float met = std::clamp(down + slope + 0.4f * sigma, 0.01f, 1.5f);
  const float mirrored = 0.02f + 0.98f * std::pow(1 - std::sin(met), 5.0f);
  const float up = std::clamp(down + 2 * slope + sigma, 0.01f, 1.5f);
  const Colour sky =
      sky_.At({std::cos(azimuth) * std::cos(up), std::sin(azimuth) * std::cos(up), std::sin(up)});
  Colour colour = Mixed(sky_.Lit(p_.waves.water.cast<float>(), Eigen::Vector3f::UnitZ(), north, east) * 2,
                        sky, 0.9f * mirrored);
  if (p_.sun_elevation_deg > 0 && p_.cloud_cover < 1) {
    const Eigen::Vector3f eye(-std::cos(azimuth) * std::cos(down), -std::sin(azimuth) * std::cos(down),
                              std::sin(down));
    const Eigen::Vector3f facet = (eye + sky_.sun()).normalized();
    const float steep2 = facet.head<2>().squaredNorm() / std::max(facet.z() * facet.z(), 1e-4f);
    float share = std::exp(-steep2 / (2 * sigma * sigma));
    if (texel < 6)
      share *= 2 * Step(0.45f, 0.75f, waves_.Fractal(north / (2 * texel), east / (2 * texel), 2));
    colour +=
        static_cast<float>(p_.waves.glitter * p_.light * (1 - p_.cloud_cover)) * share * p_.sun.cast<float>();
  }
  return colour;
}

Colour Ground::At(float north, float east, float texel) const {
  const float r = std::hypot(north, east), azimuth = std::atan2(east, north);
  Colour colour;
  const bool water = IsWater(north, east);
  if (water && p_.waves.slope > 0) {
    colour = Waves(north, east, texel);
  } else if (water) {
    // A mirror of the sky, ruffled: what is seen in it lies somewhat higher than the image of the eye, 60 m
    // up.
    const float up = std::atan2(kEye_m, r) + 0.05f + 0.04f * (detail_.At(north / 30, east / 30) - 0.5f);
    colour =
        0.82f * sky_.At({std::cos(azimuth) * std::cos(up), std::sin(azimuth) * std::cos(up), std::sin(up)});
  } else {
    colour = sky_.Lit(Albedo(north, east, texel), terrain_.Normal(north, east), north, east);
  }
  return sky_.Hazed(colour, r, azimuth);
}

}  // namespace kestrel::sim::landscape
