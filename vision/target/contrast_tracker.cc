// SPDX-License-Identifier: Apache-2.0
#include "vision/target/contrast_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {

namespace {

constexpr std::size_t kMinForPath = 4;  // sightings; fewer give no rate
constexpr double kMinSpan = 0.25;       // of the window, that a rate needs
constexpr double kSizeSigmas = 4;       // of the diameters, that a change of size may be noise

ContrastState StateOf(SkySearchState state) {
  switch (state) {
    case SkySearchState::kSearched:
      return ContrastState::kSearching;
    case SkySearchState::kNoSky:
      return ContrastState::kNoSky;
    case SkySearchState::kTooDark:
      return ContrastState::kTooDark;
    case SkySearchState::kWhiteOut:
      return ContrastState::kWhiteOut;
    case SkySearchState::kBadImage:
      return ContrastState::kBadImage;
  }
  return ContrastState::kBadImage;
}

}  // namespace

const char* NameOf(ContrastState state) {
  switch (state) {
    case ContrastState::kSearching:
      return "searching";
    case ContrastState::kTentative:
      return "tentative";
    case ContrastState::kConfirmed:
      return "confirmed";
    case ContrastState::kLost:
      return "lost";
    case ContrastState::kNoSky:
      return "no sky";
    case ContrastState::kTooDark:
      return "too dark";
    case ContrastState::kWhiteOut:
      return "white out";
    case ContrastState::kBadImage:
      return "bad image";
  }
  return "";
}

ContrastTracker::ContrastTracker(const CameraModel& camera, const cv::Mat& forbidden,
                                 const ContrastTrackerOptions& options)
    : detector_(camera, forbidden, options.detector), options_(options) {}

ContrastTracker::Path ContrastTracker::PathOf(const Track_& track, double t_s) const {
  const Sighting& last = track.history.back();
  Path path{last.bearing_N, Eigen::Vector3d::Zero(), 0};
  std::size_t first = track.history.size();
  while (first > 0 && track.history[first - 1].t_s >= last.t_s - options_.window_s) --first;
  const std::size_t n = track.history.size() - first;
  if (n < kMinForPath || last.t_s - track.history[first].t_s < kMinSpan * options_.window_s) return path;
  // A straight line through what is seen, in the plane that touches the sphere at the last bearing.
  const auto count = static_cast<double>(n);
  double mean_t = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = first; i < track.history.size(); ++i)
    mean_t += track.history[i].t_s / count, mean += track.history[i].bearing_N / count;
  double tt = 0;
  Eigen::Vector3d tb = Eigen::Vector3d::Zero();
  for (std::size_t i = first; i < track.history.size(); ++i) {
    const double t = track.history[i].t_s - mean_t;
    tt += t * t, tb += t * (track.history[i].bearing_N - mean);
  }
  if (!(tt > 0)) return path;
  Eigen::Vector3d rate = tb / tt;
  rate -= rate.dot(last.bearing_N) * last.bearing_N;
  double square = 0;
  for (std::size_t i = first; i < track.history.size(); ++i) {
    const Eigen::Vector3d e = track.history[i].bearing_N - mean - (track.history[i].t_s - mean_t) * rate;
    square += (e - e.dot(last.bearing_N) * last.bearing_N).squaredNorm();
  }
  path.residual = std::sqrt(square / count);
  path.rate_N = rate;
  path.bearing_N = (mean + (t_s - mean_t) * rate).normalized();
  return path;
}

std::optional<ContrastGrowth> ContrastTracker::GrowthOf(const Track_& track) const {
  // On a straight course towards us the distance, so 1 / half_angle, is a line over time: y = a + b t, t = 0
  // now; the rate is -b / a. Weighted least squares.
  const double last_s = track.history.back().t_s;
  double s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0, first_s = last_s;
  int n = 0;
  const auto each = [&](const auto& use) {
    for (const Sighting& s : track.history)
      if (s.t_s >= last_s - options_.window_s) {
        const double y = 1 / s.half_angle, sigma = s.half_angle_sigma * y * y;
        use(s.t_s - last_s, y, 1 / (sigma * sigma));
      }
  };
  each([&](double t, double y, double w) {
    s0 += w, s1 += w * t, s2 += w * t * t, y0 += w * y, y1 += w * t * y, ++n;
    first_s = std::min(first_s, last_s + t);
  });
  const double determinant = s0 * s2 - s1 * s1;
  if (n < static_cast<int>(kMinForPath) || last_s - first_s < kMinSpan * options_.window_s ||
      !(determinant > 0))
    return std::nullopt;
  const double a = (s2 * y0 - s1 * y1) / determinant, b = (s0 * y1 - s1 * y0) / determinant;
  if (!(a > 0)) return std::nullopt;
  double chi2 = 0;
  each([&](double t, double y, double w) { chi2 += w * (y - a - b * t) * (y - a - b * t); });
  // By the scatter that there is, where it is more than the sightings' own sigmas say.
  const double scatter = std::max(1.0, chi2 / (n - 2));
  const double aa = s2 / determinant, bb = s0 / determinant, ab = -s1 / determinant;
  const double rate = -b / a;
  const double variance = scatter * (bb + rate * rate * aa + 2 * rate * ab) / (a * a);
  return ContrastGrowth{rate, std::sqrt(std::max(0.0, variance)), n};
}

double ContrastTracker::Distance(const Track_& track, const Sighting& s) const {
  constexpr double kNone = 2;
  const Sighting& last = track.history.back();
  const double factor = std::abs(std::log(s.half_angle / last.half_angle));
  const double noise = std::hypot(s.half_angle_sigma / s.half_angle, last.half_angle_sigma / last.half_angle);
  const double dt = s.t_s - last.t_s;
  if (factor > std::log(options_.size_factor) + kSizeSigmas * noise) return kNone;
  const Path path = PathOf(track, s.t_s);
  double gate = Radians(options_.gate_deg) + 0.5 * last.half_angle;
  if (path.rate_N.isZero() && !track.confirmed) gate += Radians(options_.max_rate_deg_s) * dt;
  // A path grows uncertain while its target is not seen.
  if (track.confirmed) gate *= 1 + std::min(2.0, dt / std::max(0.1, options_.forget_s));
  return (path.bearing_N - s.bearing_N).norm() / gate;
}

void ContrastTracker::Update(Track_& track, const std::optional<Sighting>& sighting) {
  track.seen.push_back(sighting.has_value());
  while (static_cast<int>(track.seen.size()) > options_.confirm_images) track.seen.pop_front();
  if (!sighting) return;
  track.history.push_back(*sighting);
  while (track.history.front().t_s < sighting->t_s - 2 * options_.window_s) track.history.pop_front();
  ++track.sightings;
  if (!track.confirmed &&
      std::count(track.seen.begin(), track.seen.end(), true) >= options_.confirm_sightings &&
      PathOf(track, sighting->t_s).residual <= Radians(options_.steady_deg))
    track.confirmed = true;
}

ContrastObservation ContrastTracker::Track(const cv::Mat& image, const Eigen::Matrix3d& R_NC, double t_s) {
  ContrastObservation observation;
  observation.state = ContrastState::kBadImage;
  const bool rotation = (R_NC.transpose() * R_NC - Eigen::Matrix3d::Identity()).norm() < 1e-3;
  const bool later = std::isfinite(t_s) && (!last_s_ || t_s > *last_s_);
  SkySearch search;
  if (rotation && later) {
    const Eigen::Vector3d down_C = R_NC.row(2).transpose().normalized();
    std::vector<OutlineCone> expected;
    for (const Track_& track : tracks_)
      if (track.confirmed)
        expected.push_back(
            {R_NC.transpose() * PathOf(track, t_s).bearing_N, track.history.back().half_angle});
    search = detector_.Search(image, down_C, Radians(options_.down_sigma_deg), expected);
    observation.state = StateOf(search.state);
    last_s_ = t_s;
  }

  std::vector<Sighting> sightings;
  for (const ContrastDetection& d : search.detections)
    sightings.push_back(
        {t_s, (R_NC * d.cone.axis).normalized(), d.cone.half_angle, d.half_angle_sigma, d.contrast});
  // The nearest pairs of track and sighting first; confirmed tracks before all others.
  struct Pair {
    std::size_t track, sighting;
    double distance;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    for (std::size_t j = 0; j < sightings.size(); ++j) {
      const double distance = Distance(tracks_[i], sightings[j]);
      if (distance <= 1) pairs.push_back({i, j, distance + (tracks_[i].confirmed ? 0 : 1)});
    }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  constexpr std::size_t kFree = static_cast<std::size_t>(-1);
  std::vector<std::size_t> of_track(tracks_.size(), kFree), of_sighting(sightings.size(), kFree);
  for (const Pair& p : pairs)
    if (of_track[p.track] == kFree && of_sighting[p.sighting] == kFree)
      of_track[p.track] = p.sighting, of_sighting[p.sighting] = p.track;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    Update(tracks_[i], of_track[i] == kFree ? std::nullopt : std::optional(sightings[of_track[i]]));
  for (std::size_t j = 0; j < sightings.size(); ++j) {
    if (of_sighting[j] != kFree || static_cast<int>(tracks_.size()) >= options_.max_tracks) continue;
    Track_ track;
    track.id = next_id_++;
    track.begun_s = t_s;
    Update(track, sightings[j]);
    of_sighting[j] = tracks_.size();
    tracks_.push_back(std::move(track));
  }

  for (std::size_t j = 0; j < sightings.size(); ++j) {
    if (of_sighting[j] == kFree) continue;
    const Track_& track = tracks_[of_sighting[j]];
    ContrastTarget target{track.id,
                          track.confirmed,
                          t_s - track.begun_s,
                          track.sightings,
                          search.detections[j],
                          sightings[j].bearing_N,
                          PathOf(track, t_s).rate_N,
                          GrowthOf(track)};
    observation.targets.push_back(std::move(target));
  }
  std::stable_sort(observation.targets.begin(), observation.targets.end(),
                   [](const ContrastTarget& a, const ContrastTarget& b) {
                     if (a.confirmed != b.confirmed) return a.confirmed;
                     return a.seen.cone.half_angle > b.seen.cone.half_angle;
                   });
  const int most_misses = options_.confirm_images - options_.confirm_sightings;
  std::erase_if(tracks_, [&](const Track_& track) {
    if (track.confirmed) return track.history.back().t_s < t_s - options_.forget_s;
    return std::count(track.seen.begin(), track.seen.end(), false) > most_misses;
  });
  for (const Track_& track : tracks_)
    if (track.confirmed && track.history.back().t_s < t_s) observation.lost.push_back(track.id);
  if (observation.state == ContrastState::kSearching) {
    if (observation.Confirmed())
      observation.state = ContrastState::kConfirmed;
    else if (!observation.lost.empty())
      observation.state = ContrastState::kLost;
    else if (!observation.targets.empty())
      observation.state = ContrastState::kTentative;
  }
  return observation;
}

}  // namespace kestrel::vision
