// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "base/yaml/fields.h"
#include "sim/camera/camera_faults.h"
#include "sim/camera/exposure.h"
#include "sim/camera/lens.h"
#include "sim/camera/noise_table.h"
#include "sim/camera/tone_curve.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// How far the camera of a run may be from what its parameters say: each of these is drawn once a run,
// uniformly within as much around its value, and kept within its range. One that is off on average may so be
// on in half of the runs.
struct ImageScatter {
  double noise_grey = 0, gain = 0, full_well_e = 0, gamma = 0, jpeg_quality = 0;
  double time_s = 0, line_s = 0;                         // of exposure
  double cos_power = 0, vignetting = 0, defocus_px = 0;  // of lens; vignetting: its first number
};

// A camera's sensor and what stands before and behind it. Everything is off but a little read noise. Keys are
// in the order in which light and signal meet the parts.
struct ImageParameters {
  bool colour = false;
  double rate_hz = 20;
  double latency_s = 0.05;  // from the middle of the exposure until the flight code has the frame
  ExposureParameters exposure;
  AutoExposureParameters auto_exposure;
  LensParameters lens;
  double gain = 1;  // of the signal and its noise; with auto-exposure, where it begins
  double full_well_e =
      0;  // electrons that make the grey level 255 at a gain of 1: fewer, more shot noise; 0: none
  double noise_grey =
      2;  // standard deviation of the read noise of a pixel at a gain of 1, grey levels of 255
  double gamma = 1;
  int bits = 8;          // of each pixel
  int jpeg_quality = 0;  // 1 to 100; 0: not compressed
  ImageScatter scatter;
  std::vector<CameraFault> faults;
};

inline void Fields(FieldVisitor& v, ImageScatter& s) {
  v({"noise_grey", "half width of the interval in which image.noise_grey is drawn"}, s.noise_grey, 0.0, 60.0);
  v({"gain", "half width of the interval in which image.gain is drawn"}, s.gain, 0.0, 10.0);
  v({"full_well_e", "half width of the interval in which image.full_well_e is drawn"}, s.full_well_e, 0.0,
    1e6);
  v({"gamma", "half width of the interval in which image.gamma is drawn"}, s.gamma, 0.0, 2.0);
  v({"jpeg_quality", "half width of the interval in which image.jpeg_quality is drawn"}, s.jpeg_quality, 0.0,
    100.0);
  v({"time_s", "half width of the interval in which image.exposure.time_s is drawn"}, s.time_s, 0.0, 1.0);
  v({"line_s", "half width of the interval in which image.exposure.line_s is drawn"}, s.line_s, 0.0, 0.01);
  v({"cos_power", "half width of the interval in which image.lens.cos_power is drawn"}, s.cos_power, 0.0,
    16.0);
  v({"vignetting", "half width of the interval in which the first number of image.lens.vignetting is drawn"},
    s.vignetting, 0.0, 4.0);
  v({"defocus_px", "half width of the interval in which image.lens.defocus_px is drawn"}, s.defocus_px, 0.0,
    20.0);
}

inline void Fields(FieldVisitor& v, ImageParameters& p) {
  v({"colour", "colour images; otherwise they are monochrome"}, p.colour);
  v({"rate_hz", "frames in a second"}, p.rate_hz, 0.5, 500.0);
  v({"latency_s", "time from the middle of the exposure until the flight code has the frame"}, p.latency_s,
    0.0, 2.0);
  v({"exposure", "exposure time and shutter"}, p.exposure);
  v({"auto_exposure", "control of exposure time, gain and iris by the mean grey level"}, p.auto_exposure);
  v({"lens", "vignetting and defocus"}, p.lens);
  v({"gain", "gain of the signal and of its noise; with auto-exposure, the first frame's"}, p.gain, 0.05,
    1000.0);
  v({"full_well_e",
     "electrons of the grey level 255 at a gain of 1, from which the shot noise follows; 0: no shot noise"},
    p.full_well_e, 0.0, 1e6);
  v({"noise_grey", "standard deviation of the read noise at a gain of 1, grey levels of 255"}, p.noise_grey,
    0.0, 60.0);
  v({"gamma", "gamma by which the image is coded; 1: linear"}, p.gamma, 1.0, 3.0);
  v({"bits", "bits of each pixel's value"}, p.bits, 1, 8);
  v({"jpeg_quality", "quality of JPEG compression, 1 to 100; 0: none"}, p.jpeg_quality, 0, 100);
  v({"scatter",
     "how far the camera of a run may be from these numbers, drawn uniformly once a run, by the seed"},
    p.scatter);
  v({"faults", "faults of the camera; several at a time add up"}, p.faults);
}

// The camera of one run: the scatter drawn, and none left.
ImageParameters DrawScatter(const ImageParameters& parameters, std::uint64_t seed);

// The longest that a row may be exposed in any run, by scatter and auto-exposure; the longest time from the
// exposure of the first row to that of the last.
double LongestExposure_s(const ImageParameters& parameters);
double LongestReadout_s(const ImageParameters& parameters, int rows);

// Makes a sensor's image of a rendered one, in the order in which light takes it: defocus, vignetting with
// rim and reflection, exposure and gain, shot noise, read noise, gamma, quantisation, compression.
// Monochrome unless colour is asked for. What it does depends on the seed, the setting and the frame's
// sequence alone, so that frames may be made in any order on any thread.
//
// It works on linear light. The rendered bytes are taken for that while gamma is 1; otherwise for light coded
// by that gamma: they are decoded first, and the image is coded again at the end. Parts that are off cost
// nothing, and with read noise alone no light is reckoned at all. Shot noise is the normal one of that
// variance, good for more than some ten electrons: with a full well of N electrons a signal of s grey levels
// has the variance s gain 255 / N (photon transfer; EMVA 1288).
class ImageSensor {
 public:
  // parameters: without scatter.
  ImageSensor(const ImageParameters& parameters, const vision::CameraModel& camera, std::uint64_t seed);
  cv::Mat Expose(const cv::Mat& bgr, std::int64_t sequence, const ExposureSetting& setting) const;
  // With the setting of the parameters.
  cv::Mat Expose(const cv::Mat& bgr, std::int64_t sequence) const;
  // What a broken one gives: random bytes.
  cv::Mat Garbage(cv::Size size, std::int64_t sequence) const;
  // The mean of an image over the pixels that the lens lights, as auto-exposure meters it.
  double MeanGrey(const cv::Mat& image) const;

 private:
  void Develop(cv::Mat& image, std::int64_t sequence, const ExposureSetting& setting) const;

  ImageParameters parameters_;
  std::uint64_t seed_;
  bool linear_ = false;                 // light must be reckoned; otherwise read noise on bytes is all
  NoiseTable<std::int8_t> byte_noise_;  // grey levels, while not linear_
  NoiseTable<float> noise_;             // of deviation 1, while linear_
  cv::Mat shade_;                       // for each channel of each pixel
  Defocus defocus_;
  ToneCurve tone_;
  double lit_share_ = 1;  // of the pixels, by the lens
};

}  // namespace kestrel::sim
