// SPDX-License-Identifier: Apache-2.0
#include "sim/world/scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "geometry/tait_bryan.h"
#include "sim/camera/renderer.h"

namespace kestrel::sim {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path kModels = KESTREL_SOURCE_DIR "/models";
const vision::Pinhole kCamera{640, 480, 810.81, 810.81, 319.5, 239.5};

// Straight down, the top of the image towards a heading.
Pose LookingDown(double yaw, const Eigen::Vector3d& p_NC) {
  return {HeadingRotation(yaw + std::numbers::pi / 2), p_NC};
}

class Scene : public ::testing::Test {
 protected:
  Scene() : folder_(std::filesystem::temp_directory_path() / fmt::format("kestrel_scene_{}", getpid())) {
    std::filesystem::create_directories(folder_);
    p_.world = Write("world.xml",
                     R"(<mujoco><visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
      <worldbody><geom name="ground" type="plane" size="20 10 1" rgba="0.2 0.2 0.2 1"/></worldbody></mujoco>)");
    p_.vehicle =
        Write("vehicle.xml", R"(<mujocoinclude><body name="vehicle" pos="-8 0 1"><freejoint name="vehicle"/>
      <geom type="box" size="0.1 0.1 0.1"/></body></mujocoinclude>)");
    // A picture with red, green over blue, white.
    cv::Mat picture(64, 48, CV_8UC3, cv::Scalar(255, 255, 255));
    picture(cv::Rect(0, 0, 24, 32)) = cv::Scalar(0, 0, 255);
    picture(cv::Rect(24, 0, 24, 32)) = cv::Scalar(0, 255, 0);
    picture(cv::Rect(0, 32, 24, 32)) = cv::Scalar(255, 0, 0);
    p_.pad_texture = folder_ / "picture.png";
    cv::imwrite(p_.pad_texture, picture);
  }
  ~Scene() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const char* name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  std::string Refusal() const {
    try {
      MakeModel(p_);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "accepted";
  }

  std::filesystem::path folder_;
  SceneParameters p_;
};

DataPtr Computed(const mjModel* model) {
  DataPtr data = MakeData(model);
  mj_forward(model, data.get());
  return data;
}

TEST_F(Scene, PadLiesWhereItIsPutOneCentimetreAboveTheGround) {
  p_.pad_position_m = {3, -2};
  p_.pad_yaw_deg = 30;
  const ModelPtr model = MakeModel(p_);
  const Pose X_NT = PadPose(model.get(), Computed(model.get()).get());
  EXPECT_LT((X_NT.p - Eigen::Vector3d(3, -2, -0.01)).norm(), 1e-12);
  // Its x is turned from north to the east by the yaw, its z is down.
  EXPECT_LT((X_NT.R * Eigen::Vector3d::UnitX() - Eigen::Vector3d(std::sqrt(3) / 2, 0.5, 0)).norm(), 1e-12);
  EXPECT_LT((X_NT.R * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST_F(Scene, ThePadIsPaintedAsMujocoReadsItsFile) {
  for (const bool grey : {false, true}) {
    cv::Mat picture(64, 128, grey ? CV_8UC1 : CV_8UC3);
    cv::RNG(2).fill(picture, cv::RNG::UNIFORM, 0, 256);
    cv::imwrite(p_.pad_texture, picture);
    p_.pad_picture = cv::Mat();
    const ModelPtr read = MakeModel(p_);
    p_.pad_picture = picture;
    const ModelPtr painted = MakeModel(p_);
    ASSERT_EQ(painted->ntexdata, read->ntexdata);
    EXPECT_TRUE(std::equal(read->tex_rgb, read->tex_rgb + read->ntexdata, painted->tex_rgb)) << grey;
  }
}

TEST_F(Scene, APadHangsOnTheWallThatItsTopFacedWithItsFaceBeforeIt) {
  p_.pad_position_m = {3, -2};
  p_.pad_yaw_deg = 30;
  p_.pad_height_m = 1.5, p_.pad_tilt_deg = 90;
  const ModelPtr model = MakeModel(p_);
  const Pose X_NT = PadPose(model.get(), Computed(model.get()).get());
  const Eigen::Vector3d into_wall(std::sqrt(3) / 2, 0.5, 0);
  EXPECT_LT((X_NT.p - (Eigen::Vector3d(3, -2, -1.5) - 0.01 * into_wall)).norm(), 1e-12);
  EXPECT_LT((X_NT.R * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);  // its top is up
  EXPECT_LT((X_NT.R * Eigen::Vector3d::UnitZ() - into_wall).norm(), 1e-12);
  EXPECT_LT((X_NT.R * Eigen::Vector3d::UnitY() - Eigen::Vector3d(-0.5, std::sqrt(3) / 2, 0)).norm(), 1e-12);
}

TEST_F(Scene, APadOnUnevenGroundLeansWithNoCornerInIt) {
  p_.pad_position_m = {3, -2};
  p_.pad_yaw_deg = 30;
  p_.pad_lean_deg = {2, -3};
  const ModelPtr model = MakeModel(p_);
  const Pose X_NT = PadPose(model.get(), Computed(model.get()).get());
  EXPECT_LT((X_NT.p - Eigen::Vector3d(3, -2, 0)).head<2>().norm(), 0.001);
  // Of small angles each is that of its axis.
  EXPECT_NEAR(Degrees(std::acos((X_NT.R * Eigen::Vector3d::UnitZ()).z())), std::hypot(2, 3), 0.01);
  double lowest = -1;
  for (const double along : {-0.5, 0.5})
    for (const double across : {-0.5, 0.5})
      lowest = std::max(
          lowest, (X_NT * Eigen::Vector3d(along * p_.pad.size_m.x(), across * p_.pad.size_m.y(), 0.01)).z());
  EXPECT_NEAR(lowest, 0, 1e-4);
}

TEST_F(Scene, PictureCoversThePadOnceWithItsTopAtPlusX) {
  p_.pad_position_m = {3, -2};
  p_.pad_yaw_deg = 30;
  const ModelPtr model = MakeModel(p_);
  const DataPtr data = Computed(model.get());
  const Pose X_NC = LookingDown(-0.4, {2.9, -1.9, -3.5});
  const Pose X_CN = X_NC.Inverse();
  const cv::Mat image = Renderer(model.get(), kCamera, {}).Render(data.get(), X_NC);
  const auto colour = [&](double along, double across) {
    const Eigen::Vector3d p_TQ(along * p_.pad.size_m.x(), across * p_.pad.size_m.y(), 0);
    const Eigen::Vector2d uv = *kCamera.Project(X_CN * (PadPose(model.get(), data.get()) * p_TQ));
    const cv::Vec3b bgr =
        image.at<cv::Vec3b>(static_cast<int>(std::lround(uv.y())), static_cast<int>(std::lround(uv.x())));
    std::string name;
    for (int i = 0; i < 3; ++i)
      if (bgr[i] > 128) name += "bgr"[i];
    return name;
  };
  for (const double part : {0.02, 0.1, 0.25, 0.4, 0.48}) {
    EXPECT_EQ(colour(part, -part), "r") << part;
    EXPECT_EQ(colour(part, part), "g") << part;
    EXPECT_EQ(colour(-part, -part), "b") << part;
    EXPECT_EQ(colour(-part, part), "bgr") << part;
  }
  for (const double beyond : {-0.515, 0.515}) {
    EXPECT_EQ(colour(beyond, 0.1), "");
    EXPECT_EQ(colour(0.1, beyond), "");
  }
}

TEST_F(Scene, OccluderCoversItsShareFromThePlusXEnd) {
  p_.pad_yaw_deg = -70;
  p_.occluder = true;
  const ModelPtr model = MakeModel(p_);
  const DataPtr data = Computed(model.get());
  const Pose X_NC = LookingDown(0, {0, 0, -2.5});
  Renderer renderer(model.get(), kCamera, {});
  const cv::Mat bare = renderer.Render(data.get(), X_NC);
  PlaceOccluder(model.get(), data.get(), PadPose(model.get(), data.get()), 0.4);
  mj_kinematics(model.get(), data.get());
  const cv::Mat covered = renderer.Render(data.get(), X_NC);
  for (const double along : {-0.48, -0.2, 0.07, 0.13, 0.3, 0.48}) {
    const Eigen::Vector3d p_TQ(along * p_.pad.size_m.x(), 0.3, 0);
    const Eigen::Vector2d uv = *kCamera.Project(X_NC.Inverse() * (PadPose(model.get(), data.get()) * p_TQ));
    const cv::Point at(static_cast<int>(std::lround(uv.x())), static_cast<int>(std::lround(uv.y())));
    if (along > 0.1)
      EXPECT_LT(cv::norm(covered.at<cv::Vec3b>(at)), 80) << along;
    else
      EXPECT_EQ(covered.at<cv::Vec3b>(at), bare.at<cv::Vec3b>(at)) << along;
  }
  PlaceOccluder(model.get(), data.get(), PadPose(model.get(), data.get()), 0);
  mj_kinematics(model.get(), data.get());
  EXPECT_EQ(cv::norm(renderer.Render(data.get(), X_NC), bare, cv::NORM_INF), 0);
  EXPECT_THROW(PlaceOccluder(model.get(), data.get(), PadPose(model.get(), data.get()), 1.1),
               std::runtime_error);
}

TEST_F(Scene, StepsAtTwoMillisecondsUnderStandardGravity) {
  const ModelPtr model = MakeModel(p_);
  const DataPtr data = MakeData(model.get());
  for (int i = 0; i < 100; ++i) mj_step(model.get(), data.get());
  EXPECT_NEAR(data->time, 0.2, 1e-12);
  EXPECT_NEAR(data->qvel[2], -9.80665 * 0.2, 1e-9);
}

TEST_F(Scene, FilesInTheWorldAreFoundBesideIt) {
  p_.world = Write("textured.xml", R"(<mujoco><asset><texture name="t" type="2d" file="picture.png"/></asset>
    <worldbody><geom name="ground" type="plane" size="20 20 1"/></worldbody></mujoco>)");
  EXPECT_EQ(Refusal(), "accepted");
  p_.world = std::filesystem::relative(p_.world);
  EXPECT_EQ(Refusal(), "accepted");
}

TEST_F(Scene, RefusalsNameTheFileAtFault) {
  const SceneParameters good = p_;
  const auto one_line = [](const std::string& file) { return AllOf(HasSubstr(file), Not(HasSubstr("\n"))); };

  p_.world = folder_ / "none.xml";
  EXPECT_THAT(Refusal(), one_line("none.xml"));
  p_.world = Write("broken.xml", "<mujoco>\n<worldbody></mujoco>");
  EXPECT_THAT(Refusal(), AllOf(one_line("broken.xml"), HasSubstr("tags mismatch in line 2")));
  p_.world = Write("misspelt.xml", "<mujoco><worldbody><geom sise='1'/></worldbody></mujoco>");
  EXPECT_THAT(Refusal(), AllOf(one_line("misspelt.xml"), HasSubstr("sise"), Not(HasSubstr("line"))));
  p_.world = Write("airless.xml",
                   "<mujoco><worldbody><geom name='ground' type='box' size='9 9 1'/></worldbody></mujoco>");
  EXPECT_THAT(Refusal(), AllOf(one_line("airless.xml"), HasSubstr("no plane named \"ground\"")));
  p_.world = Write(
      "raised.xml",
      "<mujoco><worldbody><geom name='ground' type='plane' pos='0 0 1' size='9 9 1'/></worldbody></mujoco>");
  EXPECT_THAT(Refusal(), AllOf(one_line("raised.xml"), HasSubstr("level")));

  p_.world = Write("bare.xml", "<mujoco><asset><texture type='2d' file='grass.png'/></asset></mujoco>");
  EXPECT_THAT(Refusal(), AllOf(one_line("bare.xml"), HasSubstr("grass.png")));

  p_ = good;
  p_.pad_texture = folder_ / "lost.png";
  EXPECT_THAT(Refusal(), one_line("lost.png"));
  Write("bad.png", "not a picture");
  p_.pad_texture = folder_ / "bad.png";
  EXPECT_THAT(Refusal(), one_line("bad.png"));

  p_ = good;
  p_.vehicle = Write("meshed.xml", R"(<mujocoinclude><asset><mesh name="m" file="lost.stl"/></asset>
    <body name="vehicle"><geom type="mesh" mesh="m"/></body></mujocoinclude>)");
  EXPECT_THAT(Refusal(), AllOf(one_line("meshed.xml"), HasSubstr("lost.stl")));
  p_.vehicle = Write("nobody.xml", "<mujocoinclude><body name='car'/></mujocoinclude>");
  EXPECT_THAT(Refusal(), AllOf(one_line("nobody.xml"), HasSubstr("\"vehicle\"")));
}

TEST_F(Scene, RefusalOfATextureNamesItsFile) {
  p_.world = Write("world.xml", R"(<mujoco><asset><texture name="t" type="cube" file="picture.png"/></asset>
    <worldbody><geom name="ground" type="plane" size="9 9 1"/></worldbody></mujoco>)");
  EXPECT_THAT(Refusal(),
              AllOf(HasSubstr("'" + (folder_ / "picture.png").string() + "'"), Not(HasSubstr("decoded"))));
}

TEST_F(Scene, RefusesAPadThatReachesBeyondTheGroundWithTheNumbers) {
  p_.pad_position_m = {19.3, 0};
  EXPECT_EQ(Refusal(), "accepted");
  p_.pad_position_m = {0, -9.6};  // the ground ends at 10 m to either side
  EXPECT_THAT(Refusal(),
              AllOf(HasSubstr("1.19 m x 0.91 m"), HasSubstr("east -9.6 m"), HasSubstr("40 m x 20 m")));
  p_.pad_position_m = {0, -9.5};
  EXPECT_EQ(Refusal(), "accepted");
  p_.pad_yaw_deg = 90;
  EXPECT_THAT(Refusal(), HasSubstr("beyond the ground"));
}

TEST_F(Scene, WithoutAnOccluderPlacingItIsRefused) {
  const ModelPtr model = MakeModel(p_);
  EXPECT_THROW(PlaceOccluder(model.get(), MakeData(model.get()).get(), {}, 0.3), std::runtime_error);
}

TEST_F(Scene, HelipadOnTheAirfieldHasCornersFromEveryHeight) {
  p_.world = kModels / "worlds/airfield/airfield.xml";
  p_.pad_texture = kModels / "pads/helipad/helipad.png";
  const ModelPtr model = MakeModel(p_);
  const DataPtr data = Computed(model.get());
  const Pose X_NT = PadPose(model.get(), data.get());
  Renderer renderer(model.get(), kCamera, {});
  struct Expectation {
    double height_m;
    std::size_t corners;
  };
  for (const auto& [height_m, corners] :
       {Expectation{0.1, 40}, {0.3, 60}, {1, 200}, {4, 100}, {10, 40}, {15, 25}}) {
    const Pose X_NC = LookingDown(0, {0.02, 0.03, -0.01 - height_m});
    cv::Mat grey, pad(kCamera.height_px, kCamera.width_px, CV_8UC1, cv::Scalar(0));
    cv::cvtColor(renderer.Render(data.get(), X_NC), grey, cv::COLOR_BGR2GRAY);
    std::vector<cv::Point> outline;
    for (const auto& [x, y] : {std::pair{0.595, 0.455}, {0.595, -0.455}, {-0.595, -0.455}, {-0.595, 0.455}}) {
      const Eigen::Vector2d uv = *kCamera.Project(X_NC.Inverse() * (X_NT * Eigen::Vector3d(x, y, 0)));
      outline.emplace_back(static_cast<int>(uv.x()), static_cast<int>(uv.y()));
    }
    cv::fillConvexPoly(pad, outline, 255);
    std::vector<cv::Point2f> found;
    cv::goodFeaturesToTrack(grey, found, 2000, 0.01, 5, pad);
    EXPECT_GE(found.size(), corners) << "from " << height_m << " m";
  }
}

}  // namespace
}  // namespace kestrel::sim
