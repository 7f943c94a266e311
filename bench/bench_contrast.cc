// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_contrast.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/in_parallel.h"
#include "base/random.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/scenario.h"
#include "geometry/tait_bryan.h"
#include "sim/camera/image_sensor.h"
#include "sim/camera/renderer.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"
#include "vision/camera/calibration_file.h"
#include "vision/target/contrast_tracker.h"
#include "vision/write_image.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector3d;

constexpr double kContrastRate_hz = 20, kSpeed_m_s = 5, kFrom_m = 60, kTo_m = 4;
constexpr int kContrastFrames = static_cast<int>((kFrom_m - kTo_m) / kSpeed_m_s * kContrastRate_hz);
constexpr double kAttitudeError = Radians(1), kAttitudeNoise = Radians(0.1);  // slow; from image to image
constexpr std::array<const char*, 4> kWorlds{"autumn_clear", "summer_sun", "winter_cloudy", "winter_sunset"};

struct Intruder {
  const char* body;
  const char* colour;
  double radius_m;
};
constexpr std::array<Intruder, 6> kIntruders{{{"vehicle", "dark", 0.25},
                                              {"white_small", "white", 0.25},
                                              {"red_small", "red", 0.25},
                                              {"dark_large", "dark", 0.5},
                                              {"white_large", "white", 0.5},
                                              {"red_large", "red", 0.5}}};

vision::CameraModel Fisheye() {
  Mistakes mistakes;
  const vision::CameraModel camera =
      vision::LoadCamera(Root() / "models" / "cameras" / "fisheye.yaml", mistakes);
  mistakes.ThrowIfAny();
  return camera;
}

sim::LandscapeParameters Landscape(const char* name) {
  Mistakes mistakes;
  sim::LandscapeParameters p;
  Read(LoadConfig(Root() / "models" / "worlds" / name / (std::string(name) + ".yaml"), {}, mistakes), p,
       mistakes);
  mistakes.ThrowIfAny();
  return p;
}

// Share of the directions right around a ball that show the sky, and nothing before the ball. Other balls
// count as sky.
double OpenAround(const cv::Mat& geom, const mjModel* model, const vision::CameraModel& camera,
                  const Vector3d& p_CT, double radius_m) {
  const auto moves = [&](int g) { return g >= 0 && model->body_mocapid[model->geom_bodyid[g]] >= 0; };
  constexpr double kAside_px = 2;
  const double px = std::get<vision::KannalaBrandt>(camera).fx;
  const auto at = [&](const Vector3d& ray) -> std::optional<int> {
    const auto uv = vision::Project(camera, ray);
    if (!uv) return std::nullopt;
    const cv::Point p(static_cast<int>(std::lround(uv->x())), static_cast<int>(std::lround(uv->y())));
    if (!cv::Rect(0, 0, geom.cols, geom.rows).contains(p)) return std::nullopt;
    return geom.at<int>(p);
  };
  const Vector3d axis = p_CT.normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
  const double aside = std::tan(std::asin(radius_m / p_CT.norm()) + kAside_px / px);
  int open = 0;
  constexpr int kPoints = 32;
  for (int i = 0; i < kPoints; ++i) {
    const double a = 2 * M_PI * i / kPoints;
    const auto g = at(axis + aside * (std::cos(a) * u + std::sin(a) * v));
    open += g && (*g == -1 || moves(*g));
  }
  return static_cast<double>(open) / kPoints;
}

// What the camera does and where the intruders are, over one landscape.
class Clip {
 public:
  Clip(const char* world, std::uint64_t seed, bool with_intruders) : with_(with_intruders) {
    RandomStream random(seed, fmt::format("bench contrast {} {}", world, with_intruders));
    scene_.landscape = Landscape(world);
    scene_.landscape->seed = 1 + random.Bits() / 2;
    scene_.landscape->sun_azimuth_deg = random.Uniform(-180, 180);
    scene_.vehicle = Root() / "models" / "targets" / "intruders.xml";
    scene_.world = world;
    for (double& phase : phases_) phase = random.Uniform(0, 2 * M_PI);
    height_m_ = 5 * std::pow(12, random.Uniform(0, 1));
    heading_ = random.Uniform(-M_PI, M_PI);
    // One in each sixth of the view.
    std::array<int, 6> order{0, 1, 2, 3, 4, 5};
    for (std::size_t i = 5; i > 0; --i)
      std::swap(order[i], order[static_cast<std::size_t>(random.Bits() % (i + 1))]);
    for (std::size_t i = 0; i < kIntruders.size(); ++i) {
      azimuth_[i] = Radians(-60 + 24 * order[i] + random.Uniform(-7, 7));
      elevation_[i] = Radians(random.Uniform(1, 25));
    }
    noise_seed_ = random.Bits();
  }
  const sim::SceneParameters& scene() const { return scene_; }
  double elevation(std::size_t i) const { return elevation_[i]; }
  double height_m() const { return height_m_; }

  Pose CameraPose(double t) const {
    Eigen::Matrix3d R_BC;  // looks along the aircraft
    R_BC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    const Eigen::Matrix3d R_NB =
        RotationFromTaitBryan({heading_ + Radians(4) * Sway(0, 0.15, t), Radians(3) * Sway(1, 0.4, t),
                               Radians(4) * Sway(2, 0.5, t)});
    return {Eigen::Quaterniond(R_NB * R_BC), {0, 0, -height_m_}};
  }
  // The attitude as an autopilot has it.
  Eigen::Matrix3d GivenAttitude(int k) const {
    const double t = k / kContrastRate_hz;
    RandomStream random(noise_seed_ ^ RandomStream::Mix(static_cast<std::uint64_t>(k)), "attitude");
    Vector3d error;
    for (int i = 0; i < 3; ++i)
      error[i] = kAttitudeError * Sway(3 + i, 0.05, t) + kAttitudeNoise * random.Normal();
    return ExpRotation(error).toRotationMatrix() * CameraPose(t).R.toRotationMatrix();
  }
  Vector3d PlaceOf(std::size_t i, double t) const {
    const double range = kFrom_m - kSpeed_m_s * t, a = heading_ + azimuth_[i], e = elevation_[i];
    return Vector3d(0, 0, -height_m_) +
           range * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), -std::sin(e));
  }
  void Put(const mjModel* model, mjData* data, double t) const {
    for (std::size_t i = 0; with_ && i < kIntruders.size(); ++i) {
      const int id = model->body_mocapid[mj_name2id(model, mjOBJ_BODY, kIntruders[i].body)];
      sim::VectorToMujoco(PlaceOf(i, t), data->mocap_pos + 3 * id);
    }
    mj_forward(model, data);
  }
  bool with() const { return with_; }

 private:
  double Sway(int i, double hz, double t) const {
    return std::sin(2 * M_PI * hz * t + phases_[static_cast<std::size_t>(i)]);
  }
  bool with_;
  sim::SceneParameters scene_;
  std::array<double, 8> phases_{};
  std::array<double, 6> azimuth_{}, elevation_{};
  double height_m_ = 0, heading_ = 0;
  std::uint64_t noise_seed_ = 0;
};

struct Approach {
  double confirmed_m = 0;  // range at the first confirmed sighting; 0: never
  int frames_after = 0, tracked_after = 0;
  int identities = 0;
  double elevation_deg = 0;
  double min_open = 1;  // share of what is right around it that is sky, in the worst image
  std::vector<double> bearing_deg, diameter, growth;  // errors; of the diameter relative; of the growth in
                                                      // its own deviations
};
struct ClipResult {
  std::array<Approach, 6> approaches;
  double seconds = 0, sky_seconds = 0;  // of flight; with sky to be searched
  int false_targets = 0;                // ids confirmed that are no intruder's
  int false_frames = 0;                 // images with such a one
  std::vector<double> ms;
};

void Save(const std::filesystem::path& out, const std::string& name, const cv::Mat& image,
          const std::vector<std::pair<Eigen::Vector2d, cv::Scalar>>& marks) {
  if (out.empty()) return;
  std::filesystem::create_directories(out);
  cv::Mat drawn = image.clone();
  for (const auto& [px, colour] : marks)
    cv::circle(drawn, {static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y()))}, 12,
               colour);
  vision::WriteImage(out / (name + ".png"), drawn);
}

ClipResult Fly(const Clip& clip, const char* world, std::uint64_t seed, const std::filesystem::path& out) {
  ClipResult result;
  const vision::CameraModel camera = Fisheye();
  const sim::ModelPtr model = sim::MakeModel(clip.scene());
  const sim::DataPtr data = sim::MakeData(model.get());
  sim::Renderer renderer(model.get(), camera, {.backend = "ray"});
  sim::ImageParameters parameters;
  parameters.colour = true;
  const sim::ImageSensor sensor(parameters, camera, seed);
  vision::ContrastTracker tracker(camera, {}, {});
  std::map<int, bool> known_false;
  std::array<std::vector<int>, 6> ids;
  for (int k = 0; k < kContrastFrames; ++k) {
    const double t = k / kContrastRate_hz;
    clip.Put(model.get(), data.get(), t);
    const Pose X_NC = clip.CameraPose(t);
    const cv::Mat image = sensor.Expose(renderer.Render(data.get(), X_NC), k);
    const Eigen::Matrix3d R_NC = clip.GivenAttitude(k);
    const double start_ms = ThreadCpu_ms();
    const vision::ContrastObservation seen = tracker.Track(image, R_NC, t);
    result.ms.push_back(ThreadCpu_ms() - start_ms);
    result.seconds += 1 / kContrastRate_hz;
    if (seen.state < vision::ContrastState::kNoSky) result.sky_seconds += 1 / kContrastRate_hz;
    if (clip.with() && k % 10 == 0) {
      const cv::Mat geom = renderer.Trace(data.get(), X_NC).geom;
      for (std::size_t i = 0; i < kIntruders.size(); ++i)
        result.approaches[i].min_open =
            std::min(result.approaches[i].min_open,
                     OpenAround(geom, model.get(), camera, X_NC.Inverse() * clip.PlaceOf(i, t),
                                kIntruders[i].radius_m));
    }
    std::array<bool, 6> met{};
    bool any_false = false;
    for (const vision::ContrastTarget& target : seen.targets) {
      if (!target.confirmed) continue;
      bool true_one = false;
      for (std::size_t i = 0; clip.with() && i < kIntruders.size(); ++i) {
        const Vector3d p_CT = X_NC.Inverse() * clip.PlaceOf(i, t);
        const double half_angle = std::asin(kIntruders[i].radius_m / p_CT.norm());
        const double off = std::acos(std::clamp(target.seen.cone.axis.dot(p_CT.normalized()), -1.0, 1.0));
        if (off > half_angle + Radians(0.5)) continue;
        true_one = met[i] = true;
        Approach& a = result.approaches[i];
        if (a.confirmed_m == 0) a.confirmed_m = p_CT.norm();
        if (std::find(ids[i].begin(), ids[i].end(), target.id) == ids[i].end()) ids[i].push_back(target.id);
        a.bearing_deg.push_back(Degrees(off));
        a.diameter.push_back(target.seen.cone.half_angle / half_angle - 1);
        if (target.growth)
          a.growth.push_back((target.growth->rate_1_s - kSpeed_m_s / p_CT.norm()) / target.growth->sigma_1_s);
      }
      if (true_one) continue;
      any_false = true;
      if (known_false.emplace(target.id, true).second) {
        ++result.false_targets;
        Save(out,
             fmt::format("false_{}_{}_{}_{}_d{:.1f}_s{:.0f}_c{:.0f}", world, seed, clip.with(), k,
                         target.seen.diameter_px, target.seen.score, target.seen.contrast),
             image, {{target.seen.centre_px, {0, 0, 255}}});
      }
    }
    result.false_frames += any_false;
    std::vector<std::pair<Eigen::Vector2d, cv::Scalar>> marks;
    for (std::size_t i = 0; clip.with() && i < kIntruders.size(); ++i) {
      Approach& a = result.approaches[i];
      a.elevation_deg = Degrees(clip.elevation(i));
      if (a.confirmed_m > 0) ++a.frames_after, a.tracked_after += met[i];
      a.identities = static_cast<int>(ids[i].size());
      if (const auto uv = vision::Project(camera, X_NC.Inverse() * clip.PlaceOf(i, t)); uv && !met[i])
        marks.emplace_back(*uv, a.confirmed_m > 0 ? cv::Scalar(0, 255, 255) : cv::Scalar(255, 0, 255));
    }
    if (!marks.empty() && k % 40 == 39)
      Save(out, fmt::format("missed_{}_{}_{:03}", world, seed, k), image, marks);
  }
  return result;
}

struct Row {
  std::vector<double> range, tracked, bearing, diameter, growth_within;
  int approaches = 0, never = 0, identities = 0;
  void Add(const Approach& a) {
    ++approaches, never += a.confirmed_m == 0, identities += a.identities;
    range.push_back(a.confirmed_m);
    if (a.frames_after > 0) tracked.push_back(static_cast<double>(a.tracked_after) / a.frames_after);
    bearing.insert(bearing.end(), a.bearing_deg.begin(), a.bearing_deg.end());
    for (const double d : a.diameter) diameter.push_back(std::abs(d));
    for (const double g : a.growth) growth_within.push_back(std::abs(g) <= 2 ? 1 : 0);
  }
  void Print(const std::string& name) const {
    fmt::print(
        "| {:<34} | {:8} | {:5} | {:8.1f} {:8.1f} | {:9.3f} | {:7.3f} {:7.3f} | {:8.1f} | {:8.2f} | {:5.2f} "
        "|\n",
        name, approaches, never, Quantile(range, 0.5), Quantile(range, 0.1), Mean(tracked),
        Quantile(bearing, 0.5), Quantile(bearing, 0.95), 100 * Quantile(diameter, 0.5), Mean(growth_within),
        static_cast<double>(identities) / std::max(1, approaches));
  }
};

}  // namespace

void BenchContrast(std::uint64_t first_seed, std::uint64_t last_seed, int jobs,
                   const std::filesystem::path& out, std::vector<records::Figure>& table) {
  last_seed = std::min(last_seed, first_seed + 4);
  struct Piece {
    const char* world;
    std::uint64_t seed;
    bool with;
  };
  std::vector<Piece> pieces;
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed)
    for (const char* world : kWorlds)
      for (const bool with : {true, false}) pieces.push_back({world, seed, with});
  std::vector<ClipResult> results(pieces.size());
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  InParallel(pieces.size(), jobs, "contrast", "clips", [&](std::size_t i) {
    const Piece& p = pieces[i];
    results[i] = Fly(Clip(p.world, p.seed, p.with), p.world, p.seed, out);
  });
  cv::setNumThreads(threads);

  fmt::print(
      "| {:<34} | approach | never | first at m 50 % 10 % | tracked | bearing deg 50 % 95 % | size % 50 % | "
      "growth in 2 sigma | ids |\n",
      "landscape, size, colour");
  Row all, hidden;
  std::map<std::string, Row> by_size, by_elevation;
  std::vector<double> ms;
  for (const char* world : kWorlds)
    for (std::size_t i = 0; i < kIntruders.size(); ++i) {
      Row row;
      for (std::size_t k = 0; k < pieces.size(); ++k) {
        if (!pieces[k].with || pieces[k].world != world) continue;
        const Approach& a = results[k].approaches[i];
        if (a.min_open < 1) {
          hidden.Add(a);
          continue;
        }
        row.Add(a), all.Add(a);
        by_size[fmt::format("all, {:g} m", 2 * kIntruders[i].radius_m)].Add(a);
        by_elevation[a.elevation_deg < 4   ? "all, 1 to 4 deg high"
                     : a.elevation_deg < 8 ? "all, 4 to 8 deg high"
                                           : "all, 8 to 25 deg high"]
            .Add(a);
      }
      row.Print(fmt::format("{}, {:g} m, {}", world, 2 * kIntruders[i].radius_m, kIntruders[i].colour));
    }
  for (const auto& [name, row] : by_size) row.Print(name);
  for (const auto& [name, row] : by_elevation) row.Print(name);
  all.Print("all");
  hidden.Print("not before the open sky throughout");
  fmt::print("\n| {:<14} | clips       | minutes | false targets | a minute | images with one |\n",
             "landscape");
  double empty_minutes = 0;
  int empty_false = 0;
  for (const char* world : kWorlds)
    for (const bool with : {true, false}) {
      double minutes = 0;
      int targets = 0, frames = 0;
      for (std::size_t k = 0; k < pieces.size(); ++k) {
        if (pieces[k].with != with || pieces[k].world != world) continue;
        minutes += results[k].sky_seconds / 60, targets += results[k].false_targets,
            frames += results[k].false_frames;
        ms.insert(ms.end(), results[k].ms.begin(), results[k].ms.end());
      }
      if (!with) empty_minutes += minutes, empty_false += targets;
      fmt::print("| {:<14} | {:<11} | {:7.2f} | {:13} | {:8.2f} | {:15} |\n", world,
                 with ? "six targets" : "empty sky", minutes, targets, targets / std::max(1e-9, minutes),
                 frames);
    }

  for (const auto& [name, row] : by_size) {
    const bool small = name.find("0.5") != std::string::npos;
    table.push_back({name + ": range when first confirmed, median", Quantile(row.range, 0.5), "m",
                     small ? 25.0 : 45.0, true, ""});
    table.push_back({name + ": range when first confirmed, 10th percentile", Quantile(row.range, 0.1), "m",
                     small ? 12.0 : 25.0, true, ""});
  }
  table.push_back({"tracked after it, mean", Mean(all.tracked), "share", 0.9, true, ""});
  table.push_back({"bearing in C, median error", Quantile(all.bearing, 0.5), "deg", 0.1, false, ""});
  table.push_back({"growth within 2 sigma", Mean(all.growth_within), "share", 0.9, true, ""});
  table.push_back(
      {"false targets in empty sky", empty_false / std::max(1e-9, empty_minutes), "1/min", 0.2, false, ""});
  table.push_back({"time, mean a frame", Mean(ms), "ms", 3, false, ""});
  table.push_back({"time, 99th percentile", Quantile(ms, 0.99), "ms", {}, false, ""});
}

}  // namespace kestrel::bench
