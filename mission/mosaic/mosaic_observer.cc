// SPDX-License-Identifier: Apache-2.0
#include "mission/mosaic/mosaic_observer.h"

#include <fmt/format.h>

#include <chrono>

#include "base/stopwatch.h"
#include "mission/mosaic/mosaic_view.h"
#include "vision/enhance/canvas/geotiff.h"
#include "vision/write_image.h"

namespace kestrel::mission {
namespace {

constexpr int kStillEvery = 100;
constexpr int kStillWidth_px = 640, kVideoWidth_px = 960;

cv::Size FourByThree(int width) { return {width, width * 3 / 4}; }

vision::MosaicOptions OptionsOf(vision::MosaicOptions options, const MosaicParameters& p,
                                const vision::CameraModel& camera) {
  options.camera = camera;
  options.pose_sigma_m = p.pose_sigma_m, options.pose_sigma_deg = p.pose_sigma_deg;
  options.most_bytes = std::int64_t{1'000'000} * p.memory_mb;
  return options;
}

vision::MosaicOptions ChainOf(vision::MosaicOptions options) {
  options.loops = options.redraw = false;
  return options;
}

std::vector<PlacedImage> PlacesOf(const vision::Mosaic& mosaic, const std::vector<std::int64_t>& sequences) {
  std::vector<PlacedImage> places;
  for (int i = 0; i < mosaic.images(); ++i)
    if (const auto M_WC = mosaic.M_WC(i)) places.push_back({sequences[static_cast<std::size_t>(i)], *M_WC});
  return places;
}

}  // namespace

MosaicObserver::MosaicObserver(vision::MosaicOptions options, const MosaicParameters& parameters,
                               const vision::CameraModel& camera, const Pose& X_BC, int images)
    : parameters_(parameters), X_BC_(X_BC), images_(images), mosaic_(OptionsOf(options, parameters, camera)) {
  if (parameters.chain) chain_.emplace(ChainOf(mosaic_.options()));
}

std::optional<Pose> MosaicObserver::PoseOf(const vision::Frame& frame) const {
  if (!parameters_.poses) return std::nullopt;
  const auto state = history_.At(frame.t_s);
  if (!state) return std::nullopt;
  return Pose{state->R_NB, state->p_NB} * X_BC_;
}

vision::MosaicStep MosaicObserver::Add(const vision::Frame& frame, Decision& decision) {
  const auto start = std::chrono::steady_clock::now();
  const vision::MosaicStep step = mosaic_.Add(frame.image, frame.t_s, PoseOf(frame));
  decision.vision_s = SecondsSince(start);
  sequences_.push_back(frame.sequence);
  placed_ += vision::IsPlaced(step.state);
  decision.target = vision::NameOf(step.state);
  if (chain_) chain_->Add(frame.image, frame.t_s);
  last_ = step, last_image_ = frame.image;
  if (offered() == 1 || offered() % kStillEvery == 0 || offered() == images_)
    stills_.push_back(DrawnMosaic(mosaic_, frame.image, FourByThree(kStillWidth_px),
                                  fmt::format("image {} of {}", offered(), images_)));
  return step;
}

std::shared_ptr<const FinishedMosaic> MosaicObserver::Finish() {
  if (placed_ == 0) return nullptr;
  mosaic_.Adjust();
  FinishedMosaic finished{
      mosaic_.projection(), PlacesOf(mosaic_, sequences_), {}, mosaic_.GroundFromSurface()};
  if (chain_) finished.chained = PlacesOf(*chain_, sequences_);
  return std::make_shared<FinishedMosaic>(std::move(finished));
}

void MosaicObserver::Fill(MosaicReport& report) const {
  report.offered = offered(), report.placed = placed_;
  report.keyframes = mosaic_.keyframes(), report.loops = mosaic_.loops();
}

std::vector<Caption> MosaicObserver::Captions() const {
  if (!last_) return {};
  return {{fmt::format("image {} of {}: {}", offered(), images_, vision::NameOf(last_->state))},
          {fmt::format("{} places agree, {:.2f} px", last_->agreed, last_->rms_px)},
          {fmt::format("{} keyframes, {} loops", mosaic_.keyframes(), mosaic_.loops())}};
}

cv::Mat MosaicObserver::ProductImage() const {
  if (!last_) return {};
  if (shown_of_ != offered()) {
    shown_ = DrawnMosaic(mosaic_, last_image_, FourByThree(kVideoWidth_px),
                         fmt::format("image {} of {}", offered(), images_));
    shown_of_ = offered();
  }
  return shown_;
}

void MosaicObserver::WriteProducts(const std::filesystem::path& folder) const {
  if (placed_ == 0) return;
  const vision::MosaicPicture picture = mosaic_.Picture();
  vision::WriteImage(folder / "mosaic.png", picture.image);
  const auto ground = mosaic_.GroundFromSurface();
  if (ground && vision::GeoTiffIsAvailable()) vision::WriteGeoTiff(folder / "mosaic.tif", picture, *ground);
  if (!stills_.empty()) vision::WriteImage(folder / "mosaic_growth.png", Tiled(stills_));
}

std::vector<std::string> MosaicProducts() { return {"mosaic.png", "mosaic_growth.png", "mosaic.tif"}; }

}  // namespace kestrel::mission
