// SPDX-License-Identifier: Apache-2.0
#include "bench/alignment/convergence.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <memory>
#include <opencv2/core/eigen.hpp>
#include <opencv2/video/tracking.hpp>

#include "base/process/status_line.h"
#include "base/stopwatch.h"
#include "vision/landmark/alignment/aligner.h"

namespace kestrel::bench {

std::vector<NamedAligner> OurAligners(const cv::Mat& reference) {
  using vision::AlignmentMethod;
  std::vector<NamedAligner> ours;
  for (const auto& [name, method] : {std::pair{"forward additive", AlignmentMethod::kForwardAdditive},
                                     std::pair{"ICIA", AlignmentMethod::kInverseCompositional},
                                     std::pair{"ESM", AlignmentMethod::kSecondOrder}}) {
    const auto aligner = std::make_shared<vision::Aligner>(reference, kTemplateRegion,
                                                           vision::AlignmentOptions{.method = method});
    const auto pyramid = std::make_shared<vision::ImagePyramid>();
    ours.push_back({name, [aligner, pyramid](const cv::Mat& image) -> std::optional<Eigen::Matrix3d> {
                      vision::FillPyramid(image, *pyramid);
                      return aligner->Align(*pyramid, Eigen::Matrix3d::Identity()).W;
                    }});
  }
  return ours;
}

NamedAligner EccAligner(const cv::Mat& reference) {
  const cv::Mat patch = reference(kTemplateRegion).clone();
  return {"OpenCV ECC", [patch](const cv::Mat& image) -> std::optional<Eigen::Matrix3d> {
            const cv::Point at = kTemplateRegion.tl();
            cv::Mat map = (cv::Mat_<float>(3, 3) << 1, 0, at.x, 0, 1, at.y, 0, 0, 1);
            const cv::TermCriteria end(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-4);
            try {
              cv::findTransformECC(patch, image, map, cv::MOTION_HOMOGRAPHY, end, cv::noArray(), 5);
            } catch (const cv::Exception&) {  // it did not converge
              return std::nullopt;
            }
            Eigen::Matrix3d W, patch_from_picture = Eigen::Matrix3d::Identity();
            cv::cv2eigen(map, W);
            patch_from_picture(0, 2) = -at.x, patch_from_picture(1, 2) = -at.y;
            return W * patch_from_picture;
          }};
}

ConvergenceTable StudyConvergence(
    flight::SeedRange seeds,
    const std::function<std::vector<NamedAligner>(const cv::Mat& reference)>& aligners) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  ConvergenceTable table;
  StatusLine line("alignment");
  for (const AlignmentPicture& picture : AlignmentPictures()) {
    const std::vector<NamedAligner> each = aligners(DrawReference(picture));
    for (const AlignmentNuisance& nuisance : AlignmentNuisances()) {
      for (const double sigma_px : kDisplacements_px) {
        line.Show(fmt::format("{}, {}, {:g} px", picture.name, nuisance.name, sigma_px));
        for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
          const AlignmentDraw draw = DrawDisplaced(picture, sigma_px, nuisance, seed);
          for (const NamedAligner& aligner : each) {
            const double start_ms = ThreadCpu_ms();
            const auto W = aligner.align(draw.image);
            const double ms = ThreadCpu_ms() - start_ms;
            const bool converged = W && CornerError_px(*W, draw.W_truth) < kConverged_px;
            for (const std::string& of : {picture.name, std::string("all")}) {
              Convergence& c = table[nuisance.name][aligner.name][of][sigma_px];
              ++c.draws, c.converged += converged, c.ms += ms;
            }
          }
        }
      }
    }
  }
  cv::setNumThreads(threads);
  return table;
}

void PrintConvergence(const ConvergenceTable& table) {
  fmt::print("| {:<11} | {:<20} | {:<8} |", "nuisance", "converged %, and ms", "picture");
  for (const double sigma_px : kDisplacements_px) fmt::print(" {:>9} |", fmt::format("{:g} px", sigma_px));
  fmt::print("\n");
  for (const auto& [nuisance, aligners] : table) {
    for (const auto& [aligner, pictures] : aligners) {
      for (const auto& [picture, displacements] : pictures) {
        fmt::print("| {:<11} | {:<20} | {:<8} |", nuisance, aligner, picture);
        for (const auto& [sigma_px, c] : displacements)
          fmt::print(" {:3.0f} {:5.2f} |", 100 * c.Share(), c.Mean_ms());
        fmt::print("\n");
      }
    }
  }
}

}  // namespace kestrel::bench
