// SPDX-License-Identifier: Apache-2.0
// The draws of `kestrel bench alignment` for ViSP's template trackers too, which are GPL and so cannot be in the
// program: alignment_peers [A..B]
#include <fmt/format.h>

#include <array>
#include <memory>

#include "bench/alignment/convergence.h"
#include "tests/visp/template_tracker.h"

namespace kestrel::bench {
namespace {

NamedAligner VispAligner(const std::string& name, visp::TemplateMethod method, int levels,
                         const cv::Mat& reference) {
  const cv::Rect& r = kTemplateRegion;
  const double left = r.x, top = r.y, right = r.x + r.width - 1, bottom = r.y + r.height - 1;
  const auto tracker = std::make_shared<visp::TemplateTracker>(
      method, visp::GreyImage{reference.data, reference.cols, reference.rows},
      std::array<Eigen::Vector2d, 4>{{{left, top}, {right, top}, {right, bottom}, {left, bottom}}}, levels);
  return {fmt::format("ViSP {}, {} levels", name, levels), [tracker](const cv::Mat& image) {
            tracker->Restart();
            return tracker->Track({image.data, image.cols, image.rows});
          }};
}

std::vector<NamedAligner> All(const cv::Mat& reference) {
  std::vector<NamedAligner> aligners = OurAligners(reference);
  aligners.push_back(EccAligner(reference));
  for (const int levels : {1, 3}) {
    aligners.push_back(VispAligner("IC", visp::TemplateMethod::kInverseCompositional, levels, reference));
    aligners.push_back(VispAligner("ESM", visp::TemplateMethod::kSecondOrder, levels, reference));
    aligners.push_back(VispAligner("ZNCC", visp::TemplateMethod::kNormalisedInverse, levels, reference));
  }
  return aligners;
}

}  // namespace
}  // namespace kestrel::bench

int main(int count, char** arguments) {
  using namespace kestrel;
  bench::PrintConvergence(
      bench::StudyConvergence(flight::ParseSeeds(count > 1 ? arguments[1] : "1..10"), bench::All));
}
