// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/ray_renderer.h"

#include <gmock/gmock.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/render/ray/instruction_set.h"
#include "tests/sim/image_difference.h"
#include "tests/sim/render/reference_renderer.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kRays = 6;  // of the reference, along each side of a pixel

// Each model with distortion of its own, several of them beyond 90 degrees from the axis; none is square to
// the image, all sides are no multiple of what is drawn at once.
const std::vector<vision::CameraModel>& Cameras() {
  static const std::vector<vision::CameraModel> cameras = [] {
    vision::BrownConrady bent{.width_px = 71, .height_px = 53, .fx = 52, .fy = 53, .cx = 36.3, .cy = 25.1};
    bent.k1 = -0.2, bent.k2 = 0.03, bent.p1 = 0.002, bent.p2 = -0.003;
    vision::Unified mirror{.width_px = 75, .height_px = 70, .fx = 55, .fy = 56, .cx = 36, .cy = 35.5};
    mirror.xi = 0.95, mirror.k1 = -0.05, mirror.max_angle_rad = 1.8;
    vision::KannalaBrandt fisheye{
        .width_px = 69, .height_px = 67, .fx = 20, .fy = 20.5, .cx = 33, .cy = 34.4};
    fisheye.k1 = 0.01, fisheye.k2 = -0.003, fisheye.max_angle_rad = 1.66;
    vision::DoubleSphere wide{.width_px = 73, .height_px = 51, .fx = 22, .fy = 22, .cx = 35.2, .cy = 26.6};
    wide.xi = -0.2, wide.alpha = 0.59, wide.max_angle_rad = 1.65;
    return std::vector<vision::CameraModel>{vision::Pinhole{100, 75, 82, 82, 49.5, 36.8}, bent, mirror,
                                            fisheye, wide};
  }();
  return cameras;
}

class RayOnScene : public ::testing::TestWithParam<TestScene> {
 protected:
  RayOnScene() : model_(CompileScene(GetParam().xml)), data_(StateOf(model_.get())) {}
  ModelPtr model_;
  DataPtr data_;
};

std::vector<TestScene> Scenes() {
  std::vector<TestScene> scenes = TestScenes();
  std::erase_if(scenes, [](const TestScene& s) { return s.opengl_alone; });
  return scenes;
}

// Edges included, which the reference draws by many rays for each pixel. What remains is the ray renderer's
// coarser smoothing of edges, and its filter for textures, which blurs what is seen at a slant.
TEST_P(RayOnScene, AgreesWithTheReferenceThroughEveryLens) {
  for (const vision::CameraModel& camera : Cameras()) {
    const ImageDifference difference =
        Compare(RayRenderer(model_.get(), camera, {}).Render(data_.get(), GetParam().X_NC),
                reference::Render(model_.get(), data_.get(), GetParam().X_NC, camera, kRays));
    EXPECT_LT(difference.mean, 2) << vision::NameOf(camera) << ": " << difference;
    EXPECT_LE(difference.of_99, 30) << vision::NameOf(camera) << ": " << difference;
    EXPECT_LE(difference.most, 110) << vision::NameOf(camera) << ": " << difference;
  }
}

// Neighbours of one mesh have one normal there, and one is told from the other by how far away it is. A pixel between
// them by one ray would be wrong by half of what their colours differ, which is 190.
TEST(RayRenderer, SmoothsTheEdgeOfAFacetBeforeAnotherOfTheSameMesh) {
  const std::vector<TestScene> scenes = TestScenes();
  const auto facets =
      std::find_if(scenes.begin(), scenes.end(), [](const TestScene& s) { return s.name == "Facets"; });
  ASSERT_NE(facets, scenes.end());
  const ModelPtr model = CompileScene(facets->xml);
  const DataPtr data = StateOf(model.get());
  const ImageDifference difference =
      Compare(RayRenderer(model.get(), Cameras()[0], {}).Render(data.get(), facets->X_NC),
              reference::Render(model.get(), data.get(), facets->X_NC, Cameras()[0], kRays));
  EXPECT_LE(difference.most, 50) << difference;
}

// Grey is what the bytes are rounded from: off by half a level in each channel, and by half in OpenCV's own.
TEST_P(RayOnScene, GreyIsThePictureBeforeItIsRounded) {
  for (const vision::CameraModel& camera : Cameras()) {
    RayRenderer renderer(model_.get(), camera, {});
    cv::Mat rounded;
    cv::cvtColor(renderer.Render(data_.get(), GetParam().X_NC), rounded, cv::COLOR_BGR2GRAY);
    const SceneState state{0, data_.get(), GetParam().X_NC};
    const cv::Mat grey = renderer.RenderGrey({&state, 1}, 0);
    rounded.convertTo(rounded, CV_32F);
    EXPECT_LE(cv::norm(rounded, grey, cv::NORM_INF), 1.01) << vision::NameOf(camera);
    EXPECT_GT(cv::norm(rounded, grey, cv::NORM_INF), 0) << vision::NameOf(camera);
  }
}

TEST_P(RayOnScene, SeesTheSurfacesThatAreThere) {
  for (const vision::CameraModel& camera : Cameras()) {
    const Surfaces seen = RayRenderer(model_.get(), camera, {}).Trace(data_.get(), GetParam().X_NC);
    const reference::SurfaceErrors errors =
        reference::ErrorsOf(seen, model_.get(), data_.get(), GetParam().X_NC, camera);
    EXPECT_LE(errors.other_geom, 2) << vision::NameOf(camera);  // pixels just on an edge
    EXPECT_LT(errors.depth, 1e-4) << vision::NameOf(camera);
    for (int v = 0; v < vision::HeightPx(camera); ++v) {
      for (int u = 0; u < vision::WidthPx(camera); ++u) {
        const int geom = seen.geom.at<int>(v, u);
        EXPECT_EQ(geom == -2, !vision::Ray(camera, {u, v}))
            << vision::NameOf(camera) << " at " << u << ", " << v;
        const float depth = seen.depth_m.at<float>(v, u);
        EXPECT_TRUE(geom >= 0 || (geom == -1 ? std::isinf(depth) : std::isnan(depth))) << depth;
      }
    }
  }
}

// Each of those that there are here.
std::vector<std::string> SetsHere() {
  std::vector<std::string> sets;
  for (const std::string_view set : InstructionSets()) {
    sets.emplace_back(set);
    if (set == InstructionSet()) return sets;
  }
  return {InstructionSet()};
}

// Makes what follows in a test go by a set, and then by the best again.
class By {
 public:
  explicit By(const std::string& set) { UseInstructionSet(set); }
  ~By() { hwy::DisableTargets(0); }
  By(const By&) = delete;
  By& operator=(const By&) = delete;
};

// To the last bit, but for the least set: it has no instruction that multiplies and adds at once.
TEST_P(RayOnScene, EveryInstructionSetDrawsTheSame) {
  for (const vision::CameraModel& camera : Cameras()) {
    const auto draw = [&] {
      return RayRenderer(model_.get(), camera, {}).Render(data_.get(), GetParam().X_NC);
    };
    const cv::Mat best = draw();
    for (const std::string& set : SetsHere()) {
      const By by(set);
      ASSERT_EQ(InstructionSet(), set);
      const ImageDifference difference = Compare(draw(), best);
      // A ray that just meets or just misses an edge is one of sixteen; elsewhere rounding does not show.
      EXPECT_LE(difference.above_1, 0.001) << vision::NameOf(camera) << " by " << set << ": " << difference;
      if (set == "ssse3") continue;
      EXPECT_EQ(difference.most, 0) << vision::NameOf(camera) << " by " << set << ": " << difference;
    }
  }
}

TEST(RayRenderer, ThereAreInstructionSetsToCompare) {
  EXPECT_TRUE(SetsHere().size() > 1 || !(hwy::SupportedTargets() & HWY_AVX2));
}

INSTANTIATE_TEST_SUITE_P(All, RayOnScene, ::testing::ValuesIn(Scenes()),
                         [](const auto& scene) { return scene.param.name; });

TEST(RayRenderer, ShowsNothingOutsideOfTheLensAndSomethingAllOverIt) {
  const ModelPtr model = CompileScene(R"(<mujoco><asset>
    <texture type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1" width="8" height="8"/></asset></mujoco>)");
  const DataPtr data = StateOf(model.get());
  for (const vision::CameraModel& camera : Cameras()) {
    const cv::Mat image = RayRenderer(model.get(), camera, {}).Render(data.get(), {});
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u)
        EXPECT_EQ(image.at<cv::Vec3b>(v, u), cv::Vec3b::all(vision::Ray(camera, {u, v}) ? 255 : 0))
            << vision::NameOf(camera) << " at " << u << ", " << v;
  }
}

std::string Refusal(const std::string& xml) {
  const ModelPtr model = CompileScene(xml);
  try {
    RayRenderer(model.get(), Cameras()[0], {});
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(RayRenderer, RefusesWhatItDoesNotDrawByName) {
  EXPECT_THAT(Refusal(R"(<mujoco>
  <asset><skin name="cape" vertex="0 0 0  1 0 0  0 1 0" face="0 1 2">
    <bone body="shoulders" bindpos="0 0 0" bindquat="1 0 0 0" vertid="0 1 2" vertweight="1 1 1"/></skin></asset>
  <worldbody><body name="shoulders"><geom size="0.1"/></body></worldbody>
</mujoco>)"),
              AllOf(HasSubstr("skin"), HasSubstr("'cape'")));
  EXPECT_THAT(Refusal(R"(<mujoco>
  <asset>
    <texture name="crate" type="cube" file="faces.png" gridsize="6 1" gridlayout="RLUDFB"/>
    <material name="wood" texture="crate"/>
    <mesh name="sail" vertex="0 0 0  1 0 0  0 1 0  0 0 1" texcoord="0 0  1 0  0 1  1 1" face="0 2 1  0 1 3  0 3 2  1 2 3"/>
  </asset>
  <worldbody><geom name="mizzen" type="mesh" mesh="sail" material="wood"/></worldbody>
</mujoco>)"),
              AllOf(HasSubstr("texture"), HasSubstr("'mizzen'")));
  EXPECT_THAT(Refusal(R"(<mujoco>
  <worldbody>
    <body><joint type="slide" axis="1 0 0"/><geom size="0.1"/><site name="slider" euler="0 90 0"/></body>
    <body pos="1 0 0"><joint axis="0 1 0"/><geom size="0.1"/><site name="crank" pos="0 0 0.2"/></body>
  </worldbody>
  <actuator><general name="piston" cranksite="crank" slidersite="slider" cranklength="1"/></actuator>
</mujoco>)"),
              AllOf(HasSubstr("slider-crank"), HasSubstr("'piston'")));
}

}  // namespace
}  // namespace kestrel::sim
