// SPDX-License-Identifier: Apache-2.0
#include "sim/landscape/landscape.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "geometry/tait_bryan.h"
#include "sim/camera/renderer.h"
#include "sim/camera/skyline/horizon.h"
#include "sim/landscape/ground.h"
#include "sim/landscape/scenery.h"
#include "sim/landscape/sky.h"
#include "sim/landscape/terrain.h"
#include "sim/world/mjcf.h"
#include "sim/world/scene.h"

namespace kestrel::sim {
namespace {

// Nothing but round ground.
LandscapeParameters Bare() {
  LandscapeParameters p;
  p.hills_deg = 0;
  p.trees = p.buildings = 0;
  return p;
}

// Without pictures, which take longer than all the rest.
ModelPtr Unpainted(const LandscapeParameters& p) {
  const LandscapeModel landscape = MakeLandscape(p, 1);
  CompiledModel compiled = CompileMjcf(landscape.mjcf, landscape.files);
  EXPECT_EQ(compiled.message, "");
  return std::move(compiled.model);
}
ModelPtr Painted(const LandscapeParameters& p) {
  ModelPtr model = Unpainted(p);
  PaintLandscape(p, 1, model.get());
  return model;
}

DataPtr Computed(const mjModel* model) {
  DataPtr data = MakeData(model);
  mj_forward(model, data.get());
  return data;
}

// Level, towards an azimuth, from over a place.
Pose Level(double azimuth_deg, const Eigen::Vector3d& p_NC) {
  Eigen::Matrix3d R_BC;  // the camera looks forward
  R_BC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return {Eigen::Quaterniond(HeadingRotation(Radians(azimuth_deg)) * Eigen::Quaterniond(R_BC)), p_NC};
}

// A tenth of a mrad to a pixel.
const vision::Pinhole kTelescope{320, 240, 1e4, 1e4, 159.5, 119.5};
const vision::Pinhole kWide{320, 240, 160, 160, 159.5, 119.5};

TEST(Landscape, TheFreeHorizonLiesLowerByItsDipAtEveryHeightAllRound) {
  const ModelPtr model = Unpainted(Bare());
  const DataPtr data = Computed(model.get());
  Renderer renderer(model.get(), kTelescope, {});
  int checked = 0;
  for (const double height : {2.0, 10.0, 50.0, 500.0}) {
    for (const double azimuth_deg : {-170.0, -95.0, -20.0, 0.0, 33.0, 90.0, 128.0}) {
      const Eigen::Vector3d p(20, -15, -height);
      const double dip = std::sqrt(2 * height / 6371e3);
      // Pitched down so that the horizon passes through the middle; the dip is found from the rays alone.
      Pose X_NC = Level(azimuth_deg, p);
      X_NC.R = X_NC.R * Eigen::AngleAxisd(-dip, Eigen::Vector3d::UnitX());
      const cv::Mat classes = ClassifySky(model.get(), renderer.Trace(data.get(), X_NC));
      const auto line = TrueSkyline(classes, kTelescope, X_NC);
      ASSERT_GT(line.size(), 300u) << height << " m, " << azimuth_deg;
      for (const SkylinePoint& point : line)
        EXPECT_NEAR(-point.elevation_rad, dip, 0.6e-4) << height << " m, " << azimuth_deg;
      EXPECT_NEAR(HorizonOf(X_NC).dip_rad, dip, 1e-12);
      EXPECT_NEAR((X_NC.R * HorizonOf(X_NC).up_C + Eigen::Vector3d::UnitZ()).norm(), 0, 1e-12);
      ++checked;
    }
  }
  EXPECT_EQ(checked, 28);
}

TEST(Landscape, ARidgeOfTenDegreesShowsAtTenDegreesOnItsSideAlone) {
  LandscapeParameters p = Bare();
  p.ridge = {.azimuth_deg = 60, .height_deg = 10, .width_deg = 90, .distance_m = 6000};
  const ModelPtr model = Unpainted(p);
  const DataPtr data = Computed(model.get());
  Renderer renderer(model.get(), kWide, {});
  const auto highest_and_lowest = [&](double azimuth_deg) {
    const Pose X_NC = Level(azimuth_deg, {0, 0, -2});
    const cv::Mat classes = ClassifySky(model.get(), renderer.Trace(data.get(), X_NC));
    std::pair<double, double> range{1e9, -1e9};
    for (const SkylinePoint& point : TrueSkyline(classes, kWide, X_NC)) {
      if (std::abs(std::remainder(Degrees(point.azimuth_rad) - azimuth_deg, 360)) > 30) continue;
      range = {std::min(range.first, Degrees(point.elevation_rad)),
               std::max(range.second, Degrees(point.elevation_rad))};
    }
    return range;
  };
  const auto [low, high] = highest_and_lowest(60);
  EXPECT_GT(low, 9.2);
  EXPECT_LT(high, 10.2);
  for (const double azimuth_deg : {180.0, 240.0, -60.0}) {
    const auto [free_low, free_high] = highest_and_lowest(azimuth_deg);
    EXPECT_GT(free_low, -0.4);
    EXPECT_LT(free_high, 0.4);
  }
}

TEST(Landscape, TheHighestHillReachesItsAngleAndOneSidedOnesLeaveTheOtherSideFree) {
  LandscapeParameters p = Bare();
  p.hills_deg = 4;
  p.hills_azimuth_deg = 90;
  p.hills_one_sided = 1;
  const ModelPtr model = Unpainted(p);
  const DataPtr data = Computed(model.get());
  Renderer renderer(model.get(), kWide, {});
  double east = -90, west = -90;
  for (int azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += 60) {
    const Pose X_NC = Level(azimuth_deg, {0, 0, -0.5});
    const cv::Mat classes = ClassifySky(model.get(), renderer.Trace(data.get(), X_NC));
    for (const SkylinePoint& point : TrueSkyline(classes, kWide, X_NC)) {
      const double off_deg = std::abs(std::remainder(Degrees(point.azimuth_rad) - 90, 360));
      double& highest = off_deg < 100 ? east : west;
      if (off_deg < 100 || off_deg > 150) highest = std::max(highest, Degrees(point.elevation_rad));
    }
  }
  EXPECT_NEAR(east, 4, 0.25);  // half a pixel is 0.18 degrees
  EXPECT_LT(west, 0.2);
}

TEST(Landscape, TheBrightestOfTheSkyIsWhereTheSunIs) {
  LandscapeParameters p = Bare();
  p.cloud_cover = 0;
  p.light = 0.4;  // the disc alone is white then, not its glow
  int checked = 0;
  for (const auto& [azimuth_deg, elevation_deg] : {std::pair{100.0, 8.0}, std::pair{-50.0, 14.0}}) {
    p.sun_azimuth_deg = azimuth_deg;
    p.sun_elevation_deg = elevation_deg;
    const ModelPtr model = Painted(p);
    const DataPtr data = Computed(model.get());
    const vision::Pinhole camera{320, 240, 400, 400, 159.5, 119.5};
    Renderer renderer(model.get(), camera, {});
    // Off the axis, so that a flipped sky fails.
    const Pose X_NC = Level(azimuth_deg - 9, {0, 0, -30});
    cv::Mat grey;
    cv::cvtColor(renderer.Render(data.get(), X_NC), grey, cv::COLOR_BGR2GRAY);
    double brightest = 0;
    cv::minMaxLoc(grey, nullptr, &brightest);
    cv::Moments moments = cv::moments(grey >= brightest - 20, true);
    const Eigen::Vector2d seen(moments.m10 / moments.m00, moments.m01 / moments.m00);
    const double a = Radians(azimuth_deg), e = Radians(elevation_deg);
    const Eigen::Vector3d sun_N(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), -std::sin(e));
    const auto expected =
        vision::Project(vision::CameraModel(camera), Eigen::Vector3d(X_NC.R.conjugate() * sun_N));
    ASSERT_TRUE(expected);
    EXPECT_LT((seen - *expected).norm(), 2.0) << seen.transpose() << " not " << expected->transpose();
    EXPECT_GT(moments.m00, 2);
    EXPECT_LT(moments.m00, 60);  // half a degree across: 11 px
    ++checked;
  }
  EXPECT_EQ(checked, 2);
}

std::string BytesOf(const mjModel* m) {
  return std::string(reinterpret_cast<const char*>(m->tex_rgb), static_cast<std::size_t>(m->ntexdata)) +
         std::string(reinterpret_cast<const char*>(m->mesh_vert),
                     sizeof(float) * 3 * static_cast<std::size_t>(m->nmeshvert));
}

TEST(Landscape, TheSameSeedMakesTheSameBitsAndAnotherOneOthers) {
  LandscapeParameters p;
  p.trees = 20;
  p.buildings = 3;
  const auto made = [&](std::uint64_t run_seed) {
    const LandscapeModel landscape = MakeLandscape(p, run_seed);
    const CompiledModel compiled = CompileMjcf(landscape.mjcf, landscape.files);
    PaintLandscape(p, run_seed, compiled.model.get());
    return BytesOf(compiled.model.get());
  };
  const std::string first = made(1), other = made(2);
  EXPECT_FALSE(first == other);
  p.seed = 2;
  EXPECT_TRUE(other == made(1)) << "a landscape with a seed of its own does not depend on the run's";
}

TEST(Landscape, HazeDrawsTheFarGroundToTheSkyAboveIt) {
  // How far the ground just below the horizon is from the sky just above it, in grey levels.
  const auto contrast = [](double haze_m) {
    LandscapeParameters p = Bare();
    p.cloud_cover = 0;
    p.haze_m = haze_m;
    const ModelPtr model = Painted(p);
    const DataPtr data = Computed(model.get());
    Renderer renderer(model.get(), kWide, {});
    cv::Mat grey;
    cv::cvtColor(renderer.Render(data.get(), Level(0, {0, 0, -60})), grey, cv::COLOR_BGR2GRAY);
    return cv::mean(grey.rowRange(116, 119))[0] - cv::mean(grey.rowRange(124, 127))[0];
  };
  const double clear = contrast(200e3), thick = contrast(2000);
  EXPECT_GT(clear, 25);
  EXPECT_LT(std::abs(thick), 12);
}

TEST(Landscape, MayBeWithoutAPadButItsPlaceStays) {
  SceneParameters scene;
  scene.landscape = Bare();
  scene.vehicle = KESTREL_SOURCE_DIR "/models/vehicles/pelican/pelican.xml";
  scene.pad_position_m = {3, 4};
  scene.pad_yaw_deg = 30;
  const ModelPtr model = MakeModel(scene, false);
  const DataPtr data = Computed(model.get());
  EXPECT_EQ(mj_name2id(model.get(), mjOBJ_GEOM, "pad"), -1);
  const Pose X_NT = PadPose(model.get(), data.get());
  EXPECT_LT((X_NT.p - Eigen::Vector3d(3, 4, 0)).norm(), 1e-9);
  EXPECT_LT(X_NT.R.angularDistance(HeadingRotation(Radians(30))), 1e-9);
}

TEST(Landscape, StandsOnPlaneGroundAndItsMeshesTouchNothing) {
  const ModelPtr model = Unpainted(LandscapeParameters());
  const int ground = mj_name2id(model.get(), mjOBJ_GEOM, "ground");
  ASSERT_GE(ground, 0);
  EXPECT_EQ(model->geom_type[ground], mjGEOM_PLANE);
  EXPECT_NE(model->geom_contype[ground], 0);
  int seen_alone = 0;
  for (int g = 0; g < model->ngeom; ++g) {
    if (g == ground) continue;
    EXPECT_EQ(model->geom_contype[g] | model->geom_conaffinity[g], 0) << g;
    ++seen_alone;
  }
  EXPECT_EQ(seen_alone, 3);  // the lawn, the round ground, what stands on it
}

// Of a colour in the sky; elevation and azimuth in degrees.
landscape::Colour SkyAt(const landscape::Sky& sky, double elevation_deg, double azimuth_deg) {
  const double e = Radians(elevation_deg), a = Radians(azimuth_deg);
  return sky.At(
      Eigen::Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)).cast<float>());
}

TEST(Landscape, ALayerOfHazeEndsAtItsElevationAllRound) {
  LandscapeParameters p = Bare();
  p.cloud_cover = 0;
  const landscape::Sky clear(p, 1);
  p.haze_layer = {3, 0.7};
  const landscape::Sky layered(p, 1);
  for (const double azimuth_deg : {-150.0, -60.0, 0.0, 80.0, 170.0}) {
    EXPECT_GT((SkyAt(clear, 2.7, azimuth_deg) - SkyAt(layered, 2.7, azimuth_deg)).norm(), 0.03f);
    EXPECT_EQ(SkyAt(clear, 3.3, azimuth_deg), SkyAt(layered, 3.3, azimuth_deg));
  }
}

TEST(Landscape, BandsAreStreaksBelowTheirTopAlone) {
  LandscapeParameters p = Bare();
  p.cloud_cover = 0;
  const landscape::Sky clear(p, 1);
  p.bands = {6, 9, 0.8};
  const landscape::Sky banded(p, 1);
  const auto turns = [](const landscape::Sky& sky, double azimuth_deg) {
    int count = 0;
    for (double e = 0.4; e < 9; e += 0.05) {
      const auto brightness = [&](double elevation_deg) {
        return SkyAt(sky, elevation_deg, azimuth_deg).sum();
      };
      count += (brightness(e + 0.05) - brightness(e)) * (brightness(e) - brightness(e - 0.05)) < -1e-6;
    }
    return count;
  };
  int of_clear = 0, of_banded = 0;
  for (double azimuth_deg = -180; azimuth_deg < 180; azimuth_deg += 30) {
    of_clear += turns(clear, azimuth_deg);
    of_banded += turns(banded, azimuth_deg);
    EXPECT_EQ(SkyAt(clear, 10.5, azimuth_deg), SkyAt(banded, 10.5, azimuth_deg));
  }
  EXPECT_EQ(of_clear, 0);
  EXPECT_GT(of_banded, 24);
}

TEST(Landscape, TheSunGlittersOnWavesBelowItAndNotOnTheOtherSide) {
  LandscapeParameters p = Bare();
  p.cloud_cover = 0;
  p.water_share = 1;
  p.waves.slope = 0.12;
  p.sun_elevation_deg = 20;
  const auto brightness = [&p](double azimuth_deg) {
    const landscape::Terrain terrain(p, 1);
    const landscape::Sky sky(p, 1);
    const landscape::Ground ground(p, 1, terrain, sky);
    const double r = 60 / std::tan(Radians(20)), a = Radians(azimuth_deg);  // where a level facet mirrors it
    float sum = 0;
    for (int k = 0; k < 20; ++k)
      sum += ground
                 .At(static_cast<float>((r + 3 * k) * std::cos(a)),
                     static_cast<float>((r + 3 * k) * std::sin(a)), 3)
                 .sum();
    return sum / 20;
  };
  const double sun_deg = p.sun_azimuth_deg;
  const float below = brightness(sun_deg), opposite = brightness(sun_deg + 180);
  EXPECT_GT(below, 2 * opposite);
  p.waves.glitter = 0;
  EXPECT_LT(brightness(sun_deg), below / 1.5f);
}

TEST(Landscape, TowersStandOverTheHorizonInAPartOfTheView) {
  LandscapeParameters p = Bare();
  p.towers = 60;
  const landscape::Terrain terrain(p, 1);
  const landscape::Sky sky(p, 1);
  const landscape::Ground ground(p, 1, terrain, sky);
  const landscape::Scenery scenery = landscape::MakeScenery(p, 1, terrain, sky, ground);
  double highest_deg = 0;
  int turned[12] = {};  // vertices above 1 degree, by azimuth
  for (const Eigen::Vector3f& v : scenery.mesh.vertices) {
    const double elevation_deg = Degrees(std::atan2(v.z() - 2, std::hypot(v.x(), v.y())));
    highest_deg = std::max(highest_deg, elevation_deg);
    if (elevation_deg > 1)
      ++turned[static_cast<int>((std::atan2(v.y(), v.x()) / std::numbers::pi + 1) * 5.999)];
  }
  EXPECT_GT(highest_deg, 3);
  EXPECT_LT(highest_deg, 15);
  EXPECT_GE(std::count(std::begin(turned), std::end(turned), 0), 3);
}

}  // namespace
}  // namespace kestrel::sim
