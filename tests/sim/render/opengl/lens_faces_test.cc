// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/lens_faces.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "geometry/tait_bryan.h"
#include "tests/sim/lenses.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kNoMatter_px = 8192;

// The middle of a patch in the picture of its face, rows downwards.
Vector2d PlaceOf(const Patch& patch, const Face& face) {
  return {patch.x / 65536.0, face.camera.height_px - 1 - patch.y / 65536.0};
}

class LensFacesTest : public ::testing::TestWithParam<Lens> {};
INSTANTIATE_TEST_SUITE_P(Lenses, LensFacesTest, ::testing::ValuesIn(Lenses()), NameOfLens);

TEST_P(LensFacesTest, EachPixelOfTheLensIsWhereItsRayMeetsAFace) {
  const vision::CameraModel& camera = GetParam().camera;
  const LensFaces lens = PlanFaces(camera, kNoMatter_px);
  int seen = 0;
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * lens.width_px + u;
      const auto ray = vision::Ray(camera, Vector2d(u, v));
      const Patch& patch = lens.patches[i];
      ASSERT_EQ(patch.face != Patch::kOutside, ray.has_value()) << u << ' ' << v;
      if (!ray) continue;
      ++seen;
      const Face& face = lens.faces[patch.face];
      const Vector2d place = PlaceOf(patch, face);
      const Vector3d in_face = face.R_CV.conjugate() * *ray;
      ASSERT_LT((*face.camera.Project(in_face) - place).norm(), 2.0 / 65536) << u << ' ' << v;
      ASSERT_NEAR(lens.stretch[i] * in_face.z(), 1, 1e-6);
      // All pixels between which its corners lie are in the picture.
      const double reach_x = (std::abs(patch.u_x) + std::abs(patch.v_x)) / 131072.0;
      const double reach_y = (std::abs(patch.u_y) + std::abs(patch.v_y)) / 131072.0;
      ASSERT_GT(place.x() - reach_x, 0);
      ASSERT_GT(place.y() - reach_y, 0);
      ASSERT_LT(place.x() + reach_x, face.camera.width_px - 1);
      ASSERT_LT(place.y() + reach_y, face.camera.height_px - 1);
    }
  }
  EXPECT_GT(seen, 0.4 * lens.width_px * lens.height_px);
}

// A patch is as large as the way to the next.
TEST_P(LensFacesTest, PatchesLieSideBySide) {
  const LensFaces lens = PlanFaces(GetParam().camera, kNoMatter_px);
  int compared = 0;
  for (int v = 1; v + 1 < lens.height_px; v += 3) {
    for (int u = 1; u + 1 < lens.width_px; u += 3) {
      const std::size_t i = static_cast<std::size_t>(v) * lens.width_px + u;
      const auto at = [&](std::size_t k) {
        return Vector2d(lens.patches[k].x / 65536.0, lens.patches[k].y / 65536.0);
      };
      const Patch& here = lens.patches[i];
      for (const auto& [step, side] : {std::pair(std::size_t{1}, Vector2d(here.u_x, here.u_y)),
                                       std::pair(std::size_t(lens.width_px), Vector2d(here.v_x, here.v_y))}) {
        if (here.face == Patch::kOutside || lens.patches[i - step].face != here.face ||
            lens.patches[i + step].face != here.face)
          continue;
        const Vector2d way = (at(i + step) - at(i - step)) / 2;
        ASSERT_LT((side / 65536 - way).norm(), 0.05 * way.norm()) << u << ' ' << v;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 5000);
}

// One pixel of the lens further is at least two in the face.
TEST_P(LensFacesTest, FacesAreTwiceAsFineAsTheLensWhereItIsDensest) {
  const LensFaces lens = PlanFaces(GetParam().camera, kNoMatter_px);
  std::vector<std::vector<double>> steps(lens.faces.size());
  for (int v = 0; v + 1 < lens.height_px; ++v) {
    for (int u = 0; u + 1 < lens.width_px; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * lens.width_px + u;
      const Patch& here = lens.patches[i];
      for (const Patch& next : {lens.patches[i + 1], lens.patches[i + lens.width_px]}) {
        if (here.face == Patch::kOutside || here.face != next.face) continue;
        const Face& face = lens.faces[here.face];
        steps[here.face].push_back((PlaceOf(next, face) - PlaceOf(here, face)).norm());
      }
    }
  }
  for (std::vector<double>& of_face : steps) {
    ASSERT_GT(of_face.size(), 100u);
    const auto few = of_face.begin() + static_cast<std::ptrdiff_t>(of_face.size() / 200);
    std::nth_element(of_face.begin(), few, of_face.end());
    EXPECT_GT(*few, 1.99);
    EXPECT_LT(*few, 3.5);  // nor much finer than asked: it costs time
  }
}

TEST(LensFaces, OnlyFacesThatTheLensUsesAndOnePlaneIfThatWillDo) {
  const auto faces = [](const char* name) { return PlanFaces(LensNamed(name), kNoMatter_px).faces.size(); };
  EXPECT_EQ(faces("oblong_pinhole"), 1u);
  EXPECT_EQ(faces("brown_conrady"), 1u);
  EXPECT_EQ(faces("fisheye"), 5u);  // nothing behind
  EXPECT_EQ(faces("hyperbolic_mirror"), 5u);
}

TEST(LensFaces, APinholeWithSquarePixelsIsItsOwnFace) {
  EXPECT_TRUE(OnlyFace(LensNamed("pinhole")));
  EXPECT_FALSE(OnlyFace(LensNamed("oblong_pinhole")));
  EXPECT_FALSE(OnlyFace(LensNamed("fisheye")));
  vision::Pinhole narrow{640, 480, 400, 400, 319.5, 239.5};
  narrow.max_angle_rad = Radians(30);  // its corners are black
  EXPECT_FALSE(OnlyFace(narrow));
}

TEST(LensFaces, NoSideIsLongerThanAllowed) {
  for (const Face& face : PlanFaces(LensNamed("fisheye"), 300).faces) {
    EXPECT_LE(face.camera.width_px, 300);
    EXPECT_LE(face.camera.height_px, 300);
  }
}

TEST(LensFaces, ThereAreNoneWhereRaysGoTooFarFromAllAxes) {
  EXPECT_FALSE(PlanFaces(LensNamed("fisheye"), {Eigen::Quaterniond::Identity()}, kNoMatter_px));
}

}  // namespace
}  // namespace kestrel::sim
