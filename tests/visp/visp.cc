// SPDX-License-Identifier: Apache-2.0
#include "tests/visp/visp.h"

#include <visp3/core/vpHomogeneousMatrix.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#include <visp3/visual_features/vpFeatureThetaU.h>
#include <visp3/visual_features/vpFeatureTranslation.h>
#include <visp3/vs/vpServo.h>

#include <list>

namespace kestrel::visp {
namespace {

vpHomogeneousMatrix Visp(const Pose& X) {
  const Eigen::Matrix3d R = X.R.toRotationMatrix();
  vpRotationMatrix rotation;
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 3; ++j) rotation[i][j] = R(i, j);
  }
  return vpHomogeneousMatrix(vpTranslationVector(X.p.x(), X.p.y(), X.p.z()), rotation);
}

Eigen::VectorXd FromVisp(const vpColVector& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data, static_cast<Eigen::Index>(v.size()));
}

Eigen::MatrixXd FromVisp(const vpMatrix& m) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(m.data, static_cast<Eigen::Index>(m.getRows()),
                                    static_cast<Eigen::Index>(m.getCols()));
}

Eigen::VectorXd Velocity(vpFeatureTranslation& t, vpFeatureTranslation& t_wanted, const Pose& X_DC,
                         double lambda) {
  vpFeatureThetaU turn(vpFeatureThetaU::cdRc), no_turn(vpFeatureThetaU::cdRc);
  turn.buildFrom(Visp(X_DC));
  vpServo task;
  task.setServo(vpServo::EYEINHAND_CAMERA);
  task.setInteractionMatrixType(vpServo::CURRENT, vpServo::PSEUDO_INVERSE);
  task.setLambda(lambda);
  task.addFeature(t, t_wanted);
  task.addFeature(turn, no_turn);
  return FromVisp(task.computeControlLaw());
}

}  // namespace

Eigen::MatrixXd PointInteraction(const Eigen::Vector3d& xyZ) {
  vpFeaturePoint s;
  s.buildFrom(xyZ.x(), xyZ.y(), xyZ.z());
  return FromVisp(s.interaction());
}

Eigen::VectorXd PointVelocity(const std::vector<Eigen::Vector3d>& now,
                              const std::vector<Eigen::Vector3d>& wanted, Matrix matrix, double lambda) {
  std::list<vpFeaturePoint> features;  // the task keeps pointers
  const auto feature = [&](const Eigen::Vector3d& xyZ) -> vpFeaturePoint& {
    vpFeaturePoint& s = features.emplace_back();
    s.buildFrom(xyZ.x(), xyZ.y(), xyZ.z());
    return s;
  };
  vpServo task;
  task.setServo(vpServo::EYEINHAND_CAMERA);
  task.setInteractionMatrixType(matrix == Matrix::kCurrent   ? vpServo::CURRENT
                                : matrix == Matrix::kDesired ? vpServo::DESIRED
                                                             : vpServo::MEAN,
                                vpServo::PSEUDO_INVERSE);
  task.setLambda(lambda);
  for (std::size_t i = 0; i < now.size(); ++i) {
    vpFeaturePoint& s = feature(now[i]);
    task.addFeature(s, feature(wanted[i]));
  }
  return FromVisp(task.computeControlLaw());
}

Eigen::VectorXd PoseVelocity(const Pose& X_DC, double lambda) {
  vpFeatureTranslation moved(vpFeatureTranslation::cdMc), home(vpFeatureTranslation::cdMc);
  moved.buildFrom(Visp(X_DC));
  return Velocity(moved, home, X_DC, lambda);
}

Eigen::VectorXd TargetPoseVelocity(const Pose& X_CO, const Pose& X_DO, double lambda) {
  vpFeatureTranslation target(vpFeatureTranslation::cMo), wanted(vpFeatureTranslation::cMo);
  target.buildFrom(Visp(X_CO));
  wanted.buildFrom(Visp(X_DO));
  return Velocity(target, wanted, X_DO * X_CO.Inverse(), lambda);
}

Eigen::MatrixXd ThetaUInteraction(const Pose& X_DC) {
  vpFeatureThetaU turn(vpFeatureThetaU::cdRc);
  turn.buildFrom(Visp(X_DC));
  return FromVisp(turn.interaction());
}

}  // namespace kestrel::visp
