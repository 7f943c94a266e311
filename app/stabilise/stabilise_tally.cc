// SPDX-License-Identifier: Apache-2.0
#include "app/stabilise/stabilise_tally.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/tait_bryan.h"
#include "vision/enhance/motion/point_flow.h"
#include "vision/enhance/stabilisation/view_warp.h"

namespace kestrel::app {
namespace {

// How far an image's horizon is turned, clockwise. None: the camera looks so far up or down that it has no side.
std::optional<double> Tilt_deg(const Eigen::Vector3d& down) {
  constexpr double kSideways = 0.1;
  if (std::hypot(down.x(), down.y()) < kSideways) return std::nullopt;
  return Degrees(std::atan2(-down.x(), down.y()));
}

// How the view shows the middle of the image.
std::string Path(const vision::StabilisedImage& image, const vision::CameraModel* camera,
                 const cv::Size& size) {
  constexpr double kStep_px = 10;
  const Eigen::Vector2d middle((size.width - 1) / 2.0, (size.height - 1) / 2.0);
  const auto at = vision::ShownAt(image.view, camera, middle),
             right = vision::ShownAt(image.view, camera, middle + Eigen::Vector2d(kStep_px, 0));
  if (!at || !right) return ",,,";
  const Eigen::Vector2d along = *right - *at,
                        shift = *at - Eigen::Vector2d((image.view.size.width - 1) / 2.0,
                                                      (image.view.size.height - 1) / 2.0);
  return fmt::format("{:.3f},{:.3f},{:.4f},{:.5f}", shift.x(), shift.y(),
                     Degrees(std::atan2(along.y(), along.x())), along.norm() / kStep_px);
}

}  // namespace

void StabiliseTally::Add(const vision::StabilisedImage& image, const ImageBefore& before) {
  ++states_[vision::NameOf(image.state)], ++images_, ms_ += before.ms;
  csv_ += fmt::format("{},{:.9f},{},{},{},{:.3f},{:.4f},{},{:.2f},{},{},", before.number, image.t_s,
                      vision::NameOf(image.state), image.points, image.inliers, image.rms_px, image.strength,
                      Path(image, camera_, before.drawn.size()), before.ms, vision::FlowDevice(opencl_),
                      before.interlaced ? 1 : 0);
  std::optional<double> in, out;
  if (before.down_C && image.view.turned) {
    const Eigen::Quaterniond R_NC = vision::AttitudeOfRow(image.view.R_NC_rows, 3, 1);
    in = Tilt_deg(*before.down_C);
    out = Tilt_deg(image.view.R_NV.conjugate() * (R_NC * *before.down_C));
  }
  if (!in || !out) {
    csv_ += ",\n";
    return;
  }
  csv_ += fmt::format("{:.3f},{:.3f}\n", *in, *out);
  ++levelled_, drawn_back_ += image.strength < 1, square_in_deg2_ += *in * *in, square_deg2_ += *out * *out;
  worst_deg_ = std::max(worst_deg_, std::abs(*out));
}

void StabiliseTally::AddLeftOut(const ImageBefore& before) {
  ++states_[vision::NameOf(*before.left_out)], ++left_out_;
  csv_ += fmt::format("{},{:.9f},{},0,0,,,,,,,,,,,\n", before.number, before.t_s,
                      vision::NameOf(*before.left_out));
}

bool StabiliseTally::Achieved() const {
  using State = vision::StabilisedState;
  bool measured = false;
  for (const State state :
       {State::kFollowed, State::kRecovered, State::kReanchored, State::kGyro, State::kGyroAlone})
    measured |= states_.contains(vision::NameOf(state));
  return measured && (levelled_ > 0 || !level_);
}

std::vector<std::string> StabiliseTally::Sentences() const {
  if (images_ == 0) return {"no image came"};
  std::string counts;
  for (const auto& [name, count] : states_)
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, name);
  std::vector<std::string> sentences = {fmt::format("{} image{}: {}; {:.1f} ms each", images_ + left_out_,
                                                    images_ + left_out_ == 1 ? "" : "s", counts,
                                                    ms_ / images_)};
  if (opencl_) sentences.push_back("points were followed on " + vision::FlowDevice(true));
  if (images_ == 1)
    sentences.push_back("one image, which has no motion; valid: a video, or a folder of images");
  using State = vision::StabilisedState;
  for (const auto& [state, remedy] :
       {std::pair{State::kTextureless,
                  "too little is seen, and the view goes along with the image; a gyro (--by both) tells the "
                  "rotation there too"},
        std::pair{State::kCut, "nothing of the image before is found again, and the view begins anew"},
        std::pair{State::kResized,
                  "the size is another one, where the view begins anew, and a video that is written ends"},
        std::pair{State::kUnreadable, "the file is damaged, and left out of the video; write it again"},
        std::pair{State::kNoAttitude,
                  "--imu has nothing of their time; valid: a file that covers the video, or --by vision"}})
    if (const auto found = states_.find(vision::NameOf(state)); found != states_.end())
      sentences.push_back(fmt::format("{} {}: {}", found->second, found->first, remedy));
  if (level_ && levelled_ == 0)
    sentences.push_back(
        "horizon seen in none of the images, and nothing is levelled; --level skyline needs ground and sky "
        "in view, "
        "and --mount-yaw-deg, --mount-pitch-deg, --mount-roll-deg as the camera is mounted");
  if (levelled_ > 0)
    sentences.push_back(fmt::format(
        "horizon seen in {} of {} images: its tilt is {:.2f} deg (RMS) as they came in, and {:.2f} deg, "
        "at most {:.2f} deg, in the view{}",
        levelled_, images_, std::sqrt(square_in_deg2_ / levelled_), std::sqrt(square_deg2_ / levelled_),
        worst_deg_,
        drawn_back_ == 0 ? ""
                         : fmt::format("; in {} of them the view was drawn back, which a smaller "
                                       "--crop or --unbounded spares it",
                                       drawn_back_)));
  return sentences;
}

}  // namespace kestrel::app
