// SPDX-License-Identifier: Apache-2.0
#include "bench/render/bench_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <barrier>
#include <chrono>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "base/statistics.h"
#include "bench/render/drawer.h"
#include "bench/render/render_world.h"
#include "sim/camera/renderer.h"
#include "vision/write_image.h"

namespace kestrel::bench {
namespace {

using std::chrono::steady_clock;

constexpr double kSecondsOfEach = 2;
constexpr int kRounds = 3;  // at least, over all poses, beside the first, which warms up

double Seconds(steady_clock::time_point from) {
  return std::chrono::duration<double>(steady_clock::now() - from).count();
}

// Frames a second of all together. Each of them has a world and a renderer of its own, on a thread of its own.
double Rate(const BenchCamera& bench, const sim::RenderOptions& options, std::uint64_t first_seed,
            std::uint64_t last_seed, int at_once, const char* scenario) {
  std::barrier all_warm(at_once), all_stop(at_once);
  std::atomic<bool> enough = false;
  std::atomic<long> frames = 0;
  std::atomic<double> seconds = 0;
  std::vector<std::jthread> threads;
  for (int k = 0; k < at_once; ++k)
    threads.emplace_back([&, k] {
      World world(scenario);
      sim::Renderer renderer(world.model(), bench.camera, options);
      const auto round = [&] {
        for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed)
          for (const Height height : kHeights) {
            const Pose X_NC = world.Put(AircraftPose(bench, height, seed));
            renderer.Render(world.data(), X_NC);
          }
        return static_cast<long>((last_seed - first_seed + 1) * kHeights.size());
      };
      round();
      all_warm.arrive_and_wait();
      const auto start = steady_clock::now();
      for (int rounds = 0; rounds < kRounds || !enough; ++rounds) {
        frames += round();
        if (Seconds(start) > kSecondsOfEach) enough = true;
      }
      all_stop.arrive_and_wait();  // contexts end while nobody draws
      if (k == 0) seconds = Seconds(start);
    });
  threads.clear();
  return static_cast<double>(frames) / seconds;
}

void Speed(const BenchCamera& bench, const std::string& size, std::uint64_t first_seed,
           std::uint64_t last_seed, int jobs, const std::string& opengl,
           std::vector<records::Figure>& table) {
  const auto add = [&](const std::string& what, const sim::RenderOptions& options, int at_once,
                       const char* scenario = "landing") {
    table.push_back({fmt::format("{} {}, {}", bench.name, size, what),
                     Rate(bench, options, first_seed, last_seed, at_once, scenario),
                     "frames/s",
                     {},
                     true,
                     ""});
  };
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  add("ray, one thread", {.backend = "ray"}, 1);
  add("ray, one thread, a landscape", {.backend = "ray"}, 1, "attitude_2");
  add(fmt::format("ray, {} threads", cores), {.backend = "ray", .threads = 0}, 1);
  add(opengl, {.backend = opengl}, 1);
  if (jobs == 1) return;
  add(fmt::format("ray, {} at once", jobs), {.backend = "ray"}, jobs);
  add(fmt::format("{}, {} at once", opengl, jobs), {.backend = opengl}, jobs);
}

// Of all colours of all pixels.
struct Difference {
  double sum = 0, values = 0, over_2 = 0;
  int worst = 0;
  void Add(const cv::Mat& a, const cv::Mat& b) {
    cv::Mat difference;
    cv::absdiff(a, b, difference);
    difference = difference.reshape(1);
    double most = 0;
    cv::minMaxLoc(difference, nullptr, &most);
    worst = std::max(worst, static_cast<int>(most));
    sum += cv::sum(difference)[0];
    values += static_cast<double>(difference.total());
    over_2 += cv::countNonZero(difference > 2);
  }
};

void AddRows(const std::string& name, const Difference& d, std::vector<records::Figure>& table) {
  if (d.values == 0) return;
  table.push_back({name + " differ, mean", d.sum / d.values, "grey levels", {}, false, ""});
  table.push_back({name + " differ by more than 2", d.over_2 / d.values, "share", {}, false, ""});
  table.push_back({name + " differ, the worst", static_cast<double>(d.worst), "grey levels", {}, false, ""});
}

void Differences(const std::string& scenario, const BenchCamera& bench, std::uint64_t first_seed,
                 std::uint64_t last_seed, const std::string& opengl, const std::filesystem::path& folder,
                 std::vector<records::Figure>& table) {
  const std::string other = opengl == "egl" ? "osmesa" : "egl";
  World world(scenario);
  Drawer<sim::Renderer> by_ray(world.model(), bench.camera, sim::RenderOptions{.backend = "ray"}),
      by_opengl(world.model(), bench.camera, sim::RenderOptions{.backend = opengl}),
      again(world.model(), bench.camera, sim::RenderOptions{.backend = opengl});
  Difference from_ray, from_other, from_again;
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed)
    for (std::size_t h = 0; h < kHeights.size(); ++h) {
      const Pose X_NC = world.Put(AircraftPose(bench, kHeights[h], seed));
      const cv::Mat drawn = by_opengl.Render(world.data(), X_NC), ray = by_ray.Render(world.data(), X_NC);
      from_ray.Add(drawn, ray);
      from_again.Add(drawn, again.Render(world.data(), X_NC));
      const auto file = [&](const std::string& by) {
        return folder / fmt::format("{}_{}_{}_{}_{}.png", scenario, bench.name, seed, h, by);
      };
      if (std::filesystem::exists(file(other)))
        from_other.Add(drawn, cv::imread(file(other).string(), cv::IMREAD_COLOR));
      vision::WriteImage(file(opengl), drawn);
      vision::WriteImage(file("ray"), ray);
    }
  const std::string name = scenario + ", " + bench.name + ", " + opengl;
  AddRows(name + " and ray", from_ray, table);
  AddRows(name + " and " + other, from_other, table);
  table.push_back(
      {name + " drawn again, the worst", static_cast<double>(from_again.worst), "grey levels", 0, false, ""});
}

}  // namespace

void BenchFrames(std::uint64_t first_seed, std::uint64_t last_seed, int jobs, const std::string& opengl,
                 const std::filesystem::path& folder, std::vector<records::Figure>& table) {
  std::filesystem::create_directories(folder);
  {
    World world("landing");
    for (const std::string& backend : {std::string("ray"), opengl})
      fmt::print("{}\n", Drawer<sim::Renderer>(world.model(), BenchCameras().front().camera,
                                               sim::RenderOptions{.backend = backend})
                             .drawing()
                             .name());
  }
  for (const BenchCamera& bench : BenchCameras())
    for (const char* const scenario : {"landing", "avoid", "survey_airfield"})
      Differences(scenario, bench, first_seed, last_seed, opengl, folder, table);
  for (BenchCamera& bench : BenchCameras()) {
    Speed(bench, "640 x 480", first_seed, last_seed, jobs, opengl, table);
    if (auto* pinhole = std::get_if<vision::Pinhole>(&bench.camera)) {
      const double finer = 1080.0 / pinhole->height_px;
      *pinhole = {1920, 1080, finer * pinhole->fx, finer * pinhole->fy, 959.5, 539.5};
      Speed(bench, "1920 x 1080", first_seed, last_seed, jobs, opengl, table);
    }
  }
}

}  // namespace kestrel::bench
