// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "vision/capture/image_source.h"

namespace kestrel::vision {

// A GenICam camera (GigE Vision, USB3 Vision). What is asked for is set with its automatic turned off, read
// back, and must be there: a camera that gives other images would meet the wrong calibration. What is not
// asked for stays as the camera has it.
struct AravisSourceOptions {
  std::string id;      // as Aravis lists it ("Vendor-serial", or an address); empty: the first camera
  cv::Size size;       // pixels, cut from the middle of the sensor; empty: the region that is set
  double rate_hz = 0;  // 0: the camera's
  std::optional<double> exposure_us;
  std::optional<double> gain;  // in the camera's own unit, mostly dB
  bool colour = false;         // CV_8UC3, otherwise CV_8UC1
};

// Images are asked for as Bayer patterns of 8 bits for colour and as Mono8 for grey, and converted from what
// of Mono8, Bayer, BGR8 and RGB8 the camera has.
//
// Time stamps are the camera's clock brought to the monotonic one (base/clock_sync.h) by when the blocks of
// its stream came; late by the shortest way from the camera's stamp to here. Counts are the camera's own.
// A damaged image is left out and shows as a gap. The source fails when control of the camera is lost, or
// nothing comes for kAravisSilent_s and three periods.
ImageSourceMaker AravisSource(const AravisSourceOptions& options);

// Shorter than LiveCamera's patience, so that the camera is let go before it is opened anew.
inline constexpr double kAravisSilent_s = 0.8;

}  // namespace kestrel::vision
