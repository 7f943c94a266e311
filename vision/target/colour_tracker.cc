// SPDX-License-Identifier: Apache-2.0
#include "vision/target/colour_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

namespace kestrel::vision {

namespace {

constexpr double kMaxPixels = 80000;  // looked at in one image: bounds the time
constexpr double kMargin = 1;         // of the window, on each side of the last box, by its longer side
constexpr double kMinMargin_px = 24;
constexpr double kMaxFill = 1.15;                  // of its box's ellipse: a rectangle fills 1.27 of it
constexpr double kFewPixels = 12;                  // of a side: a smaller blob's fill says nothing
constexpr double kMostlyOne = 0.8;                 // of what matches: one blob, however large
constexpr double kRingFrom = 1.15, kRingTo = 1.5;  // around the target's ellipse, by its axes
constexpr double kEdge_px = 2;

// A part of the image reduced by a whole number, and the way back.
struct Reduced {
  cv::Mat bgr;
  cv::Rect part;
  int step = 1;
  double Back(double at, int from) const { return from + at * step + (step - 1) / 2.0; }
};
Reduced Reduce(const cv::Mat& bgr, const cv::Rect& part) {
  Reduced r;
  r.step = std::max(1, static_cast<int>(std::ceil(std::sqrt(part.area() / kMaxPixels))));
  r.part = {part.x, part.y, part.width / r.step * r.step, part.height / r.step * r.step};
  if (r.step == 1)
    r.bgr = bgr(r.part);
  else
    cv::resize(bgr(r.part), r.bgr, r.part.size() / r.step, 0, 0, cv::INTER_AREA);
  return r;
}

struct Edges {
  bool left = false, right = false, top = false, bottom = false;
  bool Any() const { return left || right || top || bottom; }
  bool Opposite() const { return (left && right) || (top && bottom); }
};
Edges EdgesOf(const cv::Rect2d& box, const cv::Size& image) {
  return {box.x<kEdge_px, box.br().x> image.width - kEdge_px,
          box.y<kEdge_px, box.br().y> image.height - kEdge_px};
}

// A connected area of the target's colour, in the image's pixels.
struct ColourBlob {
  cv::Rect2d box;
  double area_px = 0;
  Eigen::Vector2d Centre() const { return {box.x + (box.width - 1) / 2, box.y + (box.height - 1) / 2}; }
  double Side() const { return std::max(box.width, box.height); }
};

bool Sound(const ColourBlob& b, const cv::Size& image, const ColourTrackerOptions& o) {
  if (b.area_px < o.min_roundness * M_PI / 4 * o.min_diameter_px * o.min_diameter_px) return false;
  const Edges edges = EdgesOf(b.box, image);
  if (edges.Opposite()) return false;
  const double fill = b.area_px / (M_PI / 4 * b.box.width * b.box.height);
  const double round = std::min(b.box.width, b.box.height) / b.Side();
  if (fill < o.min_roundness || (!edges.Any() && round < o.min_roundness)) return false;
  return edges.Any() || b.Side() < kFewPixels || fill < kMaxFill;
}

std::vector<ColourBlob> SoundBlobs(const cv::Mat& weights, const Reduced& r, const cv::Size& image,
                                   const ColourTrackerOptions& o) {
  std::vector<ColourBlob> blobs;
  const cv::Mat matches = weights > 127;
  cv::Mat opened, labels, stats, centroids;
  // Without strings and other thin things first; but then nothing is left of the smallest targets.
  cv::morphologyEx(matches, opened, cv::MORPH_OPEN, cv::Mat::ones(3, 3, CV_8U));
  for (const cv::Mat& mask : {opened, matches}) {
    if (!blobs.empty()) break;
    const int count = cv::connectedComponentsWithStats(mask, labels, stats, centroids, 8, CV_32S);
    for (int i = 1; i < count; ++i) {
      const int* s = stats.ptr<int>(i);
      const ColourBlob blob{
          cv::Rect2d(r.part.x + s[cv::CC_STAT_LEFT] * r.step, r.part.y + s[cv::CC_STAT_TOP] * r.step,
                     s[cv::CC_STAT_WIDTH] * r.step, s[cv::CC_STAT_HEIGHT] * r.step),
          static_cast<double>(s[cv::CC_STAT_AREA]) * r.step * r.step};
      if (Sound(blob, image, o)) blobs.push_back(blob);
    }
  }
  std::sort(blobs.begin(), blobs.end(),
            [](const ColourBlob& a, const ColourBlob& b) { return a.area_px > b.area_px; });
  return blobs;
}

// How densely the weights fill an ellipse less how densely the ring around it, 0 to 1; and the mass inside.
double Contrast(const cv::Mat& weights, const cv::RotatedRect& ellipse, double& inside_px) {
  const double a = std::max(1.0f, ellipse.size.width / 2), b = std::max(1.0f, ellipse.size.height / 2);
  const double c = std::cos(ellipse.angle * CV_PI / 180), s = std::sin(ellipse.angle * CV_PI / 180);
  const double reach = kRingTo * std::max(a, b);
  std::array<double, 2> mass{}, pixels{};
  for (int y = std::max(0, static_cast<int>(ellipse.center.y - reach));
       y < std::min<double>(weights.rows, ellipse.center.y + reach); ++y) {
    const uchar* w = weights.ptr<uchar>(y);
    for (int x = std::max(0, static_cast<int>(ellipse.center.x - reach));
         x < std::min<double>(weights.cols, ellipse.center.x + reach); ++x) {
      const double dx = x + 0.5 - ellipse.center.x, dy = y + 0.5 - ellipse.center.y;
      const double p = (c * dx + s * dy) / a, q = (c * dy - s * dx) / b, d = p * p + q * q;
      if (d > kRingTo * kRingTo || (d > 1 && d < kRingFrom * kRingFrom)) continue;
      mass[d > 1] += w[x] / 255.0, pixels[d > 1] += 1;
    }
  }
  inside_px = mass[0];
  // What of the ring lies off the image tells nothing: a target that fills the image has none.
  const double ring = M_PI * a * b * (kRingTo * kRingTo - kRingFrom * kRingFrom);
  return mass[0] / std::max(1.0, pixels[0]) - mass[1] / std::max(1.0, ring);
}

}  // namespace

const char* NameOf(TrackState state) {
  switch (state) {
    case TrackState::kSearching:
      return "searching";
    case TrackState::kTracked:
      return "tracked";
    case TrackState::kAmbiguous:
      return "ambiguous";
    case TrackState::kTooClose:
      return "too close";
    case TrackState::kAtEdge:
      return "at the edge";
    case TrackState::kLost:
      return "lost";
    case TrackState::kMatchesTooMuch:
      return "matches too much";
    case TrackState::kBadImage:
      return "bad image";
  }
  return "?";
}

ColourTracker::ColourTracker(const ColourModel& model, const ColourTrackerOptions& options)
    : model_(model), options_(options) {}

ColourTrack ColourTracker::Track(const cv::Mat& bgr) {
  if (bgr.type() != CV_8UC3 || bgr.empty()) return {TrackState::kBadImage, {}};
  ColourTrack track;
  bool rival = false;
  if (box_) {
    const cv::Rect2d there(box_->x + step_px_.x(), box_->y + step_px_.y(), box_->width, box_->height);
    track.target = Follow(bgr, there, rival);
  }
  if (!track.target) {
    // Lost, or never seen: the whole image, and in the same one what is found there.
    const Search search = Find(bgr);
    if (search.box) track.target = Follow(bgr, *search.box, rival);
    if (!track.target) {
      box_.reset();
      step_px_.setZero();
      ++missing_frames_;
      if (missing_frames_ > options_.forget_frames) remembered_.reset();
      track.state = search.state == TrackState::kLost && !remembered_ ? TrackState::kSearching : search.state;
      return track;
    }
    box_.reset();
  }
  const cv::Rect2d& box = track.target->box;
  const Eigen::Vector2d centre(box.x + box.width / 2, box.y + box.height / 2);
  if (box_) {
    const Eigen::Vector2d last(box_->x + box_->width / 2, box_->y + box_->height / 2);
    step_px_ = 0.5 * (step_px_ + centre - last);
  }
  box_ = remembered_ = box;
  missing_frames_ = 0;
  track.state = Classify(bgr, *track.target, rival);
  return track;
}

void ColourTracker::Correct(const cv::Rect2d& box) {
  if (!(box.width > 0 && box.height > 0)) return;
  box_ = remembered_ = box;
  refused_ = 0;
}

void ColourTracker::Refuse() {
  box_.reset(), remembered_.reset();
  step_px_.setZero();
  ++refused_;
}

ColourTracker::Search ColourTracker::Find(const cv::Mat& bgr) {
  window_ = {0, 0, bgr.cols, bgr.rows};
  const Reduced r = Reduce(bgr, window_);
  cv::Mat weights;
  model_.BackProject(r.bgr, weights);
  std::vector<ColourBlob> blobs = SoundBlobs(weights, r, bgr.size(), options_);
  const double matched = ColourModel::Matched(weights) * static_cast<double>(r.part.area());
  if (matched > options_.max_matched * static_cast<double>(r.part.area()) &&
      (blobs.empty() || blobs.front().area_px < kMostlyOne * matched)) {
    return {TrackState::kMatchesTooMuch, {}};
  }
  if (remembered_ && !EdgesOf(*remembered_, bgr.size()).Any()) {
    const double side = std::max(remembered_->width, remembered_->height), f = options_.return_factor;
    std::erase_if(blobs, [&](const ColourBlob& b) { return b.Side() > f * side || f * b.Side() < side; });
  }
  if (refused_ >= blobs.size()) refused_ = 0;
  blobs.erase(blobs.begin(), blobs.begin() + static_cast<std::ptrdiff_t>(refused_));
  if (blobs.empty()) return {};
  if (blobs.size() > 1 && blobs[1].area_px > options_.rival_share * blobs[0].area_px) {
    if (!remembered_) return {TrackState::kAmbiguous, {}};
    // One of them, if it alone is where the target was.
    const Eigen::Vector2d last(remembered_->x + remembered_->width / 2,
                               remembered_->y + remembered_->height / 2);
    std::erase_if(blobs, [&](const ColourBlob& b) {
      return (b.Centre() - last).norm() > 2 * std::max(remembered_->width, remembered_->height);
    });
    if (blobs.size() != 1) return {TrackState::kAmbiguous, {}};
  }
  return {TrackState::kTracked, blobs.front().box};
}

std::optional<ColourTarget> ColourTracker::Follow(const cv::Mat& bgr, const cv::Rect2d& box, bool& rival) {
  const cv::Rect image(0, 0, bgr.cols, bgr.rows);
  const double margin = std::max(kMinMargin_px, kMargin * std::max(box.width, box.height));
  // In double: a box may have left the image by far.
  const cv::Rect2d wide =
      cv::Rect2d(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
      cv::Rect2d(image);
  window_ = cv::Rect(wide) & image;
  if (window_.width < options_.min_diameter_px || window_.height < options_.min_diameter_px) return {};
  const Reduced r = Reduce(bgr, window_);
  cv::Mat weights;
  model_.BackProject(r.bgr, weights);
  const cv::Rect2d start((box.x - r.part.x) / r.step, (box.y - r.part.y) / r.step, box.width / r.step,
                         box.height / r.step);
  cv::Rect window = cv::Rect(start) & cv::Rect(0, 0, weights.cols, weights.rows);
  if (window.width < 2 || window.height < 2) return {};
  const cv::RotatedRect ellipse =
      cv::CamShift(weights, window, cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 10, 1));
  if (!(ellipse.size.width > 0 && ellipse.size.height > 0)) return {};

  ColourTarget target;
  target.centre = {r.Back(ellipse.center.x - 0.5, r.part.x), r.Back(ellipse.center.y - 0.5, r.part.y)};
  target.diameter_px = (ellipse.size.width + ellipse.size.height) / 2 * r.step;
  if (target.diameter_px < options_.min_diameter_px) return {};
  double inside_px = 0;
  target.confidence = std::clamp(Contrast(weights, ellipse, inside_px), 0.0, 1.0);
  if (target.confidence < options_.min_confidence) return {};
  // The box of the ellipse itself: RotatedRect's own is that of its corners.
  const double c = std::cos(ellipse.angle * CV_PI / 180), s = std::sin(ellipse.angle * CV_PI / 180);
  const double w = std::hypot(c * ellipse.size.width, s * ellipse.size.height) * r.step;
  const double h = std::hypot(s * ellipse.size.width, c * ellipse.size.height) * r.step;
  target.box =
      cv::Rect2d(target.centre.x() + 0.5 - w / 2, target.centre.y() + 0.5 - h / 2, w, h) & cv::Rect2d(image);
  if (!(target.box.width > 0 && target.box.height > 0)) return {};

  // Another of its kind beside it; what lies within its own box is a part of it, cut off by a pole.
  const std::vector<ColourBlob> blobs = SoundBlobs(weights, r, bgr.size(), options_);
  rival = std::any_of(blobs.begin(), blobs.end(), [&](const ColourBlob& b) {
    const Eigen::Vector2d away = (b.Centre() - target.centre).cwiseAbs();
    return (away.x() > 0.6 * w || away.y() > 0.6 * h) &&
           b.area_px > options_.rival_share * inside_px * r.step * r.step;
  });
  return target;
}

TrackState ColourTracker::Classify(const cv::Mat& bgr, const ColourTarget& target, bool rival) const {
  const Edges edges = EdgesOf(target.box, bgr.size());
  if (edges.Opposite() || target.box.area() > options_.close_share * static_cast<double>(bgr.total()))
    return TrackState::kTooClose;
  if (edges.Any()) return TrackState::kAtEdge;
  return rival ? TrackState::kAmbiguous : TrackState::kTracked;
}

}  // namespace kestrel::vision
