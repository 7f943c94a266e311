// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "records/mcap/flight_messages.h"
#include "sim/camera/carried/carried_camera.h"
#include "sim/instrument/instrument_parameters.h"
#include "sim/instrument/readings.h"

// What a simulated aircraft carries beside the camera that it is flown by, in its messages.
namespace kestrel::flight {

// Each reading by its own stamp, which is its log time too. The IMU's and the rangefinder's axes are x, -y,
// -z of ours in the frames "imu" and "rangefinder", whose places on the aircraft go to /tf with the first
// reading.
class CarriedTopics {
 public:
  CarriedTopics(const sim::InstrumentParameters& instruments,
                const std::vector<sim::CarriedCameraParameters>& cameras)
      : instruments_(instruments), cameras_(cameras) {}

  // What has come until now_s.
  void Write(const sim::Readings& readings, const std::vector<sim::CameraFrame>& frames, double now_s,
             records::FlightMessages& messages);

 private:
  void WritePlaces(double now_s, records::FlightMessages& messages) const;

  sim::InstrumentParameters instruments_;
  std::vector<sim::CarriedCameraParameters> cameras_;
  bool placed_ = false;
};

}  // namespace kestrel::flight
