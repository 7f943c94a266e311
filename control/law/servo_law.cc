// SPDX-License-Identifier: Apache-2.0
#include "control/law/servo_law.h"

#include <Eigen/SVD>
#include <cassert>
#include <cmath>

namespace kestrel::control {

const char* NameOf(ServoState state) {
  switch (state) {
    case ServoState::kRegular:
      return "regular";
    case ServoState::kSingular:
      return "singular";
    case ServoState::kNoFeatures:
      return "no features";
    case ServoState::kDepthNotPositive:
      return "depth not positive";
    case ServoState::kNotFinite:
      return "not finite";
  }
  return "";
}

ServoStep ServoVelocity(const Eigen::MatrixXd& L, const Eigen::VectorXd& e, double lambda_per_s,
                        const Inversion& inversion) {
  assert(L.rows() == e.size());
  ServoStep step;
  step.velocity = Eigen::VectorXd::Zero(L.cols());
  if (L.rows() == 0 || L.cols() == 0) return step;
  step.state = ServoState::kNotFinite;
  if (!L.allFinite() || !e.allFinite() || !std::isfinite(lambda_per_s)) return step;

  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(L, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& s = svd.singularValues();
  const double largest = s[0];
  Eigen::VectorXd along = svd.matrixU().transpose() * e;
  double seen = 0;
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    if (!(largest > 0) || s[i] <= inversion.ratio * largest) {
      along[i] = 0;
      continue;
    }
    ++step.rank;
    seen += along[i] * along[i];
    along[i] *= s[i] / (s[i] * s[i] + std::pow(inversion.damping * largest, 2));
  }
  const Eigen::VectorXd velocity = -lambda_per_s * (svd.matrixV() * along);  // eq. (5.6)
  if (!velocity.allFinite()) return step;
  step.velocity = velocity;
  step.state = step.rank == s.size() ? ServoState::kRegular : ServoState::kSingular;
  step.conditioning = largest > 0 ? s[s.size() - 1] / largest : 0;
  const double error = e.norm();
  step.reach = error > 0 ? std::sqrt(seen) / error : 1;
  return step;
}

Twist TwistOf(const ServoStep& step) {
  assert(step.velocity.size() == 6);
  return {step.velocity.head<3>(), step.velocity.tail<3>()};
}

Eigen::MatrixXd Choose(InteractionChoice choice, const Eigen::MatrixXd& L_now,
                       const Eigen::MatrixXd& L_wanted) {
  switch (choice) {
    case InteractionChoice::kCurrent:
      return L_now;
    case InteractionChoice::kDesired:
      return L_wanted;
    case InteractionChoice::kMean:
      return (L_now + L_wanted) / 2;
  }
  return {};
}

}  // namespace kestrel::control
