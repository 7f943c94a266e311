// SPDX-License-Identifier: Apache-2.0
#include "tests/visp/visp.h"

#include <visp3/core/vpHomogeneousMatrix.h>
#include <visp3/core/vpMomentAreaNormalized.h>
#include <visp3/core/vpMomentBasic.h>
#include <visp3/core/vpMomentCentered.h>
#include <visp3/core/vpMomentDatabase.h>
#include <visp3/core/vpMomentGravityCenter.h>
#include <visp3/core/vpMomentGravityCenterNormalized.h>
#include <visp3/core/vpMomentObject.h>
#include <visp3/core/vpPoint.h>
#include <visp3/visual_features/vpFeatureDepth.h>
#include <visp3/visual_features/vpFeatureMomentAreaNormalized.h>
#include <visp3/visual_features/vpFeatureMomentBasic.h>
#include <visp3/visual_features/vpFeatureMomentCentered.h>
#include <visp3/visual_features/vpFeatureMomentDatabase.h>
#include <visp3/visual_features/vpFeatureMomentGravityCenter.h>
#include <visp3/visual_features/vpFeatureMomentGravityCenterNormalized.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#include <visp3/visual_features/vpFeatureThetaU.h>
#include <visp3/visual_features/vpFeatureTranslation.h>
#include <visp3/vs/vpServo.h>

#include <cmath>
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

Eigen::VectorXd HybridVelocity(const Eigen::Vector3d& now_xyZ, const Eigen::Vector3d& wanted_xyZ,
                               const Pose& X_DC, double lambda) {
  vpFeaturePoint point, point_wanted;
  point.buildFrom(now_xyZ.x(), now_xyZ.y(), now_xyZ.z());
  point_wanted.buildFrom(wanted_xyZ.x(), wanted_xyZ.y(), wanted_xyZ.z());
  vpFeatureDepth depth, depth_wanted;
  depth.buildFrom(now_xyZ.x(), now_xyZ.y(), now_xyZ.z(), std::log(now_xyZ.z() / wanted_xyZ.z()));
  depth_wanted.buildFrom(wanted_xyZ.x(), wanted_xyZ.y(), wanted_xyZ.z(), 0);
  vpFeatureThetaU turn(vpFeatureThetaU::cdRc), no_turn(vpFeatureThetaU::cdRc);
  turn.buildFrom(Visp(X_DC));
  vpServo task;
  task.setServo(vpServo::EYEINHAND_CAMERA);
  task.setInteractionMatrixType(vpServo::CURRENT, vpServo::PSEUDO_INVERSE);
  task.setLambda(lambda);
  task.addFeature(point, point_wanted);
  task.addFeature(depth, depth_wanted);
  task.addFeature(turn, no_turn);
  return FromVisp(task.computeControlLaw());
}

Moments NormalisedMoments(const std::vector<Eigen::Vector2d>& points, double Z, double area_wanted,
                          double Z_wanted) {
  std::vector<vpPoint> theirs;
  for (const Eigen::Vector2d& p : points) {
    vpPoint& point = theirs.emplace_back();
    point.set_x(p.x()), point.set_y(p.y());
  }
  vpMomentObject object(3);
  object.setType(vpMomentObject::DISCRETE);
  object.fromVector(theirs);
  vpMomentDatabase moments;
  vpMomentBasic basic;
  vpMomentGravityCenter centre;
  vpMomentCentered centred;
  vpMomentAreaNormalized area(area_wanted, Z_wanted);
  vpMomentGravityCenterNormalized centre_normalised;
  basic.linkTo(moments), centre.linkTo(moments), centred.linkTo(moments), area.linkTo(moments);
  centre_normalised.linkTo(moments);
  moments.updateAll(object);
  centre.compute(), centred.compute(), area.compute(), centre_normalised.compute();

  vpFeatureMomentDatabase features;
  vpFeatureMomentBasic f_basic(moments, 0, 0, 1, &features);
  vpFeatureMomentGravityCenter f_centre(moments, 0, 0, 1, &features);
  vpFeatureMomentCentered f_centred(moments, 0, 0, 1, &features);
  vpFeatureMomentAreaNormalized f_area(moments, 0, 0, 1, &features);
  vpFeatureMomentGravityCenterNormalized f_normalised(moments, 0, 0, 1, &features);
  for (vpFeatureMoment* each :
       std::initializer_list<vpFeatureMoment*>{&f_basic, &f_centre, &f_centred, &f_area, &f_normalised}) {
    each->linkTo(features);
    each->update(0, 0, 1 / Z);
  }
  Moments answer;
  answer.value << centre_normalised.get()[0], centre_normalised.get()[1], area.get()[0];
  answer.interaction.resize(3, 6);
  answer.interaction.row(0) =
      FromVisp(f_normalised.interaction(vpFeatureMomentGravityCenterNormalized::selectXn()));
  answer.interaction.row(1) =
      FromVisp(f_normalised.interaction(vpFeatureMomentGravityCenterNormalized::selectYn()));
  answer.interaction.row(2) = FromVisp(f_area.interaction(1));
  return answer;
}

}  // namespace kestrel::visp
