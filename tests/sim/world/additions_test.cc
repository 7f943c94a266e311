// SPDX-License-Identifier: Apache-2.0
#include "sim/world/additions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "geometry/tait_bryan.h"
#include "sim/camera/renderer.h"
#include "sim/world/scene.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

const vision::Pinhole kCamera{320, 240, 300, 300, 159.5, 119.5};
const cv::Vec3b kRed(0, 0, 255), kGreen(0, 255, 0), kBlue(255, 0, 0), kWhite(255, 255, 255);

// Red, green over blue, white.
cv::Mat Quarters(int side) {
  cv::Mat picture(side, side, CV_8UC3, cv::Scalar::all(255));
  picture(cv::Rect(0, 0, side / 2, side / 2)) = kRed;
  picture(cv::Rect(side / 2, 0, side / 2, side / 2)) = kGreen;
  picture(cv::Rect(0, side / 2, side / 2, side / 2)) = kBlue;
  return picture;
}

// A board of 2 x 2 m on the ground with the picture on it, seen by whoever looks along -z of the file. As OBJ:
const char* const kBoardObj = R"(mtllib board.mtl
v -1 0 0
v 1 0 0
v 1 2 0
v -1 2 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
usemtl board
f 1/1/1 2/2/1 3/3/1 4/4/1
)";
const char* const kBoardMtl = "newmtl board\nKd 1 1 1\nmap_Kd quarters.png\n";

// The same as glTF: of half the size, in a node that is twice as large within one that is a metre higher.
std::string BoardGlb(const std::string& png) {
  std::string bin;
  const auto append = [&](const auto& values) {
    bin.append(reinterpret_cast<const char*>(values), sizeof values);
  };
  const float positions[] = {-0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, 0.5, 0};
  const float normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  const float st[] = {0, 1, 1, 1, 1, 0, 0, 0};
  const std::uint16_t corners[] = {0, 1, 2, 0, 2, 3};
  append(positions), append(normals), append(st), append(corners);
  const std::size_t png_at = bin.size();
  bin += png;
  bin.resize((bin.size() + 3) / 4 * 4);
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"translation":[0,1,0],"children":[1]}},{{"scale":[2,2,2],"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3,"material":0}}]}}],
"materials":[{{"doubleSided":true,"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
"textures":[{{"source":0}}],"images":[{{"bufferView":4,"mimeType":"image/png"}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-0.5,-0.5,0],"max":[0.5,0.5,0]}},
{{"bufferView":1,"componentType":5126,"count":4,"type":"VEC3"}},{{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}},
{{"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":48}},
{{"buffer":0,"byteOffset":96,"byteLength":32}},{{"buffer":0,"byteOffset":128,"byteLength":12}},
{{"buffer":0,"byteOffset":{},"byteLength":{}}}],"buffers":[{{"byteLength":{}}}]}})",
      png_at, png.size(), bin.size());
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&number), 4);
  };
  return "glTF" + word(2) + word(12 + 8 + json.size() + 8 + bin.size()) + word(json.size()) + "JSON" + json +
         word(bin.size()) + std::string("BIN\0", 4) + bin;
}

class Additions : public ::testing::Test {
 protected:
  Additions() : folder_(fs::temp_directory_path() / fmt::format("kestrel_additions_{}", getpid())) {
    fs::create_directories(folder_);
    p_.world = Write("world.xml",
                     R"(<mujoco><visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
      <worldbody><geom name="ground" type="plane" size="200 100 1" rgba="0.2 0.2 0.2 1"/></worldbody></mujoco>)");
    p_.vehicle =
        Write("vehicle.xml", R"(<mujocoinclude><body name="vehicle" pos="-80 0 1"><freejoint name="vehicle"/>
      <geom type="box" size="0.1 0.1 0.1"/></body></mujocoinclude>)");
    cv::imwrite(folder_ / "quarters.png", Quarters(64));
    Write("board.obj", kBoardObj);
    Write("board.mtl", kBoardMtl);
    std::ifstream png(folder_ / "quarters.png", std::ios::binary);
    Write("board.glb", BoardGlb({std::istreambuf_iterator<char>(png), {}}));
  }
  ~Additions() override { fs::remove_all(folder_); }

  std::string Write(const char* name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  std::string Path(const char* name) const { return folder_ / name; }

  cv::Mat Seen(const Pose& X_NC, const char* backend = "ray") const {
    const ModelPtr model = MakeModel(p_);
    return Renderer(model.get(), kCamera, {.backend = backend}).Render(StateOf(model.get()).get(), X_NC);
  }
  std::string Refusal() const {
    try {
      MakeModel(p_);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "accepted";
  }

  fs::path folder_;
  SceneParameters p_;
};

// What is seen where a place projects to.
cv::Vec3b At(const cv::Mat& image, const Pose& X_NC, const Eigen::Vector3d& p_N) {
  const auto uv = kCamera.Project(X_NC.Inverse() * p_N);
  if (!uv) return {1, 2, 3};
  return image.at<cv::Vec3b>(static_cast<int>(std::lround(uv->y())), static_cast<int>(std::lround(uv->x())));
}

// The board's z looks along its yaw, and x to the left of that: its picture's right is to the west of who is in the
// north.
TEST_F(Additions, AMeshStandsWhereItIsPutWithItsPicture) {
  for (const char* const file : {"board.obj", "board.glb"}) {
    for (const double scale : {1.0, 0.5}) {
      for (const double yaw_deg : {0.0, 30.0}) {
        p_.additions.meshes = {
            {.file = Path(file), .position_m = {3, 2}, .height_m = 0.5, .yaw_deg = yaw_deg, .scale = scale}};
        const Eigen::Vector3d foot(3, 2, -0.5);
        const Eigen::Matrix3d R = HeadingRotation(Radians(yaw_deg)).toRotationMatrix();
        const Pose X_NC = LookingFrom(foot + R * Eigen::Vector3d(6, 0, -1), Radians(yaw_deg + 180), 0);
        const cv::Mat image = Seen(X_NC);
        // right: as seen by the camera, which is to the west at yaw 0.
        const auto at = [&](double right, double up) {
          return At(image, X_NC, foot + R * (scale * Eigen::Vector3d(0, -right, -up)));
        };
        EXPECT_EQ(at(-0.5, 1.5), kRed) << file << " " << scale << " " << yaw_deg;
        EXPECT_EQ(at(0.5, 1.5), kGreen) << file;
        EXPECT_EQ(at(-0.5, 0.5), kBlue) << file;
        EXPECT_EQ(at(0.5, 0.5), kWhite) << file;
        for (const auto& [right, up] : {std::pair(1.05, 1.0), {-1.05, 1.0}, {0.5, 2.05}, {0.5, -0.05}}) {
          const cv::Vec3b beside = at(right, up);
          EXPECT_LT(std::max({beside[0], beside[1], beside[2]}), 60) << file << " " << right << " " << up;
        }
      }
    }
  }
}

TEST_F(Additions, GlbAndObjOfTheSameGiveTheSamePicture) {
  const Pose X_NC = LookingFrom({5, 1, -2}, Radians(190), Radians(-8));
  p_.additions.meshes = {{.file = Path("board.obj")}};
  const cv::Mat obj = Seen(X_NC);
  p_.additions.meshes = {{.file = Path("board.glb")}};
  EXPECT_LE(cv::norm(obj, Seen(X_NC), cv::NORM_INF), 1);
}

TEST_F(Additions, OpenGlDrawsThemToo) {
  const Pose X_NC = LookingFrom({6, 0, -1}, Radians(180), 0);
  p_.additions.meshes = {{.file = Path("board.glb")}};
  p_.additions.ground_photo =
      GroundPhotoParameters{.file = Path("quarters.png"), .size_m = {8, 8}, .position_m = {-4, 0}};
  const cv::Mat ray = Seen(X_NC), opengl = Seen(X_NC, "osmesa");
  cv::Mat differs = cv::abs(ray - opengl), grey;
  cv::cvtColor(differs, grey, cv::COLOR_BGR2GRAY);
  EXPECT_LT(cv::countNonZero(grey > 20), 0.01 * grey.rows * grey.cols);
}

TEST_F(Additions, ZMayBeUp) {
  // The same board, told that z is up, lies on its back: its picture is seen from above, its right to the east.
  p_.additions.meshes = {{.file = Path("board.obj"), .up = "z", .height_m = 0.1}};
  const Pose X_NC = LookingFrom({1, 0, -5}, 0, Radians(-90));
  const cv::Mat image = Seen(X_NC);
  EXPECT_EQ(At(image, X_NC, {1.5, -0.5, 0}), kRed);
  EXPECT_EQ(At(image, X_NC, {1.5, 0.5, 0}), kGreen);
  EXPECT_EQ(At(image, X_NC, {0.5, -0.5, 0}), kBlue);
  EXPECT_EQ(At(image, X_NC, {0.5, 0.5, 0}), kWhite);
}

// The vehicle is a box that falls from 3 m onto a cube of 1 m, or beside it.
TEST_F(Additions, StandInTheWayAsTheyAreTold) {
  const std::string cube = Write("cube.obj", R"(v -0.5 0 -0.5
v 0.5 0 -0.5
v 0.5 0 0.5
v -0.5 0 0.5
v -0.5 1 -0.5
v 0.5 1 -0.5
v 0.5 1 0.5
v -0.5 1 0.5
f 1 2 3 4
f 8 7 6 5
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
)");
  p_.vehicle =
      Write("vehicle.xml", R"(<mujocoinclude><body name="vehicle" pos="0 0 1.5"><freejoint name="vehicle"/>
      <geom type="box" size="0.1 0.1 0.1"/></body></mujocoinclude>)");
  for (const auto& [collides, height_m] : {std::pair("hull", 1.1), {"box", 1.1}, {"none", 0.1}}) {
    p_.additions.meshes = {{.file = cube, .collides = collides}};
    const ModelPtr model = MakeModel(p_);
    const DataPtr data = MakeData(model.get());
    for (int i = 0; i < 1000; ++i) mj_step(model.get(), data.get());
    EXPECT_NEAR(data->qpos[2], height_m, 0.02) << collides;
  }
  p_.additions.meshes = {{.file = Path("board.obj"), .collides = "hull"}};  // a flat one has a hull as well
  EXPECT_EQ(Refusal(), "accepted");
}

TEST_F(Additions, APhotoLiesOnTheGroundAtItsSize) {
  cv::imwrite(folder_ / "photo.png", Quarters(200)(cv::Rect(0, 0, 200, 200)));
  p_.additions.ground_photo = GroundPhotoParameters{
      .file = Path("photo.png"), .size_m = {8, 12}, .position_m = {10, -20}, .yaw_deg = 30};
  const Pose X_NC = LookingFrom({10, -20, -20}, Radians(10), Radians(-90));
  const cv::Mat image = Seen(X_NC);
  const auto at = [&](double up, double right) {
    return At(image, X_NC,
              Eigen::Vector3d(10, -20, 0) + HeadingRotation(Radians(30)) * Eigen::Vector3d(up, right, 0));
  };
  for (const double share : {0.1, 0.5, 0.95}) {
    EXPECT_EQ(at(share * 4, -share * 6), kRed) << share;
    EXPECT_EQ(at(share * 4, share * 6), kGreen) << share;
    EXPECT_EQ(at(-share * 4, -share * 6), kBlue) << share;
    EXPECT_EQ(at(-share * 4, share * 6), kWhite) << share;
  }
  EXPECT_LT(at(4.1, 0)[0], 60);
  EXPECT_LT(at(0, 6.1)[0], 60);
}

// A photo of 5000 pixels is two tiles wide: stripes of 4 pixels are told apart, over the seam as well.
TEST_F(Additions, ALargePhotoKeepsItsResolution) {
  cv::Mat stripes(40, 5000, CV_8UC1);
  for (int x = 0; x < 5000; ++x) stripes.col(x) = x / 4 % 2 == 0 ? 0 : 255;
  cv::imwrite(folder_ / "stripes.png", stripes);
  p_.additions.ground_photo = GroundPhotoParameters{.file = Path("stripes.png"), .size_m = {0.8, 100}};
  const ModelPtr model = MakeModel(p_);
  for (const double east : {0.0, 10.0, -49.0}) {
    const Pose X_NC = LookingFrom({0, east, -1}, 0, Radians(-90));
    const cv::Mat image = Seen(X_NC);
    int right = 0, all = 0;
    for (int x = 2; x < 5000; x += 4) {  // the middle of each stripe
      const double at_m = x * 0.02 - 50;
      if (std::abs(at_m - east) > 0.5) continue;
      ++all;
      right += std::abs(At(image, X_NC, {0, at_m, 0})[0] - (x / 4 % 2 == 0 ? 0 : 255)) < 60;
    }
    EXPECT_GT(all, 8);
    EXPECT_EQ(right, all) << east;
  }
}

// From 40 m the edge of the world's plane lies 11 degrees below the horizontal, of an endless one 0.05.
TEST_F(Additions, TheGroundOfAModelMayReachToTheHorizon) {
  const Pose X_NC = LookingFrom({0, 0, -40}, 0, 0);
  const auto is_ground = [&](double down_deg, double right_deg) {
    const cv::Mat image = Seen(X_NC);
    return At(image, X_NC, {1, std::tan(Radians(right_deg)), std::tan(Radians(down_deg)) - 40})[0] > 10;
  };
  EXPECT_FALSE(is_ground(1, 0));
  p_.additions.endless = true;
  for (const double right_deg : {-25, 0, 25}) {
    EXPECT_TRUE(is_ground(0.5, right_deg)) << right_deg;
    EXPECT_FALSE(is_ground(-0.5, right_deg)) << right_deg;
  }
}

// Of its contrast with the sky above the horizon 2 % are left at 20 km (Koschmieder): exp(-3.912 distance / 20 km).
TEST_F(Additions, GroundToTheHorizonFadesIntoTheSky) {
  p_.additions.endless = true;
  const Pose X_NC = LookingFrom({0, 0, -100}, 0, 0);
  const cv::Mat image = Seen(X_NC);
  const auto blue = [&](double down_deg) {
    return At(image, X_NC, {1, 0, std::tan(Radians(down_deg)) - 100})[0];
  };
  const double sky = blue(-0.3), ground = blue(20);
  for (const double down_deg : {0.6, 1.0, 2.0, 4.0}) {
    const double distance_m = 100 / std::sin(Radians(down_deg)), left = std::exp(-3.912 * distance_m / 20e3);
    EXPECT_NEAR(blue(down_deg), sky + left * (ground - sky), 4) << down_deg;
  }
  EXPECT_GT(std::abs(ground - sky), 40);
}

TEST_F(Additions, AreRefusedWithTheirNameAndARemedy) {
  const auto mesh = [&](const std::string& file) {
    p_.additions.meshes = {{.file = file}};
    return Refusal();
  };
  EXPECT_THAT(mesh(Path("none.glb")), AllOf(HasSubstr("none.glb"), HasSubstr("there is no file")));
  EXPECT_THAT(mesh(Write("text.glb", "not a mesh")),
              AllOf(HasSubstr("text.glb"), HasSubstr("valid: OBJ or glTF")));
  EXPECT_THAT(mesh(Write("points.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2\nl 2 3\n")),
              AllOf(HasSubstr("points.obj"), HasSubstr("no triangle"), HasSubstr("valid:")));
  fs::remove(folder_ / "quarters.png");
  EXPECT_THAT(mesh(Path("board.obj")),
              AllOf(HasSubstr("board.obj"), HasSubstr("quarters.png"), HasSubstr("beside it")));
  Write("quarters.png", "no picture");
  EXPECT_THAT(mesh(Path("board.obj")), AllOf(HasSubstr("board.obj"), HasSubstr("is not an image")));

  p_.additions.meshes.clear();
  const auto photo = [&](const std::string& file, const Eigen::Vector2d& size_m) {
    p_.additions.ground_photo = GroundPhotoParameters{.file = file, .size_m = size_m};
    return Refusal();
  };
  EXPECT_THAT(photo(Path("quarters.png"), {1, 1}),
              AllOf(HasSubstr("ground photo"), HasSubstr("quarters.png")));
  cv::imwrite(folder_ / "wide.png", cv::Mat(100, 200, CV_8UC3, cv::Scalar::all(9)));
  EXPECT_THAT(photo(Path("wide.png"), {20, 10}), AllOf(HasSubstr("wide.png"), HasSubstr("[10, 20]")));
  EXPECT_EQ(photo(Path("wide.png"), {10, 20}), "accepted");
}

}  // namespace
}  // namespace kestrel::sim
