// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hover_direct/photometric_sight.h"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::scenarios {
namespace {

cv::Mat ToCv(const Eigen::Matrix3d& H) {
  cv::Mat m(3, 3, CV_64F);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m.at<double>(i, j) = H(i, j);
  return m;
}

// The pad as that camera would see it; of white: where it would see the pad.
cv::Mat Drawn(const vision::PadReference& pad, const vision::Pinhole& camera, const Pose& X_DT, bool white) {
  const Eigen::Matrix3d H_w = vision::HomographyFromPose(X_DT, camera);
  const vision::PadReference::Level& level = pad.LevelFor(camera.fx / X_DT.p.z());
  const cv::Mat source = white ? cv::Mat(level.image.size(), CV_8U, cv::Scalar(255)) : level.image;
  cv::Mat drawn;
  cv::warpPerspective(source, drawn, ToCv(H_w * level.pixel_from_T.inverse()),
                      {camera.width_px, camera.height_px}, cv::INTER_LINEAR);
  return drawn;
}

cv::Mat Mask(const vision::PadReference& pad, const vision::Pinhole& camera, const Pose& X_DT,
             double blur_px) {
  cv::Mat mask = Drawn(pad, camera, X_DT, true);
  cv::threshold(mask, mask, 254, 255, cv::THRESH_BINARY);
  // Around the pad lies what is not known, and the blur carries it in.
  const int rim = 2 * static_cast<int>(std::ceil(2 * blur_px)) + 3;
  cv::erode(mask, mask, cv::Mat::ones(rim, rim, CV_8U), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  return mask;
}

}  // namespace

PhotometricSight::PhotometricSight(const vision::PadReference& pad, const vision::Pinhole& camera,
                                   const Pose& X_DT, double blur_px)
    : camera_(camera),
      wanted_(Drawn(pad, camera, X_DT, false)),
      mask_(Mask(pad, camera, X_DT, blur_px)),
      offset_(wanted_, mask_, camera, X_DT.p.z(), blur_px) {}

std::optional<vision::PhotometricFix> PhotometricSight::Compare(const cv::Mat& grey,
                                                                const Eigen::Quaterniond& R_VC) const {
  const Eigen::Matrix3d K = camera_.K();
  const cv::Mat H = ToCv(K * R_VC.toRotationMatrix() * K.inverse());
  cv::Mat level, shown;
  cv::warpPerspective(grey, level, H, grey.size(), cv::INTER_LINEAR);
  cv::warpPerspective(cv::Mat(grey.size(), CV_8U, cv::Scalar(255)), shown, H, grey.size(), cv::INTER_NEAREST);
  return offset_.Compare(level, shown);
}

}  // namespace kestrel::scenarios
