// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "sim/instrument/instrument_parameters.h"
#include "sim/instrument/readings.h"
#include "sim/render/rendering.h"
#include "vision/camera/camera_model.h"

// What a sequence of a data set holds, whatever it was flown by and whatever format it is written in.
namespace kestrel::flight {

// Beside images, IMU, truth and calibration.
struct Extras {
  bool colour = false, depth = false, flow = false, segmentation = false, boxes = false;
  bool Surfaces() const { return depth || flow || segmentation || boxes; }
};

struct RigCamera {
  vision::CameraModel model;
  Pose X_BC;
  double rate_hz = 0;
  cv::Mat axial;  // CV_32F: of each pixel's unit ray the part along the axis; 0
                  // outside the lens
};
RigCamera MakeRigCamera(const vision::CameraModel& model, const Pose& X_BC, double rate_hz);

// A thing that is seen: the smallest rectangle around its pixels.
struct Box {
  std::string label;                               // of its body
  int u_min = 0, v_min = 0, u_max = 0, v_max = 0;  // inclusive
  int pixels = 0;
};

// What one camera saw.
struct SetFrame {
  int index = 0;  // in the sequence
  std::size_t camera = 0;
  std::int64_t stamp_ns = 0;
  cv::Mat image;
  sim::Surfaces surfaces;  // if Extras ask for them
  cv::Mat flow;            // to the next frame; empty: it is the last
  std::vector<Box> boxes;
};

struct TruthRow {
  std::int64_t stamp_ns = 0;
  Pose X_NB;
  Eigen::Vector3d v_N;
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero(), accelerometer_bias = Eigen::Vector3d::Zero();
};

// A frame as it stands in the tables.
struct FrameRow {
  std::int64_t stamp_ns = 0;
  Pose X_NC;
  std::vector<Box> boxes;
};

struct Sequence {
  int number = 0;
  std::string folder;  // below that of the set; empty: there
  Extras extras;
  std::vector<RigCamera> cameras;
  sim::ImuParameters imu_parameters;
  Pose X_BI;
  std::vector<std::vector<FrameRow>> frames;  // of each camera
  std::vector<sim::ImuReading> imu;
  std::vector<TruthRow> truth;  // at each stamp of the IMU and of the first camera
};

// Adds truth at other stamps, in the order of time. Where there is some of the same stamp already, that stays.
void MergeTruth(const std::vector<TruthRow>& others, Sequence& sequence);

}  // namespace kestrel::flight
