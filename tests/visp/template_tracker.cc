// SPDX-License-Identifier: Apache-2.0
#include "tests/visp/template_tracker.h"

#include <visp3/core/vpException.h>
#include <visp3/tt/vpTemplateTrackerSSDESM.h>
#include <visp3/tt/vpTemplateTrackerSSDInverseCompositional.h>
#include <visp3/tt/vpTemplateTrackerWarpHomography.h>
#include <visp3/tt/vpTemplateTrackerWarpHomographySL3.h>
#include <visp3/tt/vpTemplateTrackerZNCCInverseCompositional.h>

#include <algorithm>
#include <vector>

namespace kestrel::visp {
namespace {

vpImage<unsigned char> Visp(const GreyImage& image) {
  vpImage<unsigned char> copy(static_cast<unsigned>(image.rows), static_cast<unsigned>(image.cols));
  std::copy_n(image.pixels, image.cols * image.rows, copy.bitmap);
  return copy;
}

}  // namespace

struct TemplateTracker::Parts {
  vpTemplateTrackerWarpHomography homography;
  vpTemplateTrackerWarpHomographySL3 sl3;
  std::unique_ptr<vpTemplateTracker> tracker;
  bool second_order = false;
};

TemplateTracker::TemplateTracker(TemplateMethod method, const GreyImage& reference,
                                 const std::array<Eigen::Vector2d, 4>& corners, int levels)
    : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  p.second_order = method == TemplateMethod::kSecondOrder;
  if (method == TemplateMethod::kInverseCompositional) {
    p.tracker = std::make_unique<vpTemplateTrackerSSDInverseCompositional>(&p.homography);
  } else if (method == TemplateMethod::kSecondOrder) {
    p.tracker = std::make_unique<vpTemplateTrackerSSDESM>(&p.sl3);
  } else {
    p.tracker = std::make_unique<vpTemplateTrackerZNCCInverseCompositional>(&p.homography);
  }
  p.tracker->setSampling(1, 1);
  p.tracker->setLambda(0.001);
  p.tracker->setIterationMax(200);
  p.tracker->setPyramidal(static_cast<unsigned>(levels), 0);
  const auto at = [&](std::size_t k) { return vpImagePoint(corners[k].y(), corners[k].x()); };
  p.tracker->initFromPoints(Visp(reference), {at(0), at(1), at(2), at(0), at(2), at(3)});
  Restart();
}

TemplateTracker::~TemplateTracker() = default;

void TemplateTracker::Restart() {
  vpColVector start(8);
  start = 0;
  parts_->tracker->setp(start);
}

std::optional<Eigen::Matrix3d> TemplateTracker::Track(const GreyImage& image) {
  Parts& p = *parts_;
  try {
    p.tracker->track(Visp(image));
  } catch (const vpException&) {
    return std::nullopt;
  }
  const vpColVector found = p.tracker->getp();
  if (p.second_order) p.sl3.computeCoeff(found);  // whose matrix it then gives
  const vpHomography H = p.second_order ? p.sl3.getHomography() : p.homography.getHomography(found);
  Eigen::Matrix3d W;
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 3; ++j) W(i, j) = H[i][j];
  }
  return W;
}

}  // namespace kestrel::visp
