// SPDX-License-Identifier: Apache-2.0
// Which images a mosaic keeps, and how its canvas is drawn anew from them.
#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::vision {

using Eigen::Matrix3d;

void Mosaic::Keep(KeptImage kept) { kept_.push_back(std::move(kept)); }

// Of the images since the last keyframe those that show what no keyframe does, the most of it first.
void Mosaic::KeepWhatAloneShows() {
  constexpr double kWorthKeeping = 0.01;
  while (!pending_.empty()) {
    std::size_t best = 0;
    double most = kWorthKeeping;
    bool any = false;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      const double share = UncoveredShare(*M_WC(pending_[i].number));
      if (share <= most) continue;
      most = share, best = i, any = true;
    }
    if (!any) break;
    Keep(std::move(pending_[best]));
    pending_.erase(pending_.begin() + static_cast<std::ptrdiff_t>(best));
  }
  pending_.clear();
}

// Of an image at this place, by the images that are kept.
double Mosaic::UncoveredShare(const Matrix3d& M_WC) const {
  constexpr int kAcross = 16, kDown = 12;
  const cv::Size size = projection_->image_size();
  const cv::Rect part = projection_->PartOf(M_WC);
  std::vector<Matrix3d> M_CW;
  for (const KeptImage& each : kept_) {
    bool near = false;
    for (const cv::Rect& moved : WrappedParts(each.part, projection_->period_px()))
      for (const cv::Rect& its : WrappedParts(part, projection_->period_px())) near |= !(moved & its).empty();
    if (near) M_CW.push_back(this->M_WC(each.number)->inverse());
  }
  int all = 0, uncovered = 0;
  for (int i = 0; i <= kDown; ++i)
    for (int j = 0; j <= kAcross; ++j) {
      const auto ray = Ray(camera_, {(size.width - 1.0) * j / kAcross, (size.height - 1.0) * i / kDown});
      if (!ray) continue;
      ++all;
      const Eigen::Vector3d w = M_WC * *ray;
      uncovered += std::none_of(M_CW.begin(), M_CW.end(), [&](const Matrix3d& M) {
        const auto uv = Project(camera_, M * w);
        return uv && InImage(size, *uv);
      });
    }
  return all > 0 ? static_cast<double>(uncovered) / all : 0;
}

// The next tile that is stale, from the images that are kept.
void Mosaic::RedrawTile() {
  if (stale_.empty()) return;
  if (canvas_->halvings() != stale_halvings_) {  // it was scaled down since
    stale_ = canvas_->tiles();
    stale_halvings_ = canvas_->halvings();
  }
  const cv::Rect tile = stale_.back();
  stale_.pop_back();
  canvas_->ClearTile(tile);
  for (std::vector<KeptImage>* images : {&kept_, &pending_})
    for (KeptImage& each : *images)
      DrawImageWithin(tile, *projection_, each.image, *M_WC(each.number), *canvas_, options_.blending);
}

void Mosaic::Redraw() {
  stale_.clear();
  canvas_->Clear();
  for (std::vector<KeptImage>* images : {&kept_, &pending_})
    for (KeptImage& each : *images) {
      const Matrix3d M = *M_WC(each.number);
      each.part = projection_->PartOf(M);
      DrawImage(*projection_, each.image, M, *canvas_, options_.blending);
    }
  moved_px_ = 0;
  drawn_anew_ = keyframes_.size();
}

}  // namespace kestrel::vision
