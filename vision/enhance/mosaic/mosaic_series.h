// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::vision {

// Mosaics of a video with cuts. Images that agree with nothing of the mosaic may be blurred, or show something else:
// they begin one of their own, beside it. Once so many of those in a row agree with each other they are the next
// mosaic; if one agrees with the old mosaic before that, they are lost. Images of another size are of another
// mosaic too. Once memory is used up no other begins, and an image that would begin one is full.
class MosaicSeries {
 public:
  static constexpr int kCut = 5;  // images in a row

  // As Mosaic. The memory is that of all together: what complete mosaics keep is no more to be had.
  explicit MosaicSeries(const MosaicOptions& options);

  // Why a new mosaic began.
  enum class Cause {
    kNone,
    kCut,     // from one image to the next
    kLost,    // images between agree neither with those before nor with those after them
    kResized  // its images have another size
  };
  struct Step {
    MosaicStep step;             // in the mosaic at its end
    int mosaic = 0;              // from 0
    Cause cause = Cause::kNone;  // another: with this image it turned out that the mosaic is a new one
    int lost = 0;                // images between that and the one before
  };
  Step Add(const cv::Mat& image, double t_s, const std::optional<Pose>& X_NC = std::nullopt);
  // All are adjusted. The images at the end that agree with each other alone are a mosaic as well.
  void Finish();

  int mosaics() const { return static_cast<int>(mosaics_.size()); }
  Mosaic& mosaic(int i) { return *mosaics_[static_cast<std::size_t>(i)]; }
  const Mosaic& mosaic(int i) const { return *mosaics_[static_cast<std::size_t>(i)]; }

  // Of each image that was added.
  struct Place {
    int mosaic;  // none: -1
    int number;  // in it
    MosaicStep step;
  };
  const std::vector<Place>& places() const { return places_; }

 private:
  MosaicOptions WithWhatIsLeft() const;
  void Begin();
  void TakeNext();

  MosaicOptions options_;
  std::vector<std::unique_ptr<Mosaic>> mosaics_;
  std::unique_ptr<Mosaic> next_;      // of images that agree with nothing
  std::vector<std::size_t> of_next_;  // which images those are
  std::vector<MosaicStep> next_steps_;
  int agreeing_ = 0;          // of them in a row
  std::size_t unplaced_ = 0;  // the first image since the last that is in a mosaic
  bool full_ = false;         // an image found no room
  std::vector<Place> places_;
};

}  // namespace kestrel::vision
