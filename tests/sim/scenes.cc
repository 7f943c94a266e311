// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/scenes.h"

#include <cmath>
#include <cstring>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

// Slow waves and a bright corner: smooth enough to be compared where it is filtered in another way.
cv::Mat RenderedFrame() {
  cv::Mat image(32, 48, CV_8UC3);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const double s = (u + 0.5) / image.cols, t = (v + 0.5) / image.rows;
      const double corner = std::exp(-20 * ((s - 0.2) * (s - 0.2) + (t - 0.3) * (t - 0.3)));
      const double wave = 0.5 + 0.5 * std::sin(2 * M_PI * (s + t));
      image.at<cv::Vec3b>(v, u) =
          cv::Vec3b(cv::saturate_cast<uchar>(60 + 120 * wave), cv::saturate_cast<uchar>(60 + 190 * corner),
                    cv::saturate_cast<uchar>(230 - 150 * corner));
    }
  return image;
}

cv::Mat Faces() {
  constexpr int kSide = 32;
  const std::vector<cv::Vec3d> base{{200, 80, 60},  {60, 200, 80},  {80, 60, 200},
                                    {60, 190, 190}, {190, 60, 190}, {190, 190, 60}};
  cv::Mat image(6 * kSide, kSide, CV_8UC3);
  for (int f = 0; f < 6; ++f)
    for (int v = 0; v < kSide; ++v)
      for (int u = 0; u < kSide; ++u) {
        const double s = (u + 0.5) / kSide, t = (v + 0.5) / kSide;
        const cv::Vec3d c = base[f] * (0.5 + 0.3 * s + 0.45 * t * t);
        image.at<cv::Vec3b>(f * kSide + v, u) = cv::Vec3b(
            cv::saturate_cast<uchar>(c[0]), cv::saturate_cast<uchar>(c[1]), cv::saturate_cast<uchar>(c[2]));
      }
  return image;
}

cv::Mat Relief() {
  cv::Mat image(5, 6, CV_8UC1);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image.at<uchar>(v, u) = cv::saturate_cast<uchar>(
          255 * std::exp(-0.3 * ((u - 1.5) * (u - 1.5) + (v - 2.8) * (v - 2.8))) + 12 * u);
  return image;
}

void AddFile(mjVFS* files, const char* name, const std::vector<uchar>& bytes) {
  mj_makeEmptyFileVFS(files, name, static_cast<int>(bytes.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files, name)], bytes.data(), bytes.size());
}

std::vector<uchar> Png(const cv::Mat& image) {
  std::vector<uchar> bytes;
  cv::imencode(".png", image, bytes);
  return bytes;
}

// Assets that all scenes have. Round things are fine enough in OpenGL that light at the vertices is light
// everywhere, and that they are round. White light shows pictures as they are.
std::string World(const std::string& visual, const std::string& assets, const std::string& world) {
  return R"(<mujoco>
  <statistic center="0 0 0" extent="20"/>
  <visual>
    <quality numslices="160" numstacks="160" numquads="32" shadowsize="0"/>)" +
         visual + R"(
  </visual>
  <asset>
    <texture name="picture" type="2d" file="picture.png"/>
    <texture name="faces" type="cube" file="faces.png" gridsize="6 1" gridlayout="RLUDFB"/>
    <material name="picture" texture="picture" specular="0"/>
    <material name="picture_metric" texture="picture" texuniform="true" texrepeat="1.3 0.9" specular="0"/>
    <material name="picture_often" texture="picture" texrepeat="1.6 1.2" specular="0"/>
    <material name="faces" texture="faces" specular="0"/>
    <material name="faces_metric" texture="faces" texuniform="true" specular="0"/>)" +
         assets + R"(
  </asset>
  <worldbody>)" +
         world + R"(
  </worldbody>
</mujoco>)";
}

constexpr const char* kWhite = R"(<headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/>)";
constexpr const char* kDim = R"(<headlight ambient="0.25 0.25 0.25" diffuse="0 0 0" specular="0 0 0"/>)";
const std::string kSun = R"(
    <light directional="true" dir="0.5 0.35 -0.8" ambient="0.1 0.1 0.12" diffuse="0.6 0.6 0.55" specular="0 0 0"/>)";
const std::string kSky = R"(
    <texture name="sky" type="skybox" file="faces.png" gridsize="6 1" gridlayout="RLUDFB"/>)";
const std::string kHaze = R"(<map haze="0.3"/><rgba haze="0.9 0.8 0.3 1"/>)";

// A wedge, a solid with a map of its own, and a block with a bowl in its top.
const std::string kMeshes = R"(
    <mesh name="wedge" vertex="-1 -0.6 -0.5  1 -0.6 -0.5  1 0.6 -0.5  -1 0.6 -0.5  0.2 0 0.9  -0.8 0.1 0.7"
      face="0 2 1  0 3 2  0 1 4  1 2 4  2 3 5  2 5 4  3 0 5  0 4 5"/>
    <mesh name="mapped" vertex="-1 -1 0  1 -1 0.2  1 1 0  -1 1 0.4  0 0 -0.8"
      texcoord="0 0  1 0  1 1  0 1  0.5 0.5"
      face="0 1 2  0 2 3  1 0 4  2 1 4  3 2 4  0 3 4"/>
    <mesh name="bowl" vertex="-1 -1 0  1 -1 0  1 1 0  -1 1 0  0 0 -0.7  -1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1"
      face="0 4 1  1 4 2  2 4 3  3 4 0  5 7 6  5 8 7  0 1 6  0 6 5  1 2 7  1 7 6  2 3 8  2 8 7  3 0 5  3 5 8"/>)";
// Facets that have one point of the texture each, and all one normal, as a landscape's: two upright ones, and two
// before them that lie no farther from the plane through the camera that is square to the normal.
const std::string kFacets = R"(
    <mesh name="facets"
      vertex="4.9 -1.6 -1.95  4.9 1.6 -1.95  4.9 1.6 -1.05  4.9 -1.6 -1.95  4.9 1.6 -1.05  4.9 -1.6 -1.05
              3.4 -0.5 -1.3  3.4 0.1 -1.3  3.4 -0.2 -1.05   3.4 0.2 -1.3  3.4 0.6 -1.3  3.4 0.3 -1.08"
      normal="0 0 1  0 0 1  0 0 1  0 0 1  0 0 1  0 0 1  0 0 1  0 0 1  0 0 1  0 0 1  0 0 1  0 0 1"
      texcoord="0.2 0.3  0.2 0.3  0.2 0.3  0.25 0.4  0.25 0.4  0.25 0.4
                0.7 0.6  0.7 0.6  0.7 0.6  0.9 0.2  0.9 0.2  0.9 0.2"
      face="0 2 1  3 5 4  6 8 7  9 11 10"/>)";
const std::string kHill = R"(
    <hfield name="hill" file="relief.png" size="3 2 1.5 0.4"/>)";

// Shapes in front of a camera at the origin that looks north, turned to show tops and sides.
std::string Shapes(const std::string& material, const std::string& other) {
  const std::string a = " material='" + material + "'/>", b = " material='" + other + "'/>";
  return "<geom type='box' pos='6 2.6 1.5' size='0.7 0.5 0.6' euler='20 25 40'" + a +
         "<geom type='sphere' pos='6 0.9 1.5' size='0.7' euler='30 40 70'" + a +
         "<geom type='ellipsoid' pos='6 -0.9 1.5' size='0.5 0.8 0.65' euler='-30 20 10'" + a +
         "<geom type='cylinder' pos='6 -2.6 1.5' size='0.5 0.6' euler='35 -20 0'" + a +
         "<geom type='capsule' pos='6 2.6 -0.2' size='0.35 0.4' euler='50 20 0'" + a +
         "<geom type='capsule' pos='6 0.9 -0.2' size='0.35 0.4' euler='-130 20 0'" + b +
         "<geom type='box' pos='6 -0.9 -0.2' size='0.5 0.6 0.4' euler='200 15 -40'" + b +
         "<geom type='cylinder' pos='6 -2.6 -0.2' size='0.6 0.5' euler='150 -20 0'" + b +
         "<geom type='ellipsoid' pos='6 2 -1.8' size='0.7 0.5 0.6' euler='150 30 20'" + b +
         "<geom type='sphere' pos='6 0 -1.8' size='0.6' euler='0 100 70'" + b;
}

std::vector<TestScene> Make() {
  const Pose ahead = LookingFrom({0, 0, 0}, 0, 0);
  return {
      {"PicturesOnShapes", World(kWhite, "", Shapes("picture", "picture_metric")), ahead},
      {"RepeatedPictures", World(kWhite, "", Shapes("picture_often", "picture_often")), ahead},
      {"CubesOnShapes", World(kWhite, "", Shapes("faces", "faces_metric")), ahead},
      {"Sunlit",
       World(kDim,
             R"(<material name="red" rgba="0.8 0.3 0.2 1"/><material name="blue" rgba="0.2 0.3 0.9 1"/>)",
             kSun + Shapes("red", "blue")),
       ahead},
      {"Unlit", World(R"(<headlight active="0"/>)", "", Shapes("picture", "faces")), ahead},
      {"Planes", World(kWhite, "", R"(
    <geom type="plane" pos="6 1.8 1" size="1.2 1.5 1" euler="10 -60 20" material="picture"/>
    <geom type="plane" pos="6 -1.8 1" size="1.2 1.5 0.3" euler="-10 -60 -30" material="picture_metric"/>
    <geom type="plane" pos="6 1.8 -1.5" size="1.4 0.9 1" euler="10 -60 20" material="faces"/>
    <geom type="plane" pos="6 -1.8 -1.5" size="1.4 0.9 1" euler="-10 -60 120" material="faces_metric"/>
    <geom type="plane" pos="0 -3 -2.4" size="0 1.5 1" euler="10 0 0" material="picture"/>)"),
       ahead},
      {"Meshes", World(kDim, kMeshes, kSun + R"(
    <geom type="mesh" mesh="wedge" pos="5 1.5 1" euler="20 10 70" material="picture"/>
    <geom type="mesh" mesh="wedge" pos="5 -1.5 1" euler="-60 10 30" material="picture_metric"/>
    <geom type="mesh" mesh="wedge" pos="5 -1.5 -1" euler="100 40 30" material="faces"/>
    <geom type="mesh" mesh="mapped" pos="5 1.5 -1" euler="20 -60 30" material="picture"/>
    <geom type="mesh" mesh="bowl" pos="6 0 0" euler="20 -50 30" rgba="0.7 0.7 0.2 1"/>)"),
       ahead},
      {"Facets", World(kWhite, kFacets, R"(
    <geom type="mesh" mesh="facets" material="picture"/>)"),
       LookingFrom({0, 0, 0}, 0, -0.3)},
      {"HeightFields", World(kDim, kHill, kSun + R"(
    <geom type="hfield" hfield="hill" pos="5 2.2 -1.2" euler="0 0 20" material="picture"/>
    <geom type="hfield" hfield="hill" pos="7 -2.5 -1.2" euler="0 0 -70" material="faces_metric"/>
    <geom type="hfield" hfield="hill" pos="6 0 2.5" euler="170 0 30" rgba="0.3 0.8 0.4 1"/>)"),
       ahead},
      {"Lamps",
       World(R"(<headlight ambient="0.1 0.1 0.1" diffuse="0.3 0.3 0.3" specular="0.3 0.3 0.3"/>)", R"(
    <material name="matt" rgba="0.7 0.6 0.5 1" specular="0"/>
    <material name="shiny" rgba="0.3 0.4 0.6 1" specular="0.8" shininess="0.3"/>
    <material name="glow" rgba="0.4 0.3 0.2 1" emission="0.6" specular="0.5" shininess="0.05"/>)",
             R"(
    <light pos="4 2 3" dir="0.6 -0.6 -1" cutoff="40" exponent="5" ambient="0.1 0.1 0" diffuse="0.7 0.2 0.2"
      specular="0.6 0.6 0.6" attenuation="0.5 0.1 0.02"/>
    <light pos="3 -3 2" dir="1 0.8 -0.5" cutoff="80" exponent="0" diffuse="0.2 0.6 0.3" specular="0.2 0.2 0.5"/>
    <light directional="true" dir="0.2 0.9 -0.4" diffuse="0.1 0.1 0.4" specular="0.5 0.5 0.5"/>
    <light active="false" pos="3 -3 2" dir="1 0.8 -0.5"/>
    <geom type="plane" size="20 20 0.05" pos="0 0 -2" material="matt"/>)" +
                 Shapes("shiny", "glow")),
       LookingFrom({-1, 0, -1.5}, 0, -0.2)},
      // OpenGL takes no cutoff between 90 and 180 degrees, and eight lights: the last two are not among them.
      {"WideAndManyLamps", World(R"(<headlight ambient="0.02 0.02 0.02" diffuse="0.1 0.1 0.1"/>)", "", R"(
    <light pos="2 0 2" dir="1 0 -1" diffuse="0.1 0.2 0.3" cutoff="120" exponent="3"/>
    <light directional="true" dir="1 0.1 -0.2" diffuse="0.2 0.1 0.1"/>
    <light directional="true" dir="1 0.3 0.2" diffuse="0.1 0.1 0.2"/>
    <light directional="true" dir="1 -0.1 -0.2" diffuse="0.1 0.1 0.1"/>
    <light directional="true" dir="0 0 -1" diffuse="0.1 0.1 0.1"/>
    <light directional="true" dir="0 1 0" diffuse="0.1 0.1 0.1"/>
    <light directional="true" dir="0 -1 0" diffuse="0.1 0.1 0.1"/>
    <light directional="true" dir="1 0.1 -0.2" diffuse="0.9 0.1 0.1"/>
    <light directional="true" dir="1 0.1 -0.2" diffuse="0.1 0.9 0.1"/>)" + Shapes("picture", "faces")),
       ahead},
      // The colour of a geom goes over that of its material; one picture may be all faces of a cube; the sky
      // may also lie on things; alpha 0 and groups from 3 on are not shown.
      {"Materials",
       World(kWhite, kMeshes + kSky + R"(
    <texture name="square" type="cube" file="square.png"/><material name="square" texture="square"/>
    <material name="sky" texture="sky" texuniform="true" rgba="1 0.8 1 1"/>
    <material name="hidden" rgba="1 1 1 0"/>)",
             R"(
    <geom type="box" pos="6 2.5 1.5" size="0.7 0.5 0.6" euler="20 25 40" material="square"/>
    <geom type="capsule" pos="6 0.8 1.5" size="0.4 0.5" euler="20 65 40" material="sky"/>
    <geom type="mesh" mesh="wedge" pos="5 -2 -1" euler="100 40 30" material="sky"/>
    <geom type="box" pos="3 0.8 -0.5" size="0.7 0.5 0.6" material="hidden"/>
    <geom type="box" pos="3 0.8 -0.8" size="0.2 0.2 0.2" material="hidden" rgba="0.2 0.9 0.2 1"/>
    <geom type="box" pos="5 -2 1" size="0.5 0.5 0.5" group="2" material="picture"/>
    <geom type="box" pos="5 -1 1" size="0.5 0.5 0.5" group="3" material="picture"/>)"),
       ahead},
      {"Inside", World(kWhite, "", R"(
    <geom type="box" size="1 1 1" rgba="0.9 0.1 0.1 1"/>
    <geom type="sphere" size="2" rgba="0.1 0.9 0.1 1"/>
    <geom type="cylinder" size="2 1.5" rgba="0.1 0.9 0.9 1"/>
    <geom type="capsule" size="2 1.5" rgba="0.9 0.9 0.1 1"/>
    <geom type="box" pos="5 0 0" size="0.5 0.5 0.5" material="picture"/>)"),
       LookingFrom({0.3, 0.2, 0.1}, 0, 0.1)},
      {"Sky", World(kWhite, kSky, Shapes("picture", "faces")), LookingFrom({0, 0, 0}, 0.6, 0.5, 0.3)},
      {"SkyBehind", World(kWhite, kSky, Shapes("picture", "faces")), LookingFrom({0, 0, 0}, -2.2, -0.6, 1.0)},
      {"Haze",
       World(kWhite + kHaze, kSky + R"(
    <material name="field" texture="picture" texuniform="true" texrepeat="0.02 0.01"/>)",
             R"(
    <geom type="plane" size="0 0 1" material="field"/>
    <geom type="box" pos="280 40 20" size="10 20 20" rgba="0.2 0.2 0.2 1"/>)"),
       LookingFrom({0, 0, -40}, 0.1, -0.15)},
      {"SlantingHaze", World(kWhite + kHaze, kSky, R"(
    <geom type="plane" size="0 0 1" euler="6 3 0" rgba="0.4 0.5 0.3 1"/>
    <geom type="box" pos="300 40 20" size="10 20 20" rgba="0.2 0.2 0.2 1"/>
    <geom type="box" pos="180 -30 20" size="10 15 30" rgba="0.9 0.9 0.9 0.7"/>)"),
       LookingFrom({0, 0, -60}, 0.1, -0.15)},
      {"Glass",
       World(kDim, kSky + R"(
    <material name="red" rgba="0.9 0.2 0.1 0.4"/>
    <material name="blue" rgba="0.1 0.2 0.9 0.6" texture="picture" specular="0"/>)",
             kSun + R"(
    <geom type="box" pos="4 0.5 0.2" size="0.4 0.6 0.6" euler="0 0 30" material="red"/>
    <geom type="sphere" pos="6 0.2 0.3" size="1" material="blue"/>
    <geom type="capsule" pos="5 -0.6 0" size="0.4 0.8" rgba="0.2 0.9 0.3 0.3"/>
    <geom type="cylinder" pos="5.2 1.8 0.5" size="0.5 0.9" rgba="0.9 0.9 0.3 0.994"/>
    <geom type="cylinder" pos="5.2 -2 0.5" size="0.5 0.9" rgba="0.9 0.9 0.3 0.996"/>
    <geom type="plane" pos="7 0 0" size="2 2 1" euler="0 -70 0" rgba="0.9 0.9 0.9 0.5"/>
    <geom type="plane" pos="7 -1.5 -1.5" size="1.5 1 1" euler="0 70 0" material="picture"/>
    <geom type="box" pos="9 -0.5 0" size="0.5 1.5 0.3" rgba="0.6 0.5 0.2 1"/>)"),
       ahead},
      {"HollowGlass", World(kDim, kMeshes + kHill, kSun + R"(
    <geom type="mesh" mesh="bowl" pos="5 -1.4 0.5" euler="20 -15 40" rgba="0.2 0.9 0.9 0.5"/>
    <geom type="hfield" hfield="hill" pos="6 1.2 -1" euler="0 -10 10" rgba="0.9 0.3 0.3 0.4"/>)"),
       ahead, true},
      {"BeyondTheSky", World(kWhite + kHaze, kSky, R"(
    <geom type="plane" size="0 0 1" rgba="0.4 0.5 0.3 1"/>
    <geom type="box" pos="345 70 30" size="20 30 20" rgba="0.9 0.1 0.1 1"/>
    <geom type="box" pos="300 -20 30" size="10 20 30" rgba="0.9 0.9 0.9 0.7"/>
    <geom type="box" pos="345 -90 30" size="20 20 40" rgba="0.9 0.9 0.9 0.7"/>)"),
       LookingFrom({0, 0, -60}, 0, -0.15), true},
  };
}

}  // namespace

ModelPtr CompileScene(const std::string& xml) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  AddFile(files.get(), "scene.xml", {xml.begin(), xml.end()});
  AddFile(files.get(), "picture.png", Png(RenderedFrame()));
  AddFile(files.get(), "faces.png", Png(Faces()));
  AddFile(files.get(), "square.png", Png(Faces().rowRange(64, 96)));
  AddFile(files.get(), "relief.png", Png(Relief()));
  char error[500] = "";
  ModelPtr model(mj_loadXML("scene.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(error);
  return model;
}

DataPtr StateOf(const mjModel* model) {
  DataPtr data = MakeData(model);
  mj_forward(model, data.get());
  return data;
}

Pose LookingFrom(const Eigen::Vector3d& p_NC, double yaw, double pitch, double roll) {
  const Eigen::Matrix3d R_BC = (Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
  return {Eigen::Quaterniond(RotationFromTaitBryan({.yaw = yaw, .pitch = pitch, .roll = roll}) * R_BC), p_NC};
}

const std::vector<TestScene>& TestScenes() {
  static const std::vector<TestScene> scenes = Make();
  return scenes;
}

}  // namespace kestrel::sim
