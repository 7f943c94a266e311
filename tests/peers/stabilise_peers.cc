// SPDX-License-Identifier: Apache-2.0
// The clips of `kestrel bench stabilise` through OpenCV's videostab too, at the same crop: stabilise_peers [A..B]
#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <chrono>
#include <map>
#include <opencv2/core/eigen.hpp>
#include <opencv2/videostab.hpp>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "bench/enhance/shaken_clip.h"
#include "bench/enhance/stabilise_clips.h"
#include "bench/enhance/steadiness.h"
#include "flight/simulated/seeds.h"
#include "vision/enhance/stabilisation/gyro_track.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector2d;

constexpr double kCrop = 0.85;

class Images : public cv::videostab::IFrameSource {
 public:
  explicit Images(const std::vector<cv::Mat>& images) : images_(images) {}
  void reset() override { next_ = 0; }
  cv::Mat nextFrame() override { return next_ < images_.size() ? images_[next_++] : cv::Mat(); }

 private:
  const std::vector<cv::Mat>& images_;
  std::size_t next_ = 0;
};

// The stabilisers give images, which the truth cannot judge to hundredths of a pixel. The warp that made the last one
// is a protected member of theirs.
template <class Stabilizer>
class Watched : public Stabilizer {
 public:
  std::vector<cv::Mat> warps;

 protected:
  cv::Mat postProcessFrame(const cv::Mat& frame) override {
    warps.push_back(cv::videostab::at(this->curStabilizedPos_, this->stabilizationMotions_).clone());
    return Stabilizer::postProcessFrame(frame);
  }
};

struct Peer {
  std::string name;
  bool two_passes = false;
  cv::videostab::MotionModel model = cv::videostab::MM_AFFINE;
  int radius = 60;    // images before and after
  float sigma = 28;   // of its Gaussian, images; -1: its default
  bool bound = true;  // what is shown stays within the image, as ours
};

// Its defaults; then by homographies what a lag of 2 s allows, with a Gaussian whose amplitude is half at 0.2 Hz, as
// ours is. Two passes smooth by the same Gaussian, of more images; the path of least L1 norm needs Clp, which Debian's
// OpenCV is built without.
std::vector<Peer> Peers() {
  using namespace cv::videostab;
  return {{.name = "videostab, one pass, as it comes", .radius = 15, .sigma = -1},
          {.name = "videostab, one pass, lag 2 s", .model = MM_HOMOGRAPHY},
          {.name = "the same, unbound", .model = MM_HOMOGRAPHY, .bound = false},
          {.name = "videostab, two passes, 3 s", .two_passes = true, .model = MM_HOMOGRAPHY, .radius = 90}};
}

struct Result {
  std::vector<vision::ImageView> views;
  double ms = 0;  // an image
};

template <class Stabilizer>
std::vector<cv::Mat> WarpsOf(Watched<Stabilizer>& stabilizer, const Peer& peer,
                             const std::vector<cv::Mat>& images) {
  using namespace cv::videostab;
  const auto filter = cv::makePtr<GaussianMotionFilter>(peer.radius, peer.sigma);
  if constexpr (std::is_same_v<Stabilizer, OnePassStabilizer>)
    stabilizer.setMotionFilter(filter);
  else
    stabilizer.setMotionStabilizer(filter);
  stabilizer.setLog(cv::makePtr<NullLog>());
  stabilizer.setFrameSource(cv::makePtr<Images>(images));
  stabilizer.setMotionEstimator(
      cv::makePtr<KeypointBasedMotionEstimator>(cv::makePtr<MotionEstimatorRansacL2>(peer.model)));
  stabilizer.setRadius(peer.radius);
  stabilizer.setTrimRatio((1 - kCrop) / 2);
  stabilizer.setCorrectionForInclusion(peer.bound);
  while (!stabilizer.nextFrame().empty()) {}
  return stabilizer.warps;
}

Result Run(const Peer& peer, const std::vector<cv::Mat>& images) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<cv::Mat> warps;
  if (peer.two_passes) {
    Watched<cv::videostab::TwoPassStabilizer> stabilizer;
    warps = WarpsOf(stabilizer, peer, images);
  } else {
    Watched<cv::videostab::OnePassStabilizer> stabilizer;
    warps = WarpsOf(stabilizer, peer, images);
  }
  Result result;
  result.ms = 1e3 * SecondsSince(start) / static_cast<double>(images.size());
  const cv::Size size = images[0].size();
  const double trim = (1 - kCrop) / 2, left = std::floor(trim * size.width),
               top = std::floor(trim * size.height);
  for (const cv::Mat& warp : warps) {
    vision::ImageView& view = result.views.emplace_back();
    view.size = {size.width - 2 * static_cast<int>(left), size.height - 2 * static_cast<int>(top)};
    view.rows = size.height;
    Eigen::Matrix3d H;
    cv::Mat wide;
    warp.convertTo(wide, CV_64F);
    cv::cv2eigen(wide, H);
    view.H.col(2) = Eigen::Vector3d(-left, -top, 1);
    view.H = view.H * H / H(2, 2);
  }
  return result;
}

Result Ours(const ShakenClip& clip, const std::vector<cv::Mat>& images, const std::string& mode,
            const std::string& by) {
  vision::StabiliserOptions options;
  options.mode = mode, options.by = by, options.lag_s = 2, options.crop = kCrop;
  const vision::GyroTrack gyro(clip.Gyro());
  const double readout_s = clip.options().readout_s;
  const auto start = std::chrono::steady_clock::now();
  vision::Stabiliser stabiliser(options, clip.camera(), clip.options().rate_hz);
  Result result;
  for (int i = 0; i < static_cast<int>(images.size()); ++i)
    if (auto image = stabiliser.Step(images[static_cast<std::size_t>(i)], clip.t_s(i),
                                     {gyro.Rows(clip.t_s(i), readout_s), {}, readout_s}))
      result.views.push_back(image->view);
  while (auto image = stabiliser.Finish()) result.views.push_back(image->view);
  result.ms = 1e3 * SecondsSince(start) / static_cast<double>(images.size());
  return result;
}

// How what is shown is stretched against what the intended path sees: of an image, the ratio of the singular values of
// that map's derivative, at its worst in the middle and near the corners; the root mean square over the images of what
// exceeds 1.
double StretchLeft(const ShakenClip& clip, const std::vector<vision::ImageView>& views) {
  const vision::CameraModel camera = clip.camera();
  const double w = clip.camera().width_px - 1, h = clip.camera().height_px - 1;
  constexpr double kStep_px = 20;
  std::vector<double> stretches;
  for (int i = 0; i < static_cast<int>(views.size()); ++i) {
    const Pose intended = clip.Intended(clip.t_s(i));
    const auto shown = [&](const Vector2d& uv) {
      return *vision::ShownAt(views[static_cast<std::size_t>(i)], &camera,
                              clip.SeenByRows(i, clip.Ground(intended, uv)));
    };
    double worst = 1;
    for (const auto& [x, y] : {std::pair{0.5, 0.5}, {0.15, 0.15}, {0.85, 0.15}, {0.15, 0.85}, {0.85, 0.85}}) {
      const Vector2d at(x * w, y * h), right(kStep_px, 0), down(0, kStep_px);
      Eigen::Matrix2d slope;
      slope << shown(at + right) - shown(at - right), shown(at + down) - shown(at - down);
      const Vector2d scales = Eigen::JacobiSVD<Eigen::Matrix2d>(slope).singularValues();
      worst = std::max(worst, scales.x() / scales.y());
    }
    stretches.push_back(worst - 1);
  }
  return Rms(stretches);
}

void Study(flight::SeedRange seeds) {
  cv::setNumThreads(1);
  fmt::print("| {:<7} | {:<34} | jitter | stable in, out | distortion | stretch | crop  | black | ms   |\n",
             "clip", "way");
  struct Columns {
    std::vector<double> jitter, stability, distortion, stretch, outside, ms;
  };
  std::map<std::string, Columns> all;
  std::vector<std::string> order;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    for (const ShakenClipOptions& of : StabiliseClips()) {
      const ShakenClip clip(of, seed);
      std::vector<cv::Mat> images;
      for (int i = 0; i < of.images; ++i) images.push_back(clip.Draw(i));
      const auto tell = [&](const std::string& name, const Result& result) {
        if (result.views.size() != images.size())
          fmt::print("{}: {} images of {}\n", name, result.views.size(), images.size());
        const Steadiness s = SteadinessOf(clip, 0, result.views);
        const double stretch = StretchLeft(clip, result.views);
        fmt::print(
            "| {:<7} | {:<34} | {:6.4f} | {:6.3f}  {:6.3f} | {:10.4f} | {:7.4f} | {:5.3f} | {:5.3f} | "
            "{:4.1f} "
            "|\n",
            of.name, name, s.Jitter(), s.stability_in, s.stability, s.distortion, stretch, s.crop, s.outside,
            result.ms);
        if (!all.contains(name)) order.push_back(name);
        Columns& columns = all[name];
        columns.jitter.push_back(s.Jitter()), columns.stability.push_back(s.stability);
        columns.distortion.push_back(s.distortion), columns.stretch.push_back(stretch);
        columns.outside.push_back(s.outside), columns.ms.push_back(result.ms);
      };
      tell("ours, vision, lag 2 s", Ours(clip, images, "smooth", "vision"));
      tell("ours, vision, offline", Ours(clip, images, "offline", "vision"));
      tell("ours, with a gyro, lag 2 s", Ours(clip, images, "smooth", "both"));
      for (const Peer& peer : Peers()) tell(peer.name, Run(peer, images));
    }
  }
  fmt::print(
      "\n| means | jitter | stability | distortion | stretch | black | ms "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const std::string& name : order) {
    const Columns& c = all[name];
    fmt::print("| {} | {:.4f} | {:.3f} | {:.4f} | {:.4f} | {:.3f} | {:.1f} |\n", name, Mean(c.jitter),
               Mean(c.stability), Mean(c.distortion), Mean(c.stretch), Mean(c.outside), Mean(c.ms));
  }
}

}  // namespace
}  // namespace kestrel::bench

int main(int count, char** arguments) {
  kestrel::bench::Study(kestrel::flight::ParseSeeds(count > 1 ? arguments[1] : "1..2"));
}
