// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "base/yaml/fields.h"
#include "control/estimate/state_history.h"
#include "mission/caption/caption.h"
#include "mission/mosaic/mosaic_report.h"
#include "vision/camera.h"
#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::mission {

struct MosaicParameters {
  bool poses = true;
  double pose_sigma_m = 1, pose_sigma_deg = 1;
  bool chain = false;
  int memory_mb = 1000;
};

inline void Fields(FieldVisitor& v, MosaicParameters& p) {
  v({"poses", "lay the mosaic out by the autopilot's poses, north up"}, p.poses);
  v({"pose_sigma_m", "standard deviation of the autopilot's position from image to image"}, p.pose_sigma_m,
    0.01, 100.0);
  v({"pose_sigma_deg", "the same of its attitude"}, p.pose_sigma_deg, 0.01, 90.0);
  v({"chain", "also chain the same images without closing loops, as the thesis does, to compare"}, p.chain);
  v({"memory_mb", "maximum memory of the images that are kept and of the mosaic, megabytes"}, p.memory_mb, 16,
    100000);
}

// A mosaic that grows in flight: images as they come, the poses that the autopilot says of them, and what people
// look at.
class MosaicObserver {
 public:
  // options: model and surface. X_BC: the camera on the aircraft. images: so many are expected, for captions.
  MosaicObserver(vision::MosaicOptions options, const MosaicParameters& parameters,
                 const vision::CameraModel& camera, const Pose& X_BC, int images);

  // Each frame's state, so that an image meets that of its own exposure.
  void Note(const control::VehicleState& state) { history_.Add(state); }
  // Adds an image; fills the decision's target and time spent.
  vision::MosaicStep Add(const vision::Frame& frame, Decision& decision);
  // All adjusted anew.
  std::shared_ptr<const FinishedMosaic> Finish();

  int offered() const { return static_cast<int>(sequences_.size()); }
  int placed() const { return placed_; }
  void Fill(MosaicReport& report) const;  // what is counted

  std::vector<Caption> Captions() const;
  cv::Mat ProductImage() const;  // as mission::Mission's
  // mosaic.png; mosaic_growth.png, its stills at every hundredth image; of the ground with poses mosaic.tif, a
  // GeoTIFF, where this build can write one.
  void WriteProducts(const std::filesystem::path& folder) const;

 private:
  std::optional<Pose> PoseOf(const vision::Frame& frame) const;

  MosaicParameters parameters_;
  Pose X_BC_;
  int images_;
  vision::Mosaic mosaic_;
  std::optional<vision::Mosaic> chain_;
  control::StateHistory history_;
  std::vector<std::int64_t> sequences_;
  int placed_ = 0;
  std::optional<vision::MosaicStep> last_;
  cv::Mat last_image_;
  std::vector<cv::Mat> stills_;
  mutable cv::Mat shown_;  // of the video; drawn anew where there is a new image
  mutable int shown_of_ = 0;
};

// The files that it may leave.
std::vector<std::string> MosaicProducts();

}  // namespace kestrel::mission
