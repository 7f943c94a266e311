// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/target/contrast_detector.h"

namespace kestrel::vision {

struct ContrastTrackerOptions {
  ContrastDetectorOptions detector;
  double down_sigma_deg = 1;
  int confirm_sightings = 6;
  int confirm_images = 8;
  double gate_deg = 1;
  double max_rate_deg_s = 40;
  double steady_deg = 0.4;
  double size_factor = 1.7;
  double window_s = 1;
  double forget_s = 2;
  int max_tracks = 24;
};

inline void Fields(FieldVisitor& v, ContrastTrackerOptions& o) {
  v({"detector", "detection of things against the sky in each image"}, o.detector);
  v({"down_sigma_deg", "standard deviation of the attitude that comes with each image"}, o.down_sigma_deg,
    0.0, 20.0);
  v({"confirm_sightings", "number of sightings within confirm_images that confirms a target"},
    o.confirm_sightings, 1, 1000);
  v({"confirm_images", "number of latest images in which the sightings of a target are counted"},
    o.confirm_images, 1, 1000);
  v({"gate_deg", "maximum angle between a sighting and where its target is predicted"}, o.gate_deg, 0.01,
    30.0);
  v(Renamed("max_rate_deg_s", "most_rate_deg_s",
            "maximum bearing rate of a target whose path is not known yet"),
    o.max_rate_deg_s, 0.0, 1000.0);
  v({"steady_deg",
     "maximum rms deviation of the sightings from a straight path with which a target is confirmed"},
    o.steady_deg, 0.01, 30.0);
  v({"size_factor", "maximum ratio of the diameters of a sighting and the last one"}, o.size_factor, 1.0,
    100.0);
  v({"window_s", "time window of the sightings that path and growth are fitted to"}, o.window_s, 0.1, 20.0);
  v({"forget_s", "time without a sighting after which a confirmed target is forgotten"}, o.forget_s, 0.0,
    100.0);
  v(Renamed("max_tracks", "most_tracks",
            "maximum number of tracks at a time, tentative ones included; bounds the computing time"),
    o.max_tracks, 1, 1000);
}

enum class ContrastState {
  kSearching,  // nothing that could be a target
  kTentative,  // sightings that are not confirmed yet, in this image
  kConfirmed,  // at least one confirmed target is seen in this image
  kLost,       // one was, lately, and is not seen in this image; there may be tentative ones
  kNoSky,      // as in SkySearchState, as all that follows: nothing was looked for
  kTooDark,
  kWhiteOut,
  kBadImage,  // or its attitude is none, or its time is not after the last one's
};
const char* NameOf(ContrastState state);

// How fast a target's angular size grows: d(ln half_angle)/dt. On a straight course towards us 1 / rate_1_s
// is the time to contact.
struct ContrastGrowth {
  double rate_1_s = 0, sigma_1_s = 0;
  int sightings = 0;  // that it was fitted to
};

// A target seen in this very image.
struct ContrastTarget {
  int id = 0;  // the same from image to image, from 1 upwards, never used again
  bool confirmed = false;
  double age_s = 0;                                          // since its first sighting
  int sightings = 0;                                         // all together
  ContrastDetection seen;                                    // in this image; seen.cone is in C
  Eigen::Vector3d bearing_N = Eigen::Vector3d::UnitX();      // unit vector; as seen, by the attitude given
  Eigen::Vector3d bearing_rate_N = Eigen::Vector3d::Zero();  // 1/s, across bearing_N, over the window
  std::optional<ContrastGrowth> growth;  // from four sightings over a quarter of the window on
};

struct ContrastObservation {
  ContrastState state = ContrastState::kSearching;
  std::vector<ContrastTarget> targets;  // confirmed ones first, each kind by its angular size, largest first
  std::vector<int> lost;                // ids of confirmed targets that are not seen in this image
  const ContrastTarget* Confirmed() const {  // the largest confirmed one, or none
    return !targets.empty() && targets.front().confirmed ? &targets.front() : nullptr;
  }
};

// Other aircraft before the sky from image to image, several at once: what ContrastDetector finds, turned to
// N by the attitude of each image and joined to steady paths. A target is confirmed by sightings in M of the
// last N images; one image's blob never is. There is never an old place: a target without a sighting in this
// image is not among its targets. A lost one keeps its id if it is seen again, near its path and of its
// size, before it is forgotten.
class ContrastTracker {
 public:
  // forbidden: CV_8UC1 of the image's size, not 0 where the aircraft itself is seen; or empty.
  ContrastTracker(const CameraModel& camera, const cv::Mat& forbidden, const ContrastTrackerOptions& options);

  // image: CV_8UC3 (blue, green, red) or CV_8UC1 of the camera's size. R_NC: its attitude, by the autopilot.
  // t_s: the middle of its exposure; later than the last one's.
  ContrastObservation Track(const cv::Mat& image, const Eigen::Matrix3d& R_NC, double t_s);

  const ContrastDetector& detector() const { return detector_; }

 private:
  struct Sighting {
    double t_s;
    Eigen::Vector3d bearing_N;
    double half_angle, half_angle_sigma;
    double contrast;
  };
  struct Track_ {
    int id = 0;
    bool confirmed = false;
    double begun_s = 0;
    int sightings = 0;
    std::deque<bool> seen;  // in the last images, newest last
    std::deque<Sighting> history;
  };
  // Where a track's path leads at a time, and how it fits.
  struct Path {
    Eigen::Vector3d bearing_N, rate_N;
    double residual = 0;  // rad
  };
  Path PathOf(const Track_& track, double t_s) const;
  std::optional<ContrastGrowth> GrowthOf(const Track_& track) const;
  double Distance(const Track_& track, const Sighting& sighting) const;  // in gates; over 1 is none
  void Update(Track_& track, const std::optional<Sighting>& sighting);

  ContrastDetector detector_;
  ContrastTrackerOptions options_;
  std::vector<Track_> tracks_;
  int next_id_ = 1;
  std::optional<double> last_s_;
};

}  // namespace kestrel::vision
