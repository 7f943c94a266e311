// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "base/random.h"
#include "sim/render/ray/mesh/triangle_tree.h"
#include "sim/render/ray/ray_renderer.h"
#include "tests/sim/image_difference.h"
#include "tests/sim/render/reference_renderer.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

double LogUniform(RandomStream& random, double low, double high) {
  return std::exp(random.Uniform(std::log(low), std::log(high)));
}

// Things of all kinds and sizes, near and far, on all sides of the origin, some of them through each other.
std::string RandomWorld(RandomStream& random) {
  std::string xml = R"(<mujoco>
  <statistic center="0 0 0" extent="20"/>
  <visual><headlight ambient="0.3 0.3 0.3" diffuse="0.4 0.4 0.4" specular="0.3 0.3 0.3"/></visual>
  <asset>
    <texture name="picture" type="2d" file="picture.png"/><material name="picture" texture="picture"/>
    <texture name="faces" type="cube" file="faces.png" gridsize="6 1" gridlayout="RLUDFB"/>
    <material name="faces" texture="faces" texuniform="true"/>
    <mesh name="wedge" vertex="-1 -0.6 -0.5  1 -0.6 -0.5  1 0.6 -0.5  -1 0.6 -0.5  0 0 0.9"
      face="0 2 1  0 3 2  0 1 4  1 2 4  2 3 4  3 0 4"/>
    <hfield name="hill" file="relief.png" size="1.5 1 0.6 0.2"/>
  </asset>
  <worldbody>
    <light directional="true" dir="0.3 -0.4 -0.9" diffuse="0.5 0.5 0.4"/>)";
  const char* const types[] = {"box",     "sphere", "ellipsoid", "cylinder",
                               "capsule", "plane",  "mesh",      "hfield"};
  for (int i = 0; i < 60; ++i) {
    const std::string type = types[i % 8];
    const double size = LogUniform(random, 0.01, 3), away = size * LogUniform(random, 0.5, 40);
    Eigen::Vector3d p, turn;
    for (int k = 0; k < 3; ++k) p[k] = random.Uniform(-1, 1), turn[k] = random.Uniform(-180, 180);
    p *= away / p.norm();
    xml += fmt::format(R"(<geom type="{}" pos="{} {} {}" euler="{} {} {}")", type, p.x(), p.y(), p.z(),
                       turn.x(), turn.y(), turn.z());
    if (type == "mesh") {
      xml += R"( mesh="wedge")";
    } else if (type == "hfield") {
      xml += R"( hfield="hill")";
    } else {
      xml += fmt::format(R"( size="{} {} {}")", size * random.Uniform(0.1, 1), size * random.Uniform(0.1, 1),
                         size * random.Uniform(0.1, 1));
    }
    const int look = static_cast<int>(random.Uniform(0, 4));
    if (look == 0) xml += R"( material="picture")";
    if (look == 1) xml += R"( material="faces")";
    if (look > 1)
      xml += fmt::format(R"( rgba="{} {} {} {}")", random.Uniform(0, 1), random.Uniform(0, 1),
                         random.Uniform(0, 1), look == 2 && type != "mesh" && type != "hfield" ? 0.5 : 1);
    xml += "/>\n";
  }
  return xml + "</worldbody></mujoco>";
}

TEST(RandomWorlds, AreSeenAsTheReferenceSeesThem) {
  RandomStream random(11, "worlds");
  vision::KannalaBrandt fisheye{.width_px = 67, .height_px = 67, .fx = 19, .fy = 19, .cx = 33, .cy = 33};
  fisheye.max_angle_rad = 1.75;
  vision::Unified mirror{.width_px = 83, .height_px = 75, .fx = 42, .fy = 42, .cx = 41, .cy = 37};
  mirror.xi = 0.9, mirror.max_angle_rad = 2.0;
  const std::vector<vision::CameraModel> cameras{fisheye, mirror, vision::Pinhole{65, 49, 60, 60, 30, 24}};
  for (int i = 0; i < 12; ++i) {
    const ModelPtr model = CompileScene(RandomWorld(random));
    const DataPtr data = StateOf(model.get());
    const vision::CameraModel& camera = cameras[i % cameras.size()];
    const auto uniform = [&](double most) { return random.Uniform(-most, most); };
    const Eigen::Vector3d p_NC{uniform(0.2), uniform(0.2), uniform(0.2)};
    const double yaw = uniform(3), pitch = uniform(1.5), roll = uniform(3);
    const Pose X_NC = LookingFrom(p_NC, yaw, pitch, roll);
    RayRenderer renderer(model.get(), camera, {});
    const reference::SurfaceErrors errors =
        reference::ErrorsOf(renderer.Trace(data.get(), X_NC), model.get(), data.get(), X_NC, camera);
    EXPECT_LE(errors.other_geom, 2) << "world " << i;
    EXPECT_LT(errors.depth, 5e-4) << "world " << i;  // a flat side seen along itself
    if (i % 3 != i / 3) continue;                    // pictures of one world for each camera
    const ImageDifference difference = Compare(renderer.Render(data.get(), X_NC),
                                               reference::Render(model.get(), data.get(), X_NC, camera, 4));
    EXPECT_LT(difference.mean, 1) << "world " << i << ": " << difference;
    EXPECT_LE(difference.of_99, 20) << "world " << i << ": " << difference;
  }
}

// A pixel is 0.2 m wide at these.
TEST(ThinThings, KeepTheirShareOfLight) {
  for (const char* thing : {R"(type="cylinder" size="0.02 6" euler="10 0 0" rgba="1 1 1 1")",
                            R"(type="capsule" size="0.04 4" euler="80 0 0" rgba="1 1 1 1")",
                            R"(type="box" size="0.01 0.03 5" euler="-40 0 0" rgba="1 1 1 1")",
                            R"(type="sphere" size="0.05" rgba="1 1 1 1")",
                            R"(type="ellipsoid" size="0.08 0.08 0.05" rgba="1 1 1 0.5")"}) {
    const ModelPtr model = CompileScene(fmt::format(R"(<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody><geom pos="20 0.13 0.04" {}/></worldbody>
</mujoco>)",
                                                    thing));
    const DataPtr data = StateOf(model.get());
    const vision::CameraModel camera = vision::Pinhole{96, 64, 100, 100, 47.3, 31.6};
    const Pose X_NC = LookingFrom({0, 0, 0}, 0, 0);
    const double light = cv::sum(RayRenderer(model.get(), camera, {}).Render(data.get(), X_NC))[0];
    const double truth = cv::sum(reference::Render(model.get(), data.get(), X_NC, camera, 16))[0];
    // One ray of the sixteen of a pixel more or less, for what covers not even one pixel.
    EXPECT_NEAR(light, truth, std::max(0.05 * truth, 255.0 / 16)) << thing;
  }
}

// MuJoCo's own shadow maps are too coarse to compare with: this is the definition.
TEST(Shadows, FallWhereTheLightIsHidden) {
  if (ray::EmbreeVersion() == "none") GTEST_SKIP() << "this build has no Embree";
  const ModelPtr model = CompileScene(R"(<mujoco>
  <visual><headlight ambient="0.3 0.3 0.3" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset>
    <mesh name="wedge" vertex="-1 -0.6 -0.5  1 -0.6 -0.5  1 0.6 -0.5  -1 0.6 -0.5  0 0 0.9"
      face="0 2 1  0 3 2  0 1 4  1 2 4  2 3 4  3 0 4"/>
    <hfield name="hill" file="relief.png" size="1.5 1 0.6 0.2"/>
  </asset>
  <worldbody>
    <light directional="true" dir="0.3 -0.6 -0.7" diffuse="0.4 0.4 0.3" ambient="0.1 0.1 0.1" specular="0 0 0"/>
    <light pos="5 2 3" dir="0 -0.3 -1" cutoff="60" exponent="1" diffuse="0.4 0.3 0.3" specular="0.2 0.2 0.2"/>
    <light castshadow="false" directional="true" dir="1 0 -1" diffuse="0.1 0.1 0.2" specular="0 0 0"/>
    <geom type="plane" size="20 20 1"/>
    <geom type="box" pos="6 1 0.5" size="0.5 0.5 0.5" euler="0 0 30"/>
    <geom type="sphere" pos="5 -0.5 0.9" size="0.5"/>
    <geom type="capsule" pos="7 -1.5 0.8" size="0.2 0.8" euler="40 0 0"/>
    <geom type="cylinder" pos="8 0.5 0.8" size="0.4 0.8"/>
    <geom type="ellipsoid" pos="4 1.5 0.6" size="0.2 0.4 0.3"/>
    <geom type="mesh" mesh="wedge" pos="8 3 1"/>
    <geom type="hfield" hfield="hill" pos="9 -3 0.1"/>
  </worldbody>
</mujoco>)");
  const DataPtr data = StateOf(model.get());
  const vision::CameraModel camera = vision::Pinhole{120, 80, 100, 100, 59.5, 39.5};
  const Pose X_NC = LookingFrom({0, 0, -3}, 0, -0.4);
  const cv::Mat truth = reference::Render(model.get(), data.get(), X_NC, camera, 4, true);
  const cv::Mat drawn = RayRenderer(model.get(), camera, {.shadows = true}).Render(data.get(), X_NC);
  const ImageDifference difference = Compare(drawn, truth);
  EXPECT_LT(difference.mean, 1) << difference;
  EXPECT_LE(difference.of_99, 20) << difference;
  EXPECT_GT(Compare(drawn, RayRenderer(model.get(), camera, {}).Render(data.get(), X_NC)).mean, 3);
}

}  // namespace
}  // namespace kestrel::sim
