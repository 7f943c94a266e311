// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/scenery.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace kestrel::sim::landscape {
namespace {

constexpr float kFullTurn = 2 * std::numbers::pi_v<float>;
const Colour kTrunk(0.28f, 0.22f, 0.17f), kWindow(0.16f, 0.19f, 0.24f);

using Point = Eigen::Vector3f;  // north, east, up

class Builder {
 public:
  Builder(Scenery& scenery, const Sky& sky) : scenery_(scenery), sky_(sky) {}

  // Corners clockwise as seen: counterclockwise in the numbers of north, east, up, which are left-handed.
  void Triangle(const Point& a, const Point& b, const Point& c, const Colour& albedo) {
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized();
    if (!normal.allFinite()) return;
    const Point middle = (a + b + c) / 3;
    Paint(a, b, c, sky_.Lit(albedo, normal, middle.x(), middle.y()));
  }
  void Quad(const Point& a, const Point& b, const Point& c, const Point& d, const Colour& albedo) {
    Triangle(a, b, c, albedo);
    Triangle(a, c, d, albedo);
  }
  // In a colour that is lit already.
  void Paint(const Point& a, const Point& b, const Point& c, const Colour& lit) {
    const int face = static_cast<int>(scenery_.colours.size());
    if (face >= kPalette * kPalette) return;
    const Point middle = (a + b + c) / 3;
    Mesh& mesh = scenery_.mesh;
    for (const Point& p : {a, c, b}) {  // the other way round in M
      mesh.vertices.emplace_back(p.x(), -p.y(), p.z());
      mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);  // it is drawn as painted
      mesh.st.emplace_back((static_cast<float>(face % kPalette) + 0.5f) / kPalette,
                           (static_cast<float>(face / kPalette) + 0.5f) / kPalette);
    }
    mesh.faces.emplace_back(3 * face, 3 * face + 1, 3 * face + 2);
    scenery_.colours.push_back(
        sky_.Hazed(lit, std::hypot(middle.x(), middle.y()), std::atan2(middle.y(), middle.x())));
  }

 private:
  Scenery& scenery_;
  const Sky& sky_;
};

struct Site {
  float north, east, up;
};

// How many facets a round thing has: the fewer, the smaller it is as seen from the origin, about which flights are flown.
int Facets(int most, int least, float around_m, const Site& site) {
  constexpr float kFinest_rad = 0.014f;
  const float seen = around_m / (kFinest_rad * std::hypot(site.north, site.east));
  return std::clamp(static_cast<int>(seen), least, most);
}

// A leafy crown: a rough ball of rings, wider than high or the other way.
void Crown(Builder& builder, const Site& site, const Point& centre, float radius, float half_height,
           const Colour& leaves, RandomStream& random) {
  constexpr int kBands = 9, kAround = 14;
  // All are drawn, so that nothing else depends on how many there are.
  float bumps[kBands + 1][kAround], lights[kBands][kAround];
  for (int i = 0; i <= kBands; ++i) {
    for (int j = 0; j < kAround; ++j) {
      bumps[i][j] = i == 0 || i == kBands ? 1.0f : static_cast<float>(random.Uniform(0.70, 1.18));
      if (i < kBands) lights[i][j] = static_cast<float>(random.Uniform(0.5, 1.4));
    }
  }
  const int around = Facets(kAround, 6, kFullTurn * radius, site),
            bands = std::max(4, kBands * around / kAround);
  Point p[kBands + 1][kAround];
  Colour light[kBands][kAround];
  for (int i = 0; i <= bands; ++i) {
    const float polar = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(bands);
    for (int j = 0; j < around; ++j) {
      const float turn =
          kFullTurn * (static_cast<float>(j) + 0.5f * static_cast<float>(i % 2)) / static_cast<float>(around);
      const float bump = i == bands ? 1.0f : bumps[i][j];
      p[i][j] = centre + Point(bump * radius * std::sin(polar) * std::cos(turn),
                               bump * radius * std::sin(polar) * std::sin(turn),
                               bump * half_height * std::cos(polar));
      if (i < bands) light[i][j] = leaves * lights[i][j];
    }
  }
  for (int i = 0; i < bands; ++i) {
    for (int j = 0; j < around; ++j) {
      const int k = (j + 1) % around, odd = i % 2;
      // Rows are half a step apart: which diagonal is the short one alternates.
      const Point &a = p[i][j], &b = p[i][k], &c = p[i + 1][odd ? k : j],
                  &e = p[i + 1][odd ? (k + 1) % around : k];
      if (i > 0) builder.Triangle(a, c, b, light[i][j]);
      if (i + 1 < bands) builder.Triangle(b, c, e, 0.9f * light[i][j]);
    }
  }
}

void Cone(Builder& builder, const Site& site, const Point& base, float radius, float height,
          const Colour& colour, RandomStream& random) {
  constexpr int kAround = 9;
  float lights[kAround];
  for (float& light : lights) light = static_cast<float>(random.Uniform(0.7, 1.2));
  const int around = Facets(kAround, 5, kFullTurn * radius, site);
  const Point tip = base + Point(0, 0, height);
  for (int j = 0; j < around; ++j) {
    const auto at = [&](int k) {
      const float turn = kFullTurn * static_cast<float>(k % around) / static_cast<float>(around);
      return Point(base + radius * Point(std::cos(turn), std::sin(turn), 0));
    };
    builder.Triangle(tip, at(j), at(j + 1), colour * lights[j]);
  }
}

// Where the sun does not reach level ground: an ellipse from the foot, away from it, in the colours of the
// ground without the sun. Each shadow lies a little above the one before it.
class Shadows {
 public:
  Shadows(const LandscapeParameters& p, const Sky& sky, const Ground& ground)
      : sky_(sky),
        ground_(ground),
        left_(p.ambient.cast<float>().cwiseQuotient(
            (p.ambient.cast<float>() + std::max(sky.sun().z(), 0.0f) * p.sunlight.cast<float>())
                .cwiseMax(1e-3f))) {}

  void Cast(Builder& builder, const Site& site, float radius, float height) {
    const Point sun = sky_.sun();
    const float away_m = std::hypot(site.north, site.east);
    if (left_.mean() > 0.96f || sun.z() < 0.1f || site.up > 3 || away_m > 800) return;
    const Eigen::Vector2f away = -sun.head<2>().normalized();
    const float length = std::min(height * sun.head<2>().norm() / sun.z(), 12 * height);
    const float half = 0.5f * length + 0.6f * radius;
    const Point middle(site.north + 0.55f * length * away.x(), site.east + 0.55f * length * away.y(), 0);
    const float up = site.up + 0.02f + 0.0005f * static_cast<float>(count_++ % 200);
    const int steps = 4 + static_cast<int>(half / 3);
    const auto at = [&](int k, float side) {
      const float along = 2 * static_cast<float>(k) / static_cast<float>(steps) - 1;
      const float across = side * radius * std::sqrt(std::max(0.0f, 1 - along * along));
      return Point(middle + Point(half * along * away.x() - across * away.y(),
                                  half * along * away.y() + across * away.x(), up));
    };
    for (int k = 0; k < steps; ++k) {
      const Point a = at(k, -1), b = at(k + 1, -1), c = at(k + 1, 1), d = at(k, 1);
      const Point centre = (a + b + c + d) / 4;
      const Colour dark = left_.cwiseProduct(ground_.At(centre.x(), centre.y(), 3));
      builder.Paint(a, b, c, dark);
      builder.Paint(a, c, d, dark);
    }
  }

 private:
  const Sky& sky_;
  const Ground& ground_;
  Colour left_;  // of the light
  int count_ = 0;
};

void Tree(Builder& builder, const LandscapeParameters& p, const Site& site, Shadows& shadows,
          RandomStream& random) {
  const float height = static_cast<float>(random.Uniform(6, 17));
  const float which = static_cast<float>(random.Uniform(0, 1));
  const bool conifer = random.Uniform(0, 1) < 0.3;
  const Colour leaves = conifer ? p.forest.cast<float>() * 0.9f
                                : Mixed(p.leaves.cast<float>(), p.leaves_other.cast<float>(), which);
  const Point foot(site.north, site.east, site.up - 0.5f);
  const float radius = conifer ? 0.2f * height : 0.30f * height;
  shadows.Cast(builder, site, radius, height);
  const float thick = 0.025f * height, top = conifer ? 0.25f * height : 0.45f * height;
  const int sides = Facets(5, 3, kFullTurn * thick, site);
  for (int k = 0; k < sides; ++k) {
    const auto at = [&](int j, float up) {
      const float turn = kFullTurn * static_cast<float>(j % sides) / static_cast<float>(sides);
      return Point(foot + Point(thick * std::cos(turn), thick * std::sin(turn), up));
    };
    builder.Quad(at(k, top), at(k, 0), at(k + 1, 0), at(k + 1, top), kTrunk);
  }
  if (!conifer)
    return Crown(builder, site, foot + Point(0, 0, 0.64f * height), radius, 0.36f * height, leaves, random);
  for (const float from : {0.16f, 0.42f, 0.66f})
    Cone(builder, site, foot + Point(0, 0, from * height), radius * (1.1f - from), 0.42f * height, leaves,
         random);
}

void Building(Builder& builder, const Site& site, Shadows& shadows, RandomStream& random) {
  const float length = static_cast<float>(random.Uniform(9, 32)),
              width = static_cast<float>(random.Uniform(7, 14));
  const int storeys = 1 + static_cast<int>(random.Uniform(0, 3.5));
  const float height = 3.2f * static_cast<float>(storeys);
  const float turn = static_cast<float>(random.Uniform(0, kFullTurn));
  const float grey = static_cast<float>(random.Uniform(0.45, 0.9)),
              warm = static_cast<float>(random.Uniform(0, 0.25));
  const Colour wall(grey, grey * (1 - 0.4f * warm), grey * (1 - warm));
  const bool gable = random.Uniform(0, 1) < 0.75;
  const Colour roof = random.Uniform(0, 1) < 0.6 ? Colour(0.46f, 0.24f, 0.18f) : Colour(0.33f, 0.34f, 0.37f);
  shadows.Cast(builder, site, 0.5f * width, height);
  const auto at = [&](float along, float across, float up) {
    return Point(site.north + along * std::cos(turn) - across * std::sin(turn),
                 site.east + along * std::sin(turn) + across * std::cos(turn), site.up + up);
  };
  const float l = length / 2, w = width / 2;
  const Eigen::Vector2f corners[5] = {{l, w}, {-l, w}, {-l, -w}, {l, -w}, {l, w}};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2f a = corners[k], b = corners[k + 1];
    builder.Quad(at(a.x(), a.y(), height), at(a.x(), a.y(), -1), at(b.x(), b.y(), -1),
                 at(b.x(), b.y(), height), wall);
    const Eigen::Vector2f outward = 0.03f * Eigen::Vector2f((a + b).normalized());
    const float span = (b - a).norm();
    const int windows = static_cast<int>(span / 3);
    for (int s = 0; s < storeys; ++s) {
      for (int i = 0; i < windows; ++i) {
        const auto corner = [&](float along, float up) {
          const Eigen::Vector2f q =
              a + outward + (b - a) * ((static_cast<float>(i) + along) / static_cast<float>(windows));
          return at(q.x(), q.y(), 3.2f * static_cast<float>(s) + up);
        };
        builder.Quad(corner(0.3f, 2.4f), corner(0.3f, 0.9f), corner(0.7f, 0.9f), corner(0.7f, 2.4f), kWindow);
      }
    }
  }
  const float eaves = height, ridge = gable ? height + 0.42f * width : height;
  const float o = 0.5f;  // how far the roof reaches over
  if (!gable) {
    builder.Quad(at(l, w, eaves), at(l, -w, eaves), at(-l, -w, eaves), at(-l, w, eaves), roof);
    builder.Quad(at(l, w, eaves), at(-l, w, eaves), at(-l, -w, eaves), at(l, -w, eaves), roof);
    return;
  }
  for (const float side : {1.0f, -1.0f}) {
    const Point a = at(l + o, side * (w + o), eaves - 0.2f), b = at(-l - o, side * (w + o), eaves - 0.2f);
    const Point c = at(-l - o, 0, ridge), d = at(l + o, 0, ridge);
    builder.Quad(a, b, c, d, roof);
    builder.Quad(d, c, b, a, roof);
    const Point e = at(side * l, w, eaves), f = at(side * l, -w, eaves), g = at(side * l, 0, ridge);
    builder.Triangle(e, f, g, wall);
    builder.Triangle(g, f, e, wall);
  }
}

// A high building, seen from afar: a block with rows of windows, and perhaps a narrower one on it.
void Tower(Builder& builder, const Site& site, RandomStream& random) {
  constexpr float kRow_m = 9;  // of windows and wall: finer than is seen from there
  const float turn = static_cast<float>(random.Uniform(0, kFullTurn));
  const float grey = static_cast<float>(random.Uniform(0.25, 0.8)),
              warm = static_cast<float>(random.Uniform(-0.15, 0.25));
  const Colour wall(grey * (1 + 0.3f * warm), grey, grey * (1 - warm)), glass = Mixed(wall, kWindow, 0.6f);
  float half = static_cast<float>(random.Uniform(9, 26)), foot = -5;
  const int blocks = random.Uniform(0, 1) < 0.3 ? 2 : 1;
  for (int block = 0; block < blocks; ++block, half *= 0.6f) {
    const float top = std::max(foot, 0.0f) +
                      static_cast<float>(block == 0 ? random.Uniform(20, 150) : random.Uniform(8, 40));
    const auto at = [&](int corner, float up) {
      const float a = turn + kFullTurn * (static_cast<float>(corner % 4) + 0.5f) / 4;
      return Point(site.north + 1.4f * half * std::cos(a), site.east + 1.4f * half * std::sin(a),
                   site.up + up);
    };
    for (int k = 0; k < 4; ++k)
      for (int row = 0; foot + kRow_m * static_cast<float>(row) < top; ++row) {
        const float low = foot + kRow_m * static_cast<float>(row), high = std::min(low + kRow_m, top),
                    middle = 0.5f * (low + high);
        builder.Quad(at(k, middle), at(k, low), at(k + 1, low), at(k + 1, middle), wall);
        builder.Quad(at(k, high), at(k, middle), at(k + 1, middle), at(k + 1, high), glass);
      }
    builder.Quad(at(3, top), at(2, top), at(1, top), at(0, top), 0.8f * wall);
    foot = top;
  }
}

}  // namespace

Scenery MakeScenery(const LandscapeParameters& p, std::uint64_t seed, const Terrain& terrain, const Sky& sky,
                    const Ground& ground) {
  Scenery scenery;
  Builder builder(scenery, sky);
  Shadows shadows(p, sky, ground);
  RandomStream random(seed, "landscape scenery");
  const auto site = [&](float nearest, float farthest) {
    Site s{};
    for (int attempt = 0; attempt < 8; ++attempt) {
      const float r = nearest * std::pow(farthest / nearest, static_cast<float>(random.Uniform(0, 1)));
      const float azimuth = static_cast<float>(random.Uniform(0, kFullTurn));
      s = {r * std::cos(azimuth), r * std::sin(azimuth), 0};
      if (!ground.IsWater(s.north, s.east)) break;
    }
    s.up = terrain.Height(s.north, s.east);
    return s;
  };
  for (int i = 0; i < p.buildings; ++i) Building(builder, site(70, 1500), shadows, random);
  for (int i = 0; i < p.trees;) {
    const Site first = site(40, 1500);
    const int group = random.Uniform(0, 1) < 0.5 ? 1 : 2 + static_cast<int>(random.Uniform(0, 9));
    const float spread = 0.8f * static_cast<float>(group) + 6;
    for (int k = 0; k < group && i < p.trees; ++k, ++i) {
      Site s = first;
      if (k > 0) {
        s.north += spread * static_cast<float>(random.Normal());
        s.east += spread * static_cast<float>(random.Normal());
        s.up = terrain.Height(s.north, s.east);
      }
      if (std::hypot(s.north, s.east) < 25) continue;  // the start stays free
      Tree(builder, p, s, shadows, random);
    }
  }
  // In a part of the view, as cities lie.
  const float city = static_cast<float>(random.Uniform(0, kFullTurn));
  for (int i = 0; i < p.towers; ++i) {
    const float r = 800 * std::pow(5.0f, static_cast<float>(random.Uniform(0, 1)));
    const float azimuth = city + 0.7f * static_cast<float>(random.Normal());
    Site s{r * std::cos(azimuth), r * std::sin(azimuth), 0};
    s.up = terrain.Height(s.north, s.east);
    Tower(builder, s, random);
  }
  return scenery;
}

}  // namespace kestrel::sim::landscape
