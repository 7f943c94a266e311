// SPDX-License-Identifier: Apache-2.0
#include "bench/alignment/bench_alignment.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/alignment/convergence.h"

namespace kestrel::bench {

void BenchAlignment(flight::SeedRange seeds, std::vector<records::Figure>& table) {
  const auto all = [](const cv::Mat& reference) {
    std::vector<NamedAligner> aligners = OurAligners(reference);
    aligners.push_back(EccAligner(reference));
    return aligners;
  };
  const ConvergenceTable study = StudyConvergence(seeds, all);
  PrintConvergence(study);
  double slowest_ms = 0;
  for (const auto& [nuisance, aligners] : study) {
    const auto &ours = aligners.at("ICIA").at("all"), &ecc = aligners.at("OpenCV ECC").at("all");
    for (const double sigma_px : kDisplacements_px) {
      const Convergence &icia = ours.at(sigma_px), &peer = ecc.at(sigma_px);
      slowest_ms = std::max(slowest_ms, icia.Mean_ms());
      table.push_back({fmt::format("{}, corners off by {:g} px: ICIA converged", nuisance, sigma_px),
                       icia.Share(), "share", peer.Share(), true, fmt::format("{:.3f}", peer.Share())});
      table.push_back({fmt::format("{}, corners off by {:g} px: ICIA, mean", nuisance, sigma_px),
                       icia.Mean_ms(), "ms", peer.Mean_ms() / 2, false,
                       fmt::format("{:.2f}", peer.Mean_ms())});
    }
  }
  table.push_back({"ICIA, template of 100x100 in 640x480, slowest mean", slowest_ms, "ms", 3, false, ""});
}

}  // namespace kestrel::bench
