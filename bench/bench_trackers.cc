// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_trackers.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>

#include "base/diagnostics.h"
#include "base/process/status_line.h"
#include "base/random.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "bench/named_camera.h"
#include "flight/simulated/scenario.h"
#include "geometry/tait_bryan.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"
#include "vision/camera/calibration_file.h"
#include "vision/target/box_tracker.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector3d;

constexpr int kFrames = 100;
constexpr double kRate_hz = 20, kRadius_m = 0.25;
constexpr double kLostOverlap = 0.3;  // less is no answer

// What is different in a clip.
struct Nuisance {
  std::string name;
  const char* camera = "thesis_6mm";
  double range_m = 4, range_factor = 1.5;  // of the balloon: between range / factor and range * factor
  double azimuth_deg = 9, azimuth_hz = 0.17, elevation_deg = 6;  // how far it strays, and how often
  double exposure_s = 0;
  double noise_grey = 2;
  bool still = false;  // the camera does not sway
  bool shade = false, pole = false, curtain = false, second = false;
};
std::vector<Nuisance> Nuisances() {
  return {{.name = "slow, of one size",
           .range_factor = 1,
           .azimuth_deg = 4,
           .azimuth_hz = 0.05,
           .elevation_deg = 2,
           .still = true},
          {.name = "undisturbed"},
          {.name = "size, 14 to 1.3 m",
           .range_m = 4.3,
           .range_factor = 3.3,
           .azimuth_deg = 4,
           .elevation_deg = 3},
          {.name = "its own colour behind", .curtain = true},
          {.name = "a second one", .second = true},
          {.name = "light from 1 to 0.3", .shade = true},
          {.name = "motion blur", .azimuth_hz = 0.8, .exposure_s = 0.03},
          {.name = "noise of 12 grey", .noise_grey = 12},
          {.name = "a pole before it", .pole = true},
          {.name = "leaves the image", .azimuth_deg = 35, .azimuth_hz = 0.25},
          {.name = "fisheye",
           .camera = "fisheye",
           .range_m = 2,
           .range_factor = 2,
           .azimuth_deg = 45,
           .elevation_deg = 25}};
}

struct Photo {
  cv::Mat image;
  Vector3d p_CT;  // of the balloon
};

// A clip of one nuisance: the camera hovers at 3 m and sways, the balloon wanders before it.
class BalloonClip {
 public:
  BalloonClip(const mjModel* model, const Nuisance& nuisance, std::uint64_t seed)
      : model_(model), n_(nuisance), seed_(seed), camera_(NamedCamera(nuisance.camera)) {
    RandomStream random(seed, "bench trackers");
    for (double& phase : phases_) phase = random.Uniform(0, 2 * M_PI);
  }
  const vision::CameraModel& camera() const { return camera_; }

  std::vector<Photo> Draw() const {
    sim::Renderer renderer(model_, camera_, {.backend = "ray"});
    sim::ImageParameters parameters;
    parameters.colour = true;
    parameters.noise_grey = n_.noise_grey;
    const sim::ImageSensor sensor(parameters, camera_, seed_);
    std::vector<Photo> frames;
    for (int k = 0; k < kFrames; ++k) {
      const double t = k / kRate_hz;
      sim::DataPtr first = sim::MakeData(model_), last = sim::MakeData(model_);
      const double half = n_.exposure_s / 2;
      Put(first.get(), t - half), Put(last.get(), t + half);
      cv::Mat image;
      if (n_.exposure_s > 0) {
        const std::vector<sim::SceneState> states{{t - half, first.get(), CameraPose(t - half)},
                                                  {t + half, last.get(), CameraPose(t + half)}};
        image = renderer.Render(states, {.row_0_s = t, .exposure_s = n_.exposure_s, .samples = 12});
      } else {
        image = renderer.Render(first.get(), CameraPose(t));
      }
      if (n_.shade) {  // less and bluer light, as under a cloud or a roof
        const double dim = 0.65 + 0.35 * std::cos(2 * M_PI * 0.2 * t);
        cv::multiply(image, cv::Scalar(std::min(1.0, dim * 1.1), dim, dim * (0.85 + 0.15 * dim)), image);
      }
      // Between both ends of the exposure all moves evenly, in the image as drawn.
      const auto seen = [&](double when) { return CameraPose(when).Inverse() * Balloon(when); };
      frames.push_back({sensor.Expose(image, k), (seen(t - half) + seen(t + half)) / 2});
    }
    return frames;
  }

 private:
  double Sway(int i, double hz, double t) const {
    return std::sin(2 * M_PI * hz * t + phases_[static_cast<std::size_t>(i)]);
  }
  static Vector3d Camera() { return {0, 0, -3}; }
  Pose CameraPose(double t) const {
    Eigen::Matrix3d R_BC;  // looks along the aircraft
    R_BC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    if (n_.still) return {Eigen::Quaterniond(R_BC), Camera()};
    const Eigen::Matrix3d R_NB = RotationFromTaitBryan(
        {Radians(2.5) * Sway(0, 0.2, t), Radians(1.5) * Sway(1, 0.45, t), Radians(2) * Sway(2, 0.6, t)});
    return {Eigen::Quaterniond(R_NB * R_BC), Camera()};
  }
  static Vector3d Towards(double azimuth, double elevation) {
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
            -std::sin(elevation)};
  }
  double Elevation(double t) const { return Radians(n_.elevation_deg) * Sway(5, 0.13, t); }
  Vector3d Balloon(double t) const {
    const double range = n_.range_m * std::pow(n_.range_factor, Sway(3, 0.2, t));
    const double azimuth =
        Radians(n_.azimuth_deg) * (Sway(4, n_.azimuth_hz, t) + (n_.still ? 0 : 0.25 * Sway(6, 0.5, t)));
    return Camera() + range * Towards(azimuth, Elevation(t));
  }
  void Put(mjData* data, double t) const {
    const auto put = [&](const char* body, const Vector3d& p_N) {
      const int id = model_->body_mocapid[mj_name2id(model_, mjOBJ_BODY, body)];
      sim::VectorToMujoco(p_N, data->mocap_pos + 3 * id);
    };
    put("vehicle", Balloon(t));
    if (n_.pole) put("pole", Camera() + Vector3d(1.7, 0.05, 0));
    if (n_.curtain) put("curtain", Camera() + Vector3d(7, 1.2, 0));
    if (n_.second)
      put("second", Camera() + 5.8 * Towards(Radians(14) * Sway(7, 0.21, t), Elevation(t) + Radians(2)));
    mj_forward(model_, data);
  }

  const mjModel* model_;
  Nuisance n_;
  std::uint64_t seed_;
  vision::CameraModel camera_;
  std::array<double, 8> phases_{};
};

// The balloon's colour, from the first image of an undisturbed clip and its true outline, somewhat inside.
vision::ColourModel Learn(const Photo& frame, const vision::CameraModel& camera) {
  const vision::OutlineCone cone = *vision::ConeOfSphere(frame.p_CT, 0.9 * kRadius_m);
  std::vector<cv::Point> outline;
  for (const Eigen::Vector2d& p : vision::DrawOutline(camera, cone))
    outline.emplace_back(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  cv::Mat patch = cv::Mat::zeros(frame.image.size(), CV_8UC1);
  cv::fillPoly(patch, std::vector{outline}, 255);
  const vision::TrainedColour lesson = vision::ColourModel::Train(frame.image, patch);
  if (lesson.state != vision::TrainingState::kTrained)
    throw std::runtime_error(
        fmt::format("The balloon's colour is not learnt: {}.", vision::NameOf(lesson.state)));
  return lesson.model;
}

struct Score {
  std::vector<double> overlap, centre_px, diameter, ms;  // diameter: relative error, signed
  int lost = 0, frames = 0;                              // with the whole outline in the image
  int gone = 0, imagined = 0;                            // with nothing of it in the image, but an answer
};

void Run(const vision::BoxTracker& tracker, const std::vector<Photo>& frames,
         const vision::CameraModel& camera, Score& score) {
  const cv::Rect2d image(0, 0, vision::WidthPx(camera), vision::HeightPx(camera));
  bool started = false;
  for (const Photo& frame : frames) {
    const auto truth = vision::OutlineBox(camera, *vision::ConeOfSphere(frame.p_CT, kRadius_m));
    const bool whole = truth && (*truth & image).area() > 0.999 * truth->area();
    if (!started) {  // with the first image that holds all of it
      started = whole;
      if (started) tracker.start(frame.image, *truth);
      continue;
    }
    const double start_ms = ThreadCpu_ms();
    const auto box = tracker.track(frame.image);
    score.ms.push_back(ThreadCpu_ms() - start_ms);
    if (!truth || (*truth & image).area() <= 0) {
      ++score.gone, score.imagined += box.has_value();
      continue;
    }
    if (!whole) continue;
    const double overlap = box ? vision::Overlap(*box, *truth) : 0;
    ++score.frames, score.overlap.push_back(overlap);
    if (overlap < kLostOverlap) {
      ++score.lost;
      continue;
    }
    score.centre_px.push_back(std::hypot(box->x + box->width / 2 - truth->x - truth->width / 2,
                                         box->y + box->height / 2 - truth->y - truth->height / 2));
    score.diameter.push_back((box->width + box->height) / (truth->width + truth->height) - 1);
  }
}

// How well the cone's own deviations describe its errors in x, y and diameter of thesis (5.16).
struct Honesty {
  int within = 0, all = 0;
};
void Judge(const vision::ColourModel& model, const std::vector<Photo>& frames,
           const vision::CameraModel& camera, Honesty& honesty) {
  vision::BalloonTracker tracker(model, camera, {});
  if (const auto box = vision::OutlineBox(camera, *vision::ConeOfSphere(frames.front().p_CT, kRadius_m)))
    tracker.Begin(*box);
  for (const Photo& frame : frames) {
    const vision::BalloonObservation seen = tracker.Track(frame.image);
    const Vector3d& p = frame.p_CT;
    if (!seen.features || p.z() <= 0) continue;
    const Vector3d error = seen.features->xyd - Vector3d(p.x() / p.z(), p.y() / p.z(), 2 * kRadius_m / p.z());
    for (int i = 0; i < 3; ++i)
      honesty.within += std::abs(error[i]) <= 2 * std::sqrt(seen.features->covariance(i, i)), ++honesty.all;
  }
}

}  // namespace

void BenchTrackers(std::uint64_t first_seed, std::uint64_t last_seed, std::vector<records::Figure>& table) {
  last_seed = std::min(last_seed, first_seed + 4);
  sim::SceneParameters scene;
  scene.world = Root() / "models" / "worlds" / "airfield" / "airfield.xml";
  scene.vehicle = Root() / "models" / "targets" / "balloon.xml";
  const sim::ModelPtr model = sim::MakeModel(scene);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);

  const std::vector<Nuisance> nuisances = Nuisances();
  constexpr std::size_t kTrackers = 4, kOurs = 1;
  std::vector<std::vector<Score>> scores(nuisances.size(), std::vector<Score>(kTrackers));
  std::vector<Honesty> honesty(nuisances.size());
  std::vector<std::string> names;
  StatusLine line("trackers");
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed) {
    std::optional<vision::ColourModel> colour;
    for (std::size_t i = 0; i < nuisances.size(); ++i) {
      line.Show(fmt::format("seed {} of {}..{}, {}", seed, first_seed, last_seed, nuisances[i].name));
      const BalloonClip clip(model.get(), nuisances[i], seed);
      const std::vector<Photo> frames = clip.Draw();
      if (!colour) colour = Learn(frames.front(), clip.camera());
      const std::vector<vision::BoxTracker> trackers{vision::CamShiftBoxes(*colour),
                                                     vision::BalloonBoxes(*colour, clip.camera()),
                                                     vision::KcfBoxes(), vision::CsrtBoxes()};
      names.clear();
      for (std::size_t k = 0; k < kTrackers; ++k) {
        Run(trackers[k], frames, clip.camera(), scores[i][k]);
        names.push_back(trackers[k].name);
      }
      Judge(*colour, frames, clip.camera(), honesty[i]);
    }
  }
  line.Clear();
  cv::setNumThreads(threads);

  fmt::print(
      "| {:<22} | {:<20} | overlap | lost % | centre px 50 % 95 % | diameter % bias 95 % | imagined % "
      "| ms |\n",
      "nuisance", "tracker");
  for (std::size_t i = 0; i < nuisances.size(); ++i) {
    for (std::size_t k = 0; k < kTrackers; ++k) {
      const Score& s = scores[i][k];
      std::vector<double> size;
      for (const double d : s.diameter) size.push_back(std::abs(d));
      fmt::print(
          "| {:<22} | {:<20} | {:7.3f} | {:6.1f} | {:9.2f} {:9.2f} | {:+10.1f} {:9.1f} | {:10} | {:5.2f} |\n",
          nuisances[i].name, names[k], Mean(s.overlap), 100.0 * s.lost / std::max(1, s.frames),
          Quantile(s.centre_px, 0.5), Quantile(s.centre_px, 0.95), 100 * Mean(s.diameter),
          100 * Quantile(size, 0.95), s.gone > 0 ? fmt::format("{:.1f}", 100.0 * s.imagined / s.gone) : "",
          Mean(s.ms));
    }
    const Score& ours = scores[i][kOurs];
    double best_overlap = 0;
    int best_lost = ours.frames;
    for (std::size_t k = 0; k < kTrackers; ++k) {
      if (k == kOurs) continue;
      best_overlap = std::max(best_overlap, Mean(scores[i][k].overlap));
      best_lost = std::min(best_lost, scores[i][k].lost);
    }
    const std::string& name = nuisances[i].name;
    table.push_back({name + ": overlap of the outline's box", Mean(ours.overlap), "", best_overlap, true,
                     fmt::format("{:.3f}", best_overlap)});
    table.push_back({name + ": lost", static_cast<double>(ours.lost) / std::max(1, ours.frames), "share",
                     0.02, false,
                     fmt::format("{:.3f}", static_cast<double>(best_lost) / std::max(1, ours.frames))});
    table.push_back({name + ": within 2 sigma",
                     static_cast<double>(honesty[i].within) / std::max(1, honesty[i].all), "share", 0.9, true,
                     ""});
  }
  std::vector<double> camshift_ms, ours_ms;
  for (const auto& by_tracker : scores) {
    camshift_ms.insert(camshift_ms.end(), by_tracker[0].ms.begin(), by_tracker[0].ms.end());
    ours_ms.insert(ours_ms.end(), by_tracker[kOurs].ms.begin(), by_tracker[kOurs].ms.end());
  }
  table.push_back({"undisturbed: centre of the outline's box, median",
                   Quantile(scores[1][kOurs].centre_px, 0.5), "px", 0.2, false,
                   fmt::format("{:.2f}", Quantile(scores[1][0].centre_px, 0.5))});
  table.push_back({"undisturbed: its diameter, mean error", std::abs(Mean(scores[1][kOurs].diameter)),
                   "share", 0.005, false, fmt::format("{:.3f}", std::abs(Mean(scores[1][0].diameter)))});
  table.push_back({"CamShift, mean a frame", Mean(camshift_ms), "ms", 3, false, "50"});
  table.push_back({"CamShift and outline, mean a frame", Mean(ours_ms), "ms", 3, false, "50"});
  table.push_back({"CamShift and outline, 99th percentile", Quantile(ours_ms, 0.99), "ms", {}, false, ""});
}

}  // namespace kestrel::bench
