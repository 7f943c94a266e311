// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/mosaic_series.h"

#include <algorithm>
#include <utility>

namespace kestrel::vision {

MosaicSeries::MosaicSeries(const MosaicOptions& options) : options_(options) {
  mosaics_.push_back(std::make_unique<Mosaic>(options));
}

MosaicOptions MosaicSeries::WithWhatIsLeft() const {
  MosaicOptions options = options_;
  for (const auto& mosaic : mosaics_) options.most_bytes -= mosaic->bytes();
  options.most_bytes = std::max<std::int64_t>(options.most_bytes, 0);
  return options;
}

void MosaicSeries::Begin() {
  next_ = std::make_unique<Mosaic>(WithWhatIsLeft());
  of_next_.clear(), next_steps_.clear();
  agreeing_ = 0;
}

void MosaicSeries::TakeNext() {
  mosaics_.push_back(std::move(next_));
  for (std::size_t i = 0; i < of_next_.size(); ++i)
    places_[of_next_[i]] = {mosaics() - 1, next_steps_[i].number, next_steps_[i]};
  of_next_.clear(), next_steps_.clear();
}

MosaicSeries::Step MosaicSeries::Add(const cv::Mat& image, double t_s, const std::optional<Pose>& X_NC) {
  Step result{mosaics_.back()->Add(image, t_s, X_NC), mosaics() - 1};
  places_.push_back({mosaics() - 1, result.step.number, result.step});
  const MosaicState state = result.step.state;
  if (IsPlaced(state)) {
    next_.reset();
    unplaced_ = places_.size();
    return result;
  }
  if (state == MosaicState::kUnreadable) return result;
  const std::int64_t room = Mosaic::MostKept(WithWhatIsLeft(), image.size(), image.channels());
  full_ |= state == MosaicState::kFull || (!next_ && mosaics_.back()->keyframes() > 0 && room < kCut);
  if (full_) {
    next_.reset();
    if (state == MosaicState::kLost) result.step.state = places_.back().step.state = MosaicState::kFull;
    return result;
  }
  if (state != MosaicState::kOtherSize && mosaics_.back()->keyframes() == 0) return result;
  if (!next_) Begin();
  MosaicStep step = next_->Add(image, t_s, X_NC);
  if (!IsPlaced(step.state)) {  // they do not agree with each other either
    Begin();
    step = next_->Add(image, t_s, X_NC);
  }
  of_next_.push_back(places_.size() - 1);
  next_steps_.push_back(step);
  agreeing_ = IsPlaced(step.state) ? agreeing_ + 1 : 0;
  if (agreeing_ < kCut) return result;
  const auto lost = static_cast<int>(of_next_.front() - unplaced_);
  const Cause cause = state == MosaicState::kOtherSize ? Cause::kResized
                      : lost > 0                       ? Cause::kLost
                                                       : Cause::kCut;
  TakeNext();
  unplaced_ = places_.size();
  return {step, mosaics() - 1, cause, lost};
}

void MosaicSeries::Finish() {
  if (next_ && agreeing_ > 1) TakeNext();
  next_.reset();
  for (const auto& mosaic : mosaics_) mosaic->Adjust();
}

}  // namespace kestrel::vision
