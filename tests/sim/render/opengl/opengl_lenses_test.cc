// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/random.h"
#include "sim/render/opengl/opengl_renderer.h"
#include "tests/sim/lenses.h"
#include "tests/sim/scenes.h"
#include "tests/sim/small_worlds.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class OpenGlLenses : public ::testing::TestWithParam<Lens> {};
INSTANTIATE_TEST_SUITE_P(Lenses, OpenGlLenses, ::testing::ValuesIn(Lenses()), NameOfLens);

// A place with that much of the lens's image around it.
bool Shows(const vision::CameraModel& camera, const Vector2d& uv, double around_px) {
  for (const double u : {-around_px, around_px})
    for (const double v : {-around_px, around_px})
      if (!vision::Ray(camera, uv + Vector2d(u, v))) return false;
  return true;
}

// The middle of the light within some pixels.
Vector2d Centroid(const cv::Mat& image, const Vector2d& around, int reach_px) {
  const cv::Point middle(static_cast<int>(std::lround(around.x())),
                         static_cast<int>(std::lround(around.y())));
  const cv::Rect window(middle.x - reach_px, middle.y - reach_px, 2 * reach_px + 1, 2 * reach_px + 1);
  cv::Mat grey;
  cv::extractChannel(image(window), grey, 0);
  const cv::Moments m = cv::moments(grey);
  return Vector2d(m.m10 / m.m00 + window.x, m.m01 / m.m00 + window.y);
}

// Where the middle of a spot's light lies in the image: the mean of where the model puts the patches of its
// picture, by their brightness and by how large they are there.
Vector2d MiddleOfLight(const vision::CameraModel& camera, const mjModel* model, const Pose& X_CD,
                       double radius) {
  const int side = model->tex_width[0];
  Vector2d sum = Vector2d::Zero();
  double weights = 0;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const Vector3d p_DQ = radius * Vector3d((2 * column + 1.0) / side - 1, (2 * row + 1.0) / side - 1, 0);
      if (p_DQ.norm() > radius) continue;
      Eigen::Matrix<double, 2, 3> d_point;
      const Vector2d uv = *vision::Project(camera, X_CD * p_DQ, &d_point);
      const Eigen::Matrix2d d_disc = d_point * X_CD.R.toRotationMatrix().leftCols<2>();
      const double weight = model->tex_rgb[3 * (side * row + column)] * std::abs(d_disc.determinant());
      sum += weight * uv, weights += weight;
    }
  }
  return sum / weights;
}

// Spots of 6 px all over the field, face on, at distances from 0.5 to 20 m. They fade towards their rims:
// OpenGL counts a pixel's middle only, which would move the middle of a small sharp disc by a tenth of a
// pixel.
TEST_P(OpenGlLenses, DrawsEachPointWhereTheModelPutsIt) {
  constexpr double kRadius_px = 6;
  const vision::CameraModel& camera = GetParam().camera;
  RandomStream random(11, "markers");
  const Pose X_NC = LookingFrom({3, -2, -4}, 0.4, -0.9, 0.2);
  std::vector<std::pair<Pose, double>> spots;  // X_CD, radius
  std::string geoms;
  for (double v = 12; v < vision::HeightPx(camera) - 12; v += 24) {
    for (double u = 12; u < vision::WidthPx(camera) - 12; u += 24) {
      const Vector2d uv(u + random.Uniform(0, 1), v + random.Uniform(0, 1));
      if (!Shows(camera, uv, 9)) continue;
      Eigen::Matrix<double, 3, 2> d_pixel;
      const Vector3d ray = *vision::Ray(camera, uv, &d_pixel);
      const double distance = 0.5 * std::pow(40, random.Uniform(0, 1));
      const double pixel_rad = std::sqrt(d_pixel.col(0).cross(d_pixel.col(1)).norm());
      const Pose X_CD{Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), ray), distance * ray};
      spots.emplace_back(X_CD, kRadius_px * pixel_rad * distance);
      geoms += Spot(X_NC * X_CD, spots.back().second);
    }
  }
  EXPECT_GT(spots.size(), 50u);
  const ModelPtr model = RoomWithSpots(geoms);
  const cv::Mat image = OpenGlRenderer(model.get(), camera, {}).Render(StateOf(model.get()).get(), X_NC);
  for (const auto& [X_CD, radius] : spots) {
    const Vector2d uv = MiddleOfLight(camera, model.get(), X_CD, radius);
    EXPECT_LT((Centroid(image, uv, 9) - uv).norm(), 0.05) << "at " << uv.transpose();
  }
}

TEST_P(OpenGlLenses, IsBlackOutsideTheLensAndNowhereElse) {
  const vision::CameraModel& camera = GetParam().camera;
  const ModelPtr model =
      CompileScene(R"(<mujoco><asset><texture type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1"
    width="8" height="48"/></asset><worldbody/></mujoco>)");
  const DataPtr data = StateOf(model.get());
  OpenGlRenderer renderer(model.get(), camera, {});
  const cv::Mat image = renderer.Render(data.get(), LookingFrom({0, 0, -1}, 0, 0));
  const Surfaces seen = renderer.Trace(data.get(), LookingFrom({0, 0, -1}, 0, 0));
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const bool inside = vision::Ray(camera, Vector2d(u, v)).has_value();
      ASSERT_EQ(image.at<cv::Vec3b>(v, u), inside ? cv::Vec3b(255, 255, 255) : cv::Vec3b()) << u << ' ' << v;
      ASSERT_EQ(seen.geom.at<int>(v, u), inside ? -1 : -2);
      ASSERT_EQ(std::isinf(seen.depth_m.at<float>(v, u)), inside);
      ASSERT_EQ(std::isnan(seen.depth_m.at<float>(v, u)), !inside);
    }
  }
}

ModelPtr SmoothWorld() {
  return CompileScene(R"(<mujoco>
  <visual><headlight ambient="0.3 0.3 0.3" diffuse="0.6 0.6 0.6" specular="0 0 0"/></visual>
  <asset>
    <texture name="sky" type="skybox" builtin="gradient" rgb1="0.2 0.4 0.8" rgb2="1 1 1" width="256" height="1536"/>
    <texture name="ground" type="2d" builtin="gradient" rgb1="0.1 0.9 0.2" rgb2="0.9 0.1 0.4" width="512" height="512"/>
    <material name="ground" texture="ground" specular="0"/>
  </asset>
  <worldbody>
    <light directional="true" dir="0.3 0.2 -1" specular="0 0 0"/>
    <geom type="plane" size="40 40 1" material="ground"/>
    <geom type="box" pos="4 3 1" size="1 1 2" rgba="0.8 0.5 0.3 1"/>
    <geom type="box" pos="-3 4 1" size="1 1 2" rgba="0.3 0.5 0.8 1"/>
  </worldbody>
</mujoco>)");
}

// The seams of a cube are the middles of the faces of one that is turned by 45 degrees, and a lens has the
// same picture by both. They differ where a sharp edge falls between other pixels, but along seams no more
// than anywhere.
TEST_P(OpenGlLenses, FacesMeetWithoutASeam) {
  const vision::CameraModel& camera = GetParam().camera;
  const ModelPtr model = SmoothWorld();
  const DataPtr data = StateOf(model.get());
  const auto image = [&](const LensFaces& faces) {
    return OpenGlRenderer(model.get(), camera, {}, faces)
        .Render(data.get(), LookingFrom({0.5, 0.2, -3}, 0.3, -1.2, 0.2));
  };
  const Eigen::AngleAxisd turn(Radians(45), Vector3d(1, 1, 1).normalized());
  const LensFaces straight = *PlanFaces(camera, Cube(), 8192);
  const LensFaces turned = *PlanFaces(camera, Cube(Eigen::Quaterniond(turn)), 8192);
  cv::Mat difference;
  cv::absdiff(image(straight), image(turned), difference);
  int seams = 0, wrong_at_seams = 0, wrong = 0, all = 0;
  for (int v = 1; v + 1 < difference.rows; ++v) {
    for (int u = 1; u + 1 < difference.cols; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * straight.width_px + u;
      const auto at_seam = [&](const LensFaces& lens) {
        for (const std::size_t next : {i - 1, i + 1, i - lens.width_px, i + lens.width_px})
          if (lens.patches[next].face != lens.patches[i].face && lens.patches[next].face != Patch::kOutside)
            return true;
        return false;
      };
      if (straight.patches[i].face == Patch::kOutside) continue;
      const bool differs = cv::norm(difference.at<cv::Vec3b>(v, u), cv::NORM_INF) > 2;
      ++all, wrong += differs;
      if (at_seam(straight) || at_seam(turned)) ++seams, wrong_at_seams += differs;
    }
  }
  EXPECT_GT(seams, 100);
  EXPECT_LT(wrong, 0.02 * all);  // the edges of two boxes and of the ground
  EXPECT_LT(wrong_at_seams, 0.04 * seams);
}

// Against MuJoCo's own rays: what each pixel's ray meets, and how far away. All with flat faces: OpenGL draws
// round things as polyhedra.
TEST_P(OpenGlLenses, SeesWhatRaysMeetAndHowFarAway) {
  const vision::CameraModel& camera = GetParam().camera;
  const ModelPtr model = CompileScene(R"(<mujoco><worldbody>
    <geom type="plane" size="90 90 1"/>
    <geom type="box" pos="3 2 0.5" size="0.5 0.8 0.5" euler="0 0 30"/>
    <geom type="box" pos="-4 1 1" size="0.7 0.3 1"/>
    <geom type="box" pos="1 -0.5 1.5" size="0.1 0.1 0.1" euler="10 20 30"/>
    <geom type="box" pos="40 -30 10" size="5 5 10"/>
  </worldbody></mujoco>)");
  const DataPtr data = StateOf(model.get());
  const Pose X_NC = LookingFrom({0.5, 0.2, -3}, -0.2, -1.1, 0.4);
  const Surfaces seen = OpenGlRenderer(model.get(), camera, {}).Trace(data.get(), X_NC);
  const auto same_around = [&](int u, int v) {
    for (int dv = -1; dv <= 1; ++dv)
      for (int du = -1; du <= 1; ++du)
        if (seen.geom.at<int>(v + dv, u + du) != seen.geom.at<int>(v, u)) return false;
    return true;
  };
  int compared = 0, on_boxes = 0, wrong_on_boxes = 0;
  for (int v = 1; v + 1 < vision::HeightPx(camera); v += 2) {
    for (int u = 1; u + 1 < vision::WidthPx(camera); u += 2) {
      const auto ray = vision::Ray(camera, Vector2d(u, v));
      if (!ray || !same_around(u, v)) continue;
      mjtNum eye[3], along[3];
      VectorToMujoco(X_NC.p, eye);
      VectorToMujoco(X_NC.R * *ray, along);
      int geom = -1;
      const double distance = mj_ray(model.get(), data.get(), eye, along, nullptr, 1, -1, &geom);
      ++compared;
      ASSERT_EQ(seen.geom.at<int>(v, u), geom) << u << ' ' << v;
      if (geom < 0) continue;
      // The depth buffer's steps, and the 256ths of a pixel to which corners are drawn.
      const bool right = std::abs(seen.depth_m.at<float>(v, u) - distance) < 1e-4 * distance + 1e-4;
      if (geom == 0) {
        ASSERT_TRUE(right) << u << ' ' << v << ": " << seen.depth_m.at<float>(v, u) << ", not " << distance;
      } else {
        ++on_boxes, wrong_on_boxes += !right;
      }
    }
  }
  EXPECT_GT(compared, 5000);
  EXPECT_GT(on_boxes, 100);
  EXPECT_LT(wrong_on_boxes, 0.15 * on_boxes);  // between two sides of one box there is neither's depth
}

TEST(OpenGlRenderer, ImageDoesNotDependOnTheFrameBefore) {
  const ModelPtr model = CompileScene(R"(<mujoco>
  <asset><texture name="ground" type="2d" builtin="checker" rgb1="0.2 0.5 0.2" rgb2="0.5 0.4 0.3" width="64" height="64"/>
    <material name="ground" texture="ground" texrepeat="1 1" texuniform="true"/></asset>
  <worldbody><geom type="plane" size="0 0 1" material="ground"/></worldbody></mujoco>)");
  const DataPtr data = StateOf(model.get());
  const vision::CameraModel camera = LensNamed("fisheye");
  const Pose here = LookingFrom({700, 300, -2}, 0, -0.7);
  OpenGlRenderer renderer(model.get(), camera, {});
  const cv::Mat first = renderer.Render(data.get(), here);
  renderer.Render(data.get(), LookingFrom({-900, 0, -5}, 2, -0.3));
  EXPECT_EQ(cv::norm(first, renderer.Render(data.get(), here), cv::NORM_INF), 0);
  EXPECT_GT(cv::mean(first)[0], 5);  // there is ground, however far one went
}

// A box on a rail, and a camera that passes by.
struct PassingBy {
  ModelPtr model = CompileScene(R"(<mujoco><worldbody>
    <body><joint type="slide" axis="0 1 0"/><geom type="box" pos="5 0 1" size="0.5 0.5 0.5" euler="0 20 30"/></body>
    <geom type="box" pos="6 1 0.6" size="0.3 0.3 0.3" rgba="1 0 0 1"/></worldbody></mujoco>)");
  std::vector<DataPtr> states;
  std::vector<SceneState> scene_states;
  PassingBy() {
    for (int i = 0; i < 3; ++i) {
      states.push_back(MakeData(model.get()));
      states.back()->qpos[0] = 0.4 * i * i;
      mj_forward(model.get(), states.back().get());
      scene_states.push_back({0.1 * i, states.back().get(), LookingFrom({0, 0.1 * i, -1.5}, 0.02 * i, -0.1)});
    }
  }
  // Drawn by a state and a pose of that very time.
  cv::Mat At(OpenGlRenderer& renderer, std::size_t from, double share) const {
    const DataPtr between = MakeData(model.get());
    between->qpos[0] = (1 - share) * states[from]->qpos[0] + share * states[from + 1]->qpos[0];
    mj_forward(model.get(), between.get());
    const Pose &a = scene_states[from].X_NC, &b = scene_states[from + 1].X_NC;
    return renderer.Render(between.get(), {a.R.slerp(share, b.R), a.p + share * (b.p - a.p)});
  }
};

double ShareThatDiffers(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return static_cast<double>(cv::countNonZero(difference.reshape(1) > 1)) /
         static_cast<double>(a.total() * 3);
}

TEST(OpenGlRenderer, BetweenTwoInstantsTheCameraAndThingsAreBetweenTheirPlaces) {
  const PassingBy world;
  OpenGlRenderer renderer(world.model.get(), LensNamed("pinhole"), {});
  const auto sharp_at = [&](double t_s) { return renderer.Render(world.scene_states, {.row_0_s = t_s}); };
  EXPECT_EQ(cv::norm(sharp_at(0.1), renderer.Render(world.states[1].get(), world.scene_states[1].X_NC),
                     cv::NORM_INF),
            0);
  EXPECT_EQ(cv::norm(sharp_at(-5), sharp_at(0), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(sharp_at(5), sharp_at(0.2), cv::NORM_INF), 0);
  EXPECT_GT(ShareThatDiffers(sharp_at(0.13), sharp_at(0.1)), 0.01);
  // Rounding may move an edge by a pixel here and there.
  EXPECT_LT(ShareThatDiffers(sharp_at(0.13), world.At(renderer, 1, 0.3)), 2e-4);
  EXPECT_LT(ShareThatDiffers(sharp_at(0.17), world.At(renderer, 1, 0.7)), 2e-4);
}

TEST(OpenGlRenderer, ALongExposureIsTheMeanOfItsSamples) {
  const PassingBy world;
  OpenGlRenderer renderer(world.model.get(), LensNamed("brown_conrady"), {});
  const cv::Mat blurred =
      renderer.Render(world.scene_states, {.row_0_s = 0.1, .exposure_s = 0.08, .samples = 4});
  cv::Mat mean(blurred.size(), CV_32FC3, cv::Scalar::all(0));
  for (const double t : {0.07, 0.09, 0.11, 0.13})
    cv::accumulate(renderer.Render(world.scene_states, {.row_0_s = t}), mean);
  mean.convertTo(mean, CV_8U, 0.25);
  EXPECT_LT(ShareThatDiffers(blurred, mean), 2e-4);
  EXPECT_GT(ShareThatDiffers(blurred, renderer.Render(world.scene_states, {.row_0_s = 0.1})), 0.01);
}

TEST(OpenGlRenderer, RowsComeFromTheTimeOfTheirBand) {
  const PassingBy world;
  const double line_s = 2e-4;  // 240 rows: 48 ms
  OpenGlRenderer renderer(world.model.get(), LensNamed("fisheye"), {});
  const cv::Mat rolling = renderer.Render(world.scene_states, {.row_0_s = 0.1, .line_s = line_s});
  for (const int band : {0, 7, 14}) {
    const cv::Range rows(16 * band, 16 * band + 16);
    const cv::Mat then = renderer.Render(world.scene_states, {.row_0_s = 0.1 + line_s * (16 * band + 7.5)});
    EXPECT_EQ(cv::norm(rolling.rowRange(rows), then.rowRange(rows), cv::NORM_INF), 0) << "band " << band;
  }
  EXPECT_GT(ShareThatDiffers(rolling, renderer.Render(world.scene_states, {.row_0_s = 0.1})), 0.001);
}

}  // namespace
}  // namespace kestrel::sim
