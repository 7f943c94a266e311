// SPDX-License-Identifier: Apache-2.0
// A camera model of one's own: the stereographic fisheye, r = 2 f tan(theta / 2), which shows spheres as circles.
#include "mission/plugin.h"
#include "vision/camera/camera_parts.h"

namespace {

using namespace kestrel;

struct Stereographic {
  static constexpr const char* kName = "stereographic";

  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double max_angle_rad = vision::kNoLimit;

  // With a the unit ray, r = 2 sin(theta) / (1 + cos(theta)): the image of a is 2 (x, y) / (1 + z). Valid domain:
  // all but straight behind, within the angle of the lens.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ,
                                         Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                         Eigen::Matrix2Xd* d_parameters = nullptr) const {
    const double d = p_CQ.norm(), s = d + p_CQ.z();
    if (!(s > 1e-9 * d) || !vision::WithinAngle(p_CQ, max_angle_rad)) return std::nullopt;
    const Eigen::Vector2d m = 2 * p_CQ.head<2>() / s;
    if (d_point) {
      const Eigen::RowVector3d d_s = p_CQ.transpose() / d + Eigen::RowVector3d::UnitZ();
      d_point->setZero();
      d_point->leftCols<2>().diagonal().setConstant(2 / s);
      *d_point = Eigen::Vector2d(fx, fy).asDiagonal() * (*d_point - m * d_s / s).eval();
    }
    if (d_parameters) {
      d_parameters->resize(2, 4);
      *d_parameters << m.x(), 0, 1, 0, 0, m.y(), 0, 1;
    }
    return Eigen::Vector2d(fx * m.x() + cx, fy * m.y() + cy);
  }
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& uv,
                                     Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) const {
    if (!uv.allFinite()) return std::nullopt;
    const Eigen::Vector2d m((uv.x() - cx) / fx, (uv.y() - cy) / fy);
    const double r2 = m.squaredNorm();
    const Eigen::Vector3d ray(4 * m.x() / (4 + r2), 4 * m.y() / (4 + r2), (4 - r2) / (4 + r2));
    if (!vision::WithinAngle(ray, max_angle_rad)) return std::nullopt;
    if (d_pixel) {
      Eigen::Matrix<double, 2, 3> d_point;
      if (!Project(ray, &d_point)) return std::nullopt;
      *d_pixel = vision::RayJacobian(ray, d_point);
    }
    return ray;
  }
  double MaxAngle() const { return std::min(max_angle_rad, M_PI); }

  std::vector<std::string> ParameterNames() const { return {"fx", "fy", "cx", "cy"}; }
  Eigen::VectorXd Parameters() const { return Eigen::Vector4d(fx, fy, cx, cy); }
  void SetParameters(const Eigen::VectorXd& all) { fx = all[0], fy = all[1], cx = all[2], cy = all[3]; }
};

void Fields(FieldVisitor& v, Stereographic& c) {
  vision::ImageFields(v, c);
  vision::LensFields(v, c);
}

}  // namespace

KESTREL_PLUGIN { kestrel::vision::AddCameraModel<Stereographic>(); }
