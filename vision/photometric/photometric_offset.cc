// SPDX-License-Identifier: Apache-2.0
#include "vision/photometric/photometric_offset.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace kestrel::vision {
namespace {

constexpr double kLeastShare = 0.5;  // of the pixels that count
constexpr double kCentral = 0.5;     // of a difference over two pixels

cv::Mat Smooth(const cv::Mat& image, double blur_px) {
  cv::Mat smooth;
  image.convertTo(smooth, CV_32F);
  if (blur_px > 0) cv::GaussianBlur(smooth, smooth, {}, blur_px);
  return smooth;
}

void Gradients(const cv::Mat& image, cv::Mat& du, cv::Mat& dv) {
  const cv::Mat central = (cv::Mat_<float>(1, 3) << -kCentral, 0, kCentral);
  cv::filter2D(image, du, CV_32F, central);
  cv::filter2D(image, dv, CV_32F, central.t());
}

}  // namespace

PhotometricOffset::PhotometricOffset(const cv::Mat& wanted, const cv::Mat& mask, const Pinhole& camera,
                                     double depth_m, double blur_px)
    : camera_(camera), depth_m_(depth_m), blur_px_(blur_px), wanted_(Smooth(wanted, blur_px)), mask_(mask) {
  Gradients(wanted_, du_, dv_);
  pixels_ = cv::countNonZero(mask_);
  if (pixels_ == 0) throw std::invalid_argument("no pixel of the wanted image counts");
}

std::optional<PhotometricFix> PhotometricOffset::Compare(const cv::Mat& image, const cv::Mat& shown) const {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const cv::Mat now = Smooth(image, blur_px_);
  cv::Mat du, dv;
  Gradients(now, du, dv);
  // In another light its gradients are others too: those that are wanted are brought to its contrast.
  cv::Scalar mean, spread, spread_wanted;
  cv::meanStdDev(now, mean, spread, mask_ & shown);
  cv::meanStdDev(wanted_, mean, spread_wanted, mask_ & shown);
  const double contrast = spread_wanted[0] > 0 ? spread[0] / spread_wanted[0] : 1;
  Matrix6 A = Matrix6::Zero();  // of (p, yaw, gain, offset)
  Vector6 b = Vector6::Zero();
  double squares = 0;
  int pixels = 0;
  for (int v = 0; v < now.rows; ++v) {
    const double y = (v - camera_.cy) / camera_.fy;
    for (int u = 0; u < now.cols; ++u) {
      if (mask_.at<uchar>(v, u) == 0 || shown.at<uchar>(v, u) == 0) continue;
      ++pixels;
      const double x = (u - camera_.cx) / camera_.fx;
      const double gx = camera_.fx * (du.at<float>(v, u) + contrast * du_.at<float>(v, u)) / 2;
      const double gy = camera_.fy * (dv.at<float>(v, u) + contrast * dv_.at<float>(v, u)) / 2;
      // -grad I^T L_x with the columns v_x, v_y, v_z and w_z of eq. (5.5)
      const double wanted = wanted_.at<float>(v, u);
      Vector6 row;
      row << gx / depth_m_, gy / depth_m_, -(gx * x + gy * y) / depth_m_, -(gx * y - gy * x), wanted, 1;
      const double i = now.at<float>(v, u);
      A.selfadjointView<Eigen::Lower>().rankUpdate(row);
      b += i * row;
      squares += i * i;
    }
  }
  if (pixels < kLeastShare * pixels_) return std::nullopt;
  const Eigen::LDLT<Matrix6> solver(A.selfadjointView<Eigen::Lower>());
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-9 * solver.vectorD().maxCoeff()))
    return std::nullopt;
  const Vector6 x = solver.solve(b);
  if (!x.allFinite()) return std::nullopt;
  PhotometricFix fix;
  fix.p_V = x.head<3>();
  fix.yaw = x[3];
  fix.gain = x[4];
  fix.residual_grey = std::sqrt(std::max(0.0, squares - x.dot(b)) / pixels);
  return fix;
}

}  // namespace kestrel::vision
