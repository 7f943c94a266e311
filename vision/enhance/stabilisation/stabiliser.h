// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "vision/camera/camera_model.h"
#include "vision/enhance/motion/image_motion.h"
#include "vision/enhance/stabilisation/stabiliser_options.h"
#include "vision/enhance/stabilisation/view_warp.h"

// Video whose view stands still, or goes smoothly, thesis 4.2. The thesis multiplies the homographies between images
// back to the first one, which drifts; here a reference is followed by keyframes, each of which many images are
// registered to.
namespace kestrel::vision {

enum class StabilisedState {
  kFirst,        // of the video, or after a cut
  kFollowed,     // its motion is measured
  kRecovered,    // it is measured by a search, after a jump
  kTextureless,  // too little to be seen: taken to stand still, until there is more
  kCut,          // nothing of the image before is in it: a new beginning
  kResized,      // its size is another one: a new beginning
  kReanchored,   // the reference had left the view: this is the new one
  kGyro,         // by attitudes alone, as asked for
  kGyroAlone,    // by attitudes, since it shows too little for vision
  kNoAttitude,   // attitudes are asked for, and of this time there are none: as if it stood still
};
const char* NameOf(StabilisedState state);

// What is known of an image beside its pixels.
struct ImageAttitudes {
  // R_NC while the rows were exposed, at even times from the first row to the last; one: of all rows; empty: not
  // known. N is any frame that does not turn.
  std::vector<Eigen::Quaterniond> R_NC_rows;
  std::optional<Eigen::Vector3d> down_C;  // unit vector, as the skyline shows it
};

struct StabilisedImage {
  cv::Mat image;  // of the input's channels
  double t_s = 0;
  std::int64_t number = 0;  // of the image, from 0
  StabilisedState state = StabilisedState::kFirst;
  int points = 0, inliers = 0;
  double rms_px = 0;      // of the inliers
  double strength = 1;    // 1: as the path asks for; less: drawn back to the image, so that the view stays within it
  ImageView view;         // where its pixels come from
};

class Stabiliser {
 public:
  // camera: without one, by vision in pixels. rate_hz: of the images, about. Throws std::invalid_argument where the
  // options need a camera that is not given.
  Stabiliser(const StabiliserOptions& options, const std::optional<CameraModel>& camera, double rate_hz);
  ~Stabiliser();
  Stabiliser(Stabiliser&&) noexcept;
  Stabiliser& operator=(Stabiliser&&) noexcept;

  // Takes the next image (CV_8UC1 or CV_8UC3), and gives the one that is due: of mode reference this one, of the
  // others the one that is Lag() images older. None: not so many have come yet.
  std::optional<StabilisedImage> Step(const cv::Mat& image, double t_s, const ImageAttitudes& attitudes = {});
  // After the last image the rest of them, one by one. None: that was all.
  std::optional<StabilisedImage> Finish();

  int Lag() const;  // images
  // The pairs of points that the last Step() found to agree, from the image that it was compared with.
  const std::vector<PointPair>& last_inliers() const;

 private:
  class Path;
  std::unique_ptr<Path> path_;
};

}  // namespace kestrel::vision
