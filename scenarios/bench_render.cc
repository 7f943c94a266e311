// SPDX-License-Identifier: Apache-2.0
#include "scenarios/bench_render.h"

#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <thread>

#include "geometry/tait_bryan.h"
#include "scenarios/peer_renderer.h"
#include "scenarios/scenario.h"
#include "sim/frames.h"
#include "sim/random.h"
#include "sim/renderer.h"
#include "vision/calibration_file.h"

namespace kestrel {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct BenchCamera {
  std::string name;
  CameraModel camera;
  double horizon_tilt_deg;  // nose up, so that the horizon is well in view of this camera that looks down
  // What is asked: times as fast as the peers, and frames a second.
  double times, frames_s;
};

std::vector<BenchCamera> BenchCameras() {
  Mistakes mistakes;
  const auto load = [&](const char* name) {
    return LoadCamera(Root() / "models" / "cameras" / (std::string(name) + ".yaml"), mistakes);
  };
  std::vector<BenchCamera> cameras{{"catadioptric", load("hyperbolic_mirror"), 15, 15, 200},
                                   {"fisheye", load("fisheye"), 40, 12, 0},
                                   {"pinhole", load("thesis_6mm"), 78, 4, 0}};
  mistakes.ThrowIfAny();
  return cameras;
}

void Progress(const std::string& what) {
  if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[K{}", what);
}

double Quantile(std::vector<double> values, double q) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}
double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}
double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// A thread that does as it is told: OpenGL's context belongs to one, and each who draws has its own.
class Hand {
 public:
  Hand() : thread_([this] { Work(); }) {}
  ~Hand() {
    Give({});
    thread_.join();
  }
  template <class Function>
  auto Do(Function function) {
    std::packaged_task<decltype(function())()> task(std::move(function));
    auto result = task.get_future();
    Give([&] { task(); });
    return result.get();
  }

 private:
  void Give(std::function<void()> task) {
    {
      const std::lock_guard lock(mutex_);
      task_ = std::move(task);
      given_ = true;
    }
    wake_.notify_one();
  }
  void Work() {
    for (;;) {
      std::function<void()> task;
      {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [&] { return given_; });
        task = std::move(task_);
        given_ = false;
      }
      if (!task) return;
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::function<void()> task_;
  bool given_ = false;
  std::thread thread_;
};

// One who draws, on a thread of its own.
template <class Drawing>
class Drawer {
 public:
  template <class... Arguments>
  explicit Drawer(const Arguments&... arguments) {
    hand_.Do([&] { drawing_ = std::make_unique<Drawing>(arguments...); });
  }
  ~Drawer() {
    hand_.Do([&] { drawing_.reset(); });
  }
  cv::Mat Render(const mjData* data, const Pose& X_NC) {
    return hand_.Do([&] { return drawing_->Render(data, X_NC); });
  }
  Surfaces See(const mjData* data, const Pose& X_NC) {
    return hand_.Do([&] { return drawing_->See(data, X_NC); });
  }
  // Milliseconds of processor time, of all threads together.
  double Time(const mjData* data, const Pose& X_NC) {
    const auto now_ms = [] {
      timespec t;
      clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
      return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
    };
    const double start = now_ms();
    Render(data, X_NC);
    return now_ms() - start;
  }

 private:
  Hand hand_;
  std::unique_ptr<Drawing> drawing_;
};

// Where the aircraft is: near the ground, at 5 m, at 20 m with the horizon in view.
enum class Height { kNear, kMiddle, kHigh };
constexpr std::array kHeights{Height::kNear, Height::kMiddle, Height::kHigh};
constexpr std::array kHeightNames{"0.4 to 1 m", "5 m", "20 m, horizon"};

Pose AircraftPose(const BenchCamera& camera, Height height, std::uint64_t seed) {
  RandomStream random(seed, "bench render");
  const double side = height == Height::kNear ? 0.5 : height == Height::kMiddle ? 4 : 25;
  const double up = height == Height::kNear ? random.Uniform(0.4, 1) : height == Height::kMiddle ? 5 : 20;
  const double tilt = height == Height::kHigh ? camera.horizon_tilt_deg : 0;
  const TaitBryan angles{.yaw = Radians(random.Uniform(-180, 180)),
                         .pitch = Radians(tilt + random.Uniform(-8, 8)),
                         .roll = Radians(random.Uniform(-8, 8))};
  return {Eigen::Quaterniond(RotationFromTaitBryan(angles)),
          {random.Uniform(-side, side), random.Uniform(-side, side), -up}};
}

// The landing's world with the aircraft somewhere in it.
class World {
 public:
  World()
      : loaded_(LoadScenario("landing")),
        model_(MakeModel(loaded_.simulator.scene)),
        data_(MakeData(model_.get())) {}
  const mjModel* model() const { return model_.get(); }
  const mjData* data() const { return data_.get(); }
  Pose Put(const Pose& X_NB) {  // gives the pose of the camera
    const int joint = model_->body_jntadr[mj_name2id(model_.get(), mjOBJ_BODY, "vehicle")];
    PoseToMujoco(X_NB, data_->qpos + model_->jnt_qposadr[joint]);
    mj_forward(model_.get(), data_.get());
    return X_NB * MountPose(loaded_.simulator.mount);
  }

 private:
  LoadedScenario loaded_;
  ModelPtr model_;
  DataPtr data_;
};

const RenderOptions kByRay{.backend = "ray"}, kByOpenGl{.backend = "osmesa"};

void Speed(const BenchCamera& bench, World& world, std::uint64_t first_seed, std::uint64_t last_seed,
           std::vector<Figure>& table) {
  const int mujoco_samples = world.model()->vis.quality.offsamples;
  Drawer<PeerRenderer> peer(world.model(), bench.camera, 0);
  Drawer<Renderer> ray(world.model(), bench.camera, kByRay), opengl(world.model(), bench.camera, kByOpenGl);
  std::vector<double> smoothed_ms;
  {
    Drawer<PeerRenderer> smoothed(world.model(), bench.camera, mujoco_samples);
    for (int i = 0; i < 6; ++i) {
      const Pose X_NC = world.Put(AircraftPose(bench, kHeights[i % 3], first_seed));
      for (auto* const each : {&peer, &smoothed}) each->Render(world.data(), X_NC);
      ray.Render(world.data(), X_NC);
      opengl.Render(world.data(), X_NC);
      if (i >= 3) smoothed_ms.push_back(smoothed.Time(world.data(), X_NC));
    }
  }
  struct Times {
    std::vector<double> peer_ms, ray_ms, opengl_ms, ray_gain, opengl_gain;
  };
  Times all;
  for (std::size_t h = 0; h < kHeights.size(); ++h) {
    Times here;
    for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed) {
      Progress(fmt::format("{}, {}, speed: seed {} of {}..{}", bench.name, kHeightNames[h], seed, first_seed,
                           last_seed));
      const Pose X_NC = world.Put(AircraftPose(bench, kHeights[h], seed));
      here.peer_ms.push_back(peer.Time(world.data(), X_NC));
      here.ray_ms.push_back(ray.Time(world.data(), X_NC));
      here.ray_gain.push_back(here.peer_ms.back() / here.ray_ms.back());
      here.opengl_ms.push_back(opengl.Time(world.data(), X_NC));
      here.opengl_gain.push_back(here.peer_ms.back() / here.opengl_ms.back());
    }
    Progress("");
    fmt::print(
        "{}, {}: ms a frame, median and 95th percentile: peers' way {:.1f} {:.1f}, ray {:.2f} {:.2f}, OpenGL "
        "{:.1f} {:.1f}\n",
        bench.name, kHeightNames[h], Quantile(here.peer_ms, 0.5), Quantile(here.peer_ms, 0.95),
        Quantile(here.ray_ms, 0.5), Quantile(here.ray_ms, 0.95), Quantile(here.opengl_ms, 0.5),
        Quantile(here.opengl_ms, 0.95));
    const auto append = [](std::vector<double>& to, const std::vector<double>& more) {
      to.insert(to.end(), more.begin(), more.end());
    };
    append(all.peer_ms, here.peer_ms), append(all.ray_ms, here.ray_ms), append(all.opengl_ms, here.opengl_ms);
    append(all.ray_gain, here.ray_gain), append(all.opengl_gain, here.opengl_gain);
  }
  const std::string peers = fmt::format("{:.3g}", 1000 / Quantile(all.peer_ms, 0.5));
  const auto name = [&](const char* what) { return fmt::format("{} 640x480, {}", bench.name, what); };
  table.push_back({name("peers' way, frames/s"), 1000 / Quantile(all.peer_ms, 0.5), "1/s", {}, true, ""});
  table.push_back({name("peers' way with MuJoCo's own samples, frames/s"),
                   1000 / Quantile(smoothed_ms, 0.5),
                   "1/s",
                   {},
                   true,
                   ""});
  table.push_back({name("ray, frames/s"), 1000 / Quantile(all.ray_ms, 0.5), "1/s",
                   bench.frames_s > 0 ? std::optional(bench.frames_s) : std::nullopt, true, peers});
  table.push_back(
      {name("ray, 95th percentile of the time a frame"), Quantile(all.ray_ms, 0.95), "ms", {}, false, ""});
  table.push_back({name("ray, times as fast as the peers' way"), Quantile(all.ray_gain, 0.5), "times",
                   bench.times, true, "1"});
  table.push_back({name("OpenGL, frames/s"), 1000 / Quantile(all.opengl_ms, 0.5), "1/s", {}, true, peers});
  table.push_back({name("OpenGL, times as fast as the peers' way"),
                   Quantile(all.opengl_gain, 0.5),
                   "times",
                   {},
                   true,
                   "1"});
}

// Pixels without an edge of a thing within two: no other thing, and no crease, which the inverse of depth
// shows, straight on any plane.
cv::Mat AwayFromEdges(const Surfaces& seen) {
  cv::Mat geom, low, high;
  seen.geom.convertTo(geom, CV_32F);
  const cv::Mat around = cv::Mat::ones(5, 5, CV_8U);
  cv::erode(geom, low, around);
  cv::dilate(geom, high, around);
  return low == high & geom > -2;
}

// Mean absolute difference of the two renderers, grey levels of 255.
void Agreement(const BenchCamera& bench, World& world, std::uint64_t first_seed, std::uint64_t last_seed,
               std::vector<Figure>& table) {
  Drawer<Renderer> ray(world.model(), bench.camera, kByRay), opengl(world.model(), bench.camera, kByOpenGl);
  std::vector<double> differences;
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed) {
    Progress(fmt::format("{}, agreement: seed {} of {}..{}", bench.name, seed, first_seed, last_seed));
    for (const Height height : kHeights) {
      const Pose X_NC = world.Put(AircraftPose(bench, height, seed));
      cv::Mat difference;
      cv::absdiff(ray.Render(world.data(), X_NC), opengl.Render(world.data(), X_NC), difference);
      const cv::Mat mask =
          AwayFromEdges(ray.See(world.data(), X_NC)) & AwayFromEdges(opengl.See(world.data(), X_NC));
      const cv::Scalar mean = cv::mean(difference, mask);
      differences.push_back((mean[0] + mean[1] + mean[2]) / 3);
    }
  }
  Progress("");
  table.push_back({bench.name + ", ray and OpenGL differ away from edges, mean", Mean(differences),
                   "grey levels", 2, false, ""});
  table.push_back(
      {bench.name + ", the same, the worst image", Quantile(differences, 1), "grey levels", 2, false, ""});
}

}  // namespace

void BenchRender(std::uint64_t first_seed, std::uint64_t last_seed, std::vector<Figure>& table) {
  // Mesa's software renderer draws with as many threads as there are cores, unless told before it starts.
  setenv("LP_NUM_THREADS", "0", 0);
  World world;
  for (const BenchCamera& bench : BenchCameras()) {
    Speed(bench, world, first_seed, last_seed, table);
    Agreement(bench, world, first_seed, last_seed, table);
  }
}

}  // namespace kestrel
