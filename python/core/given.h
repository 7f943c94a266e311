// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "geometry/pose.h"
#include "mission/decision.h"
#include "vision/camera.h"

// What a Sim gives, as Python holds it.
namespace kestrel::python {

// A frame with what was asked for beside its image; empty: was not.
struct ShownFrame {
  vision::Frame frame;
  cv::Mat depth, segmentation, flow;
  Pose X_NC;  // the truth at its exposure
};

// A decision with words of its own, which outlive the mission.
struct OwnedDecision {
  explicit OwnedDecision(const mission::Decision& of)
      : decision(of), phase(of.phase), target(of.target), outcome(of.outcome) {
    decision.phase = decision.target = decision.outcome = {};
    decision.report.reset();
  }
  mission::Decision decision;
  std::string phase, target, outcome;
};

}  // namespace kestrel::python
