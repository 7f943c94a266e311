// SPDX-License-Identifier: Apache-2.0
// `kestrel bench planar` for ViSP's template trackers too, which are GPL and so cannot be in the program:
// planar_peers [A..B]
#include <fmt/format.h>

#include <array>
#include <memory>
#include <optional>

#include "bench/planar/bench_planar.h"
#include "bench/planar/planar_sequence.h"
#include "tests/visp/template_tracker.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::bench {
namespace {

// As its users have it: the template is the picture's place in the first image.
PlanarTracker VispTracker(const std::string& name, visp::TemplateMethod method) {
  constexpr int kLevels = 3;
  struct State {
    std::optional<visp::TemplateTracker> tracker;
    Eigen::Matrix3d H_first;
  };
  const auto state = std::make_shared<State>();
  const auto view = [](const cv::Mat& grey) { return visp::GreyImage{grey.data, grey.cols, grey.rows}; };
  return {"ViSP, " + name, false,
          [=](const cv::Mat& grey, const Eigen::Matrix3d& H_w) {
            std::array<Eigen::Vector2d, 4> corners = PlanarCorners();
            for (Eigen::Vector2d& corner : corners) corner = vision::Transfer(H_w, corner);
            state->tracker.emplace(method, view(grey), corners, kLevels);
            state->H_first = H_w;
          },
          [=](const cv::Mat& grey) -> std::optional<Eigen::Matrix3d> {
            const auto W = state->tracker->Track(view(grey));
            if (!W) return std::nullopt;
            return *W * state->H_first;
          }};
}

std::vector<PlanarTracker> All(const cv::Mat& picture) {
  std::vector<PlanarTracker> all = PlanarTrackers(picture);
  all.push_back(VispTracker("IC", visp::TemplateMethod::kInverseCompositional));
  all.push_back(VispTracker("ESM", visp::TemplateMethod::kSecondOrder));
  all.push_back(VispTracker("ZNCC", visp::TemplateMethod::kNormalisedInverse));
  return all;
}

}  // namespace
}  // namespace kestrel::bench

int main(int count, char** arguments) {
  using namespace kestrel;
  std::vector<records::Figure> table;
  bench::BenchPlanar(flight::ParseSeeds(count > 1 ? arguments[1] : "1..1"), 2, {}, bench::All, table);
  records::PrintFigures(table);
}
