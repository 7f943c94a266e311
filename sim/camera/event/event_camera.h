// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/camera/event/event_parameters.h"

namespace kestrel::sim {

struct Event {
  std::int64_t t_ns = 0;
  std::uint16_t x = 0, y = 0;  // column and row of the pixel
  bool on = false;             // it has become brighter; otherwise darker

  bool operator==(const Event&) const = default;
};

// The pixels of an event camera (Rebecq, Gehrig, Scaramuzza: ESIM: an Open Event Camera Simulator, CoRL 2018,
// section 3): each holds the brightness of its last event, and gives another when its own has risen above
// that by threshold_on or fallen below it by threshold_off; then it holds what it has reached. Between two
// images brightness changes evenly in time. What falls into the refractory time of an event that was given is
// lost, and moves what the pixel holds all the same. Leakage is a steady fall of what it holds. An event by
// chance leaves it as it is.
//
// What it gives depends on the images, their times, the parameters and the seed alone.
class EventCamera {
 public:
  EventCamera(const EventCameraParameters& parameters, cv::Size size, std::uint64_t seed);

  // brightness: CV_32FC1, finite. From there on; there are no events yet.
  void Begin(const cv::Mat& brightness, std::int64_t t_ns);
  // The events after the time of the image before until t_ns, which is later: by time, then row, then
  // column. brightness: as in Begin, at t_ns.
  std::vector<Event> Update(const cv::Mat& brightness, std::int64_t t_ns);

  // The most by which a pixel has changed since the image before, in thresholds of its own.
  double LargestChange(const cv::Mat& brightness) const;

  // Of each pixel.
  const cv::Mat1d& threshold_on() const { return on_; }
  const cv::Mat1d& threshold_off() const { return off_; }

 private:
  std::int64_t NextByChance(std::size_t pixel, std::int64_t after_ns);

  EventCameraParameters parameters_;
  std::uint64_t seed_;
  cv::Mat1d on_, off_;
  cv::Mat1d up_, down_;  // the brightness at which its next event comes, without leakage
  cv::Mat1f before_;
  std::int64_t begun_ns_ = 0, before_ns_ = 0;
  std::vector<std::int64_t> last_ns_;    // of the last event given; empty: without refractory time
  std::vector<std::int64_t> chance_ns_;  // of the next event by chance; empty: there are none
  std::vector<std::uint32_t> chances_;   // how many have been drawn
};

}  // namespace kestrel::sim
