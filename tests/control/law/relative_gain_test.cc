// SPDX-License-Identifier: Apache-2.0
#include "control/law/relative_gain.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <random>

#include "control/law/sphere_target.h"

namespace kestrel::control {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;

const std::vector<std::string> kFeatures = {"x", "y", "diameter"}, kInputs = {"v_y", "v_z", "w_y"};

TEST(RelativeGainArray, OfASphereAheadIsThePrintedOneAndPairsAsTheThesisDoes) {
  const double x = 0.3;
  const auto rga = RelativeGainArray(FollowInteraction({{x, -0.2}, 0.15}, 4));
  ASSERT_TRUE(rga);
  Matrix3d printed;
  printed << 0, -x * x, x * x + 1, 1, 0, 0, 0, x * x + 1, -x * x;  // eq. (5.22)
  EXPECT_LT((rga->gains - printed).norm(), 1e-12);
  EXPECT_EQ(rga->input_of, (std::vector<int>{2, 0, 1}));  // x by w_y, y by v_y, diameter by v_z
  EXPECT_NEAR(rga->distance, 4 * x * x, 1e-12);

  const auto centred = RelativeGainArray(FollowInteraction({{0, -0.2}, 0.15}, 4));
  ASSERT_TRUE(centred);
  Matrix3d steady;
  steady << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // eq. (5.23)
  EXPECT_LT((centred->gains - steady).norm(), 1e-12);
  EXPECT_LT(centred->distance, 1e-12);
}

TEST(RelativeGainArray, IsByItsDefinitionTheGainWithTheOthersOpenOverThatWithTheOthersPerfect) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 20; ++n) {
    const Eigen::Matrix4d L = Eigen::Matrix4d::NullaryExpr([&] { return normal(rng); });
    const auto rga = RelativeGainArray(L);
    ASSERT_TRUE(rga);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        // The others perfect: the inputs that move feature i by 1 and no other; input j is then its inverse
        // gain.
        const Eigen::Vector4d inputs = L.fullPivLu().solve(Eigen::Vector4d::Unit(i));
        EXPECT_NEAR(rga->gains(i, j), L(i, j) * inputs[j], 1e-9 * (1 + std::abs(rga->gains(i, j))));
      }
    }
  }
}

TEST(RelativeGainArray, RowsAndColumnsSumToOneWhateverTheUnits) {
  Matrix3d L;
  L << 2, 1, -1, 0.5, 3, 1, 1, -1, 4;
  const auto metres = RelativeGainArray(L);
  const Eigen::DiagonalMatrix<double, 3> rows(1000, 0.2, 57.3), columns(0.01, 3, 60);
  const auto others = RelativeGainArray(rows * L * columns);
  ASSERT_TRUE(metres && others);
  EXPECT_LT((metres->gains.rowwise().sum() - Eigen::Vector3d::Ones()).norm(), 1e-12);
  EXPECT_LT((metres->gains.colwise().sum() - Eigen::RowVector3d::Ones()).norm(), 1e-12);
  EXPECT_LT((metres->gains - others->gains).norm(), 1e-12);
  EXPECT_EQ(metres->input_of, others->input_of);
}

TEST(RelativeGainArray, AvoidsAPairWhoseSignTurnsWhenTheOthersClose) {
  Matrix2d L;
  L << 1, 2, 2, 1;  // gains -1/3 on the diagonal
  const auto rga = RelativeGainArray(L);
  ASSERT_TRUE(rga);
  EXPECT_NEAR(rga->gains(0, 0), -1.0 / 3, 1e-12);
  EXPECT_EQ(rga->input_of, (std::vector<int>{1, 0}));
}

TEST(RelativeGainArray, DoesSoEvenWhereThatPairIsTheNearestToOne) {
  Matrix3d L;
  L << -1, -2, 3, 3, 1, 1, 4, 2, -2;
  const auto rga = RelativeGainArray(L);
  ASSERT_TRUE(rga);
  Matrix3d by_hand;
  by_hand << -0.4, 2, -0.6, -0.6, 1, 0.6, 2, -2, 1;
  EXPECT_LT((rga->gains - by_hand).norm(), 1e-12);
  EXPECT_EQ(rga->input_of, (std::vector<int>{1, 2, 0}));  // the diagonal would be nearer, but for its -0.4
}

TEST(RelativeGainArray, HasNoneWhereThereIsNoInverse) {
  Matrix2d singular, gone;
  singular << 1, 2, 2, 4;
  gone << 1, std::numeric_limits<double>::quiet_NaN(), 0, 1;
  EXPECT_FALSE(RelativeGainArray(singular));
  EXPECT_FALSE(RelativeGainArray(gone));
  EXPECT_FALSE(RelativeGainArray(Eigen::MatrixXd::Ones(2, 3)));
  EXPECT_FALSE(RelativeGainArray(Eigen::MatrixXd()));
}

TEST(RelativeGainTable, MarksThePairing) {
  const auto rga = RelativeGainArray(FollowInteraction({{0.3, 0}, 0.15}, 4));
  ASSERT_TRUE(rga);
  EXPECT_EQ(RelativeGainTable(*rga, kFeatures, kInputs),
            "                  v_y        v_z        w_y\n"
            "x               0.000     -0.090     *1.090\n"
            "y              *1.000      0.000      0.000\n"
            "diameter        0.000     *1.090     -0.090\n");
}

}  // namespace
}  // namespace kestrel::control
