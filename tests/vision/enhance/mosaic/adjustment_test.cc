// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/adjustment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "base/random.h"
#include "geometry/pose.h"
#include "vision/camera/kannala_brandt.h"
#include "vision/enhance/mosaic/motion_estimate.h"
#include "vision/enhance/mosaic/straighten.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Pinhole kCamera{640, 480, 600, 600, 319.5, 239.5};

Matrix3d RandomRotation(RandomStream& random, double size) {
  return ExpRotation(size * Vector3d(random.Normal(), random.Normal(), random.Normal())).toRotationMatrix();
}

// A homography of rays near that of a camera over a plane.
Matrix3d RandomHomography(RandomStream& random) {
  Matrix3d H = Matrix3d::Identity();
  for (int i = 0; i < 8; ++i) H(i / 3, i % 3) += (i % 3 == 2 ? 0.1 : 0.02) * random.Normal();
  return H;
}

std::vector<PixelPair> PairsOf(const CameraModel& camera, const Matrix3d& M_AB, int n, RandomStream& random) {
  std::vector<PixelPair> pairs;
  while (static_cast<int>(pairs.size()) < n) {
    const Vector2d b(random.Uniform(0, 639), random.Uniform(0, 479));
    const auto ray = Ray(camera, b);
    const auto a = ray ? Project(camera, M_AB * *ray) : std::nullopt;
    if (a && a->x() > 0 && a->y() > 0 && a->x() < 639 && a->y() < 479) pairs.push_back({*a, b});
  }
  return pairs;
}

TEST(MotionEstimateTest, FindsAHomographyAmongOutliers) {
  RandomStream random(1, "test");
  for (int i = 0; i < 10; ++i) {
    const Matrix3d H = RandomHomography(random);
    std::vector<PixelPair> pairs = PairsOf(kCamera, H, 80, random);
    for (int k = 0; k < 30; ++k) pairs[k].b = {random.Uniform(0, 639), random.Uniform(0, 479)};
    const auto found = EstimateMotion(MosaicModel::kPlane, kCamera, pairs, 1, 20);
    ASSERT_TRUE(found);
    EXPECT_GE(found->pairs.size(), 50u);
    EXPECT_LT((found->M_AB / found->M_AB(2, 2) - H / H(2, 2)).norm(), 1e-3);
  }
}

TEST(MotionEstimateTest, FindsARotationAmongOutliersThroughAFisheye) {
  KannalaBrandt fisheye;
  fisheye.width_px = 640, fisheye.height_px = 480;
  fisheye.fx = fisheye.fy = 230, fisheye.cx = 319.5, fisheye.cy = 239.5;
  RandomStream random(2, "test");
  for (int i = 0; i < 10; ++i) {
    const Matrix3d R = RandomRotation(random, 0.3);
    std::vector<PixelPair> pairs = PairsOf(fisheye, R, 80, random);
    for (int k = 0; k < 30; ++k) pairs[k].b = {random.Uniform(0, 639), random.Uniform(0, 479)};
    const auto found = EstimateMotion(MosaicModel::kRotation, fisheye, pairs, 1, 20);
    ASSERT_TRUE(found);
    EXPECT_GE(found->pairs.size(), 50u);
    EXPECT_LT((found->M_AB - R).norm(), 1e-3);
  }
}

TEST(MotionEstimateTest, PairsThatAgreeOnNothingGiveNone) {
  RandomStream random(3, "test");
  std::vector<PixelPair> pairs;
  for (int k = 0; k < 100; ++k)
    pairs.push_back(
        {{random.Uniform(0, 639), random.Uniform(0, 479)}, {random.Uniform(0, 639), random.Uniform(0, 479)}});
  for (const MosaicModel model : {MosaicModel::kPlane, MosaicModel::kRotation})
    EXPECT_FALSE(EstimateMotion(model, kCamera, pairs, 1.5, 20));
}

struct Ring {
  std::vector<Matrix3d> truth, start;
  std::vector<AdjustmentEdge> edges;
};

// Images in a row, each joined to the next two, the last to the first; the start is off.
Ring MakeRing(MosaicModel model, int n, RandomStream& random) {
  Ring ring;
  for (int i = 0; i < n; ++i) {
    const double turn = 0.12 * std::sin(2 * M_PI * i / n), tilt = 0.12 * std::cos(2 * M_PI * i / n);
    const Matrix3d R = ExpRotation({tilt, turn, 0}).toRotationMatrix();
    ring.truth.push_back(model == MosaicModel::kRotation ? R : Matrix3d(R * RandomHomography(random)));
    const bool fixed = i == 0;
    Matrix3d off = RandomRotation(random, fixed ? 0 : 0.01);
    if (model == MosaicModel::kPlane && !fixed)
      for (int k = 0; k < 8; ++k) off(k / 3, k % 3) += 0.005 * random.Normal();
    ring.start.push_back(ring.truth.back() * off);
  }
  for (int i = 0; i < n; ++i)
    for (const int step : {1, 2}) {
      const int j = (i + step) % n;
      ring.edges.push_back({i, j, PairsOf(kCamera, ring.truth[i].inverse() * ring.truth[j], 30, random)});
    }
  return ring;
}

class AdjustmentTest : public ::testing::TestWithParam<MosaicModel> {};

TEST_P(AdjustmentTest, FindsThePlacementsThatThePairsComeFrom) {
  RandomStream random(5, "test");
  Ring ring = MakeRing(GetParam(), 12, random);
  std::vector<Matrix3d> M = ring.start;
  const AdjustmentResult result =
      AdjustMosaic(GetParam(), kCamera, ring.edges, {}, {.most_iterations = 50}, M);
  EXPECT_LT(result.rms_px, 1e-3);
  for (std::size_t i = 0; i < M.size(); ++i)
    EXPECT_LT((M[i] / M[i](2, 2) - ring.truth[i] / ring.truth[i](2, 2)).norm(), 1e-4) << i;
  EXPECT_LT((M[0] - ring.start[0]).norm(), 1e-12);
}

TEST_P(AdjustmentTest, WrongPairsCountLittle) {
  RandomStream random(6, "test");
  Ring ring = MakeRing(GetParam(), 10, random);
  int wrong = 0;
  for (AdjustmentEdge& edge : ring.edges)
    for (int k = 0; k < 4; ++k, ++wrong)
      edge.pairs[k].a += Vector2d(random.Uniform(20, 60), random.Uniform(-60, 60));
  EXPECT_GT(wrong, 50);
  std::vector<Matrix3d> M = ring.start;
  AdjustMosaic(GetParam(), kCamera, ring.edges, {}, {.most_iterations = 50}, M);
  for (std::size_t i = 0; i < M.size(); ++i)
    EXPECT_LT((M[i] / M[i](2, 2) - ring.truth[i] / ring.truth[i](2, 2)).norm(), 3e-3) << i;
}

TEST_P(AdjustmentTest, PriorsPlaceTheWhole) {
  RandomStream random(7, "test");
  Ring ring = MakeRing(GetParam(), 10, random);
  std::vector<AdjustmentPrior> priors;
  for (int i = 0; i < 10; ++i) priors.push_back({i, ring.truth[i], 10});
  std::vector<Matrix3d> M;
  const Matrix3d off = RandomRotation(random, 0.02);
  for (const Matrix3d& each : ring.truth) M.push_back(off * each);  // all agree, and lie elsewhere
  AdjustMosaic(GetParam(), kCamera, ring.edges, priors, {.most_iterations = 50}, M);
  for (std::size_t i = 0; i < M.size(); ++i)
    EXPECT_LT((M[i] / M[i](2, 2) - ring.truth[i] / ring.truth[i](2, 2)).norm(), 1e-4) << i;
}

INSTANTIATE_TEST_SUITE_P(Models, AdjustmentTest,
                         ::testing::Values(MosaicModel::kPlane, MosaicModel::kRotation), [](const auto& its) {
                           return its.param == MosaicModel::kPlane ? "Plane" : "Rotation";
                         });

TEST(StraighteningTest, DownIsSquareToTheCamerasXAxes) {
  RandomStream random(8, "test");
  const Matrix3d R_WN = RandomRotation(random, 0.7);  // how the first camera happened to be held
  std::vector<Matrix3d> cameras;
  for (double yaw = 0; yaw < 5; yaw += 0.3)
    cameras.push_back(R_WN * Eigen::AngleAxisd(yaw, Vector3d::UnitY()).toRotationMatrix() *
                      Eigen::AngleAxisd(-0.2, Vector3d::UnitX()).toRotationMatrix());
  const auto R_VW = Straightening(cameras);
  ASSERT_TRUE(R_VW);
  EXPECT_LT((*R_VW * R_WN * Vector3d::UnitY() - Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_NEAR((*R_VW * cameras[0].col(2)).x(), 0, 1e-9);
  EXPECT_GT((*R_VW * cameras[0].col(2)).z(), 0);
  EXPECT_NEAR(R_VW->determinant(), 1, 1e-9);
  EXPECT_FALSE(Straightening(std::span(cameras).first(1)));
}

}  // namespace
}  // namespace kestrel::vision
