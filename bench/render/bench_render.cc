// SPDX-License-Identifier: Apache-2.0
#include "bench/render/bench_render.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/process/status_line.h"
#include "base/random.h"
#include "base/statistics.h"
#include "bench/render/agreement.h"
#include "bench/render/drawer.h"
#include "bench/render/peer_renderer.h"
#include "bench/render/render_world.h"
#include "geometry/tait_bryan.h"
#include "sim/camera/renderer.h"
#include "sim/world/frames.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::uint64_t kTurn = 5;

const sim::RenderOptions kByRay{.backend = "ray"};

void Speed(const BenchCamera& bench, World& world, const sim::RenderOptions& by_opengl,
           std::uint64_t first_seed, std::uint64_t last_seed, StatusLine& line,
           std::vector<records::Figure>& table) {
  Drawer<PeerRenderer> peer(world.model(), bench.camera, by_opengl.backend, 0, 1.0),
      coarse(world.model(), bench.camera, by_opengl.backend, 0, 0.5);
  Drawer<sim::Renderer> ray(world.model(), bench.camera, kByRay),
      opengl(world.model(), bench.camera, by_opengl);
  const PeerRenderer& faces = peer.drawing();
  const bool wide = faces.face_px() > 0;
  std::vector<double> smoothed_ms;
  {
    Drawer<PeerRenderer> smoothed(world.model(), bench.camera, by_opengl.backend,
                                  world.model()->vis.quality.offsamples, 1.0);
    for (std::size_t i = 0; i < 9; ++i) {
      const Pose X_NC = world.Put(AircraftPose(bench, kHeights[i % 3], first_seed));
      const double time_ms = smoothed.Time(world.data(), X_NC);
      if (i >= 3) smoothed_ms.push_back(time_ms);
      if (i >= 3) continue;  // the first ones warm up
      peer.Time(world.data(), X_NC), coarse.Time(world.data(), X_NC);
      ray.Time(world.data(), X_NC), opengl.Time(world.data(), X_NC);
    }
  }
  struct Times {
    std::vector<double> peer_ms, coarse_ms, ray_ms, opengl_ms;
  };
  Times all;
  for (std::size_t h = 0; h < kHeights.size(); ++h) {
    Times here;
    // Turn about, a few poses each: so that each is as warm as in a flight, and none has a quiet machine for
    // itself.
    for (std::uint64_t from = first_seed; from <= last_seed; from += kTurn) {
      const std::uint64_t until = std::min(from + kTurn - 1, last_seed);
      line.Show(fmt::format("{}, {}, speed: seed {} of {}..{}", bench.name, kHeightNames[h], from, first_seed,
                            last_seed));
      const auto turn = [&](auto& drawer, std::vector<double>& times_ms) {
        for (std::uint64_t seed = from; seed <= until; ++seed) {
          const Pose X_NC = world.Put(AircraftPose(bench, kHeights[h], seed));
          times_ms.push_back(drawer.Time(world.data(), X_NC));
        }
      };
      turn(peer, here.peer_ms), turn(ray, here.ray_ms), turn(opengl, here.opengl_ms);
      if (wide) turn(coarse, here.coarse_ms);
    }
    line.Clear();
    const auto both = [](const std::vector<double>& ms) {
      return fmt::format("{:.1f} {:.1f}", Quantile(ms, 0.5), Quantile(ms, 0.95));
    };
    fmt::print("{}, {}: ms a frame, median and 95th percentile: the peers' way {}, ray {}, OpenGL {}\n",
               bench.name, kHeightNames[h], both(here.peer_ms), both(here.ray_ms), both(here.opengl_ms));
    for (const auto times : {&Times::peer_ms, &Times::coarse_ms, &Times::ray_ms, &Times::opengl_ms})
      (all.*times).insert((all.*times).end(), (here.*times).begin(), (here.*times).end());
  }
  const std::string way = wide ? fmt::format("{} faces of {} px", faces.faces(), faces.face_px())
                               : std::string("MuJoCo's own way");
  const std::string coarse_way = fmt::format("{} faces of {} px", faces.faces(), faces.face_px() / 2);
  // The median of the ratios, pose by pose.
  const auto gain = [](const std::vector<double>& slow_ms, const std::vector<double>& fast_ms) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < fast_ms.size(); ++i) ratios.push_back(slow_ms[i] / fast_ms[i]);
    return Quantile(ratios, 0.5);
  };
  const double peer_rate = 1000 / Quantile(all.peer_ms, 0.5);
  const auto add = [&](const std::string& what, double value, const char* unit, std::optional<double> target,
                       const std::string& reference) {
    table.push_back({bench.name + ", " + what, value, unit, target, true, reference});
  };
  add(way, peer_rate, "frames/s", {}, "");
  if (wide) add(coarse_way, 1000 / Quantile(all.coarse_ms, 0.5), "frames/s", {}, "");
  add(way + ", MuJoCo's own samples", 1000 / Quantile(smoothed_ms, 0.5), "frames/s", {}, "");
  add("ray", 1000 / Quantile(all.ray_ms, 0.5), "frames/s",
      bench.frames_s > 0 ? std::optional(bench.frames_s) : std::nullopt, fmt::format("{:.3g}", peer_rate));
  add("ray, 95th percentile", Quantile(all.ray_ms, 0.95), "ms a frame", {}, "");
  add("ray over " + way, gain(all.peer_ms, all.ray_ms), "times", bench.times, "1");
  if (wide) add("ray over " + coarse_way, gain(all.coarse_ms, all.ray_ms), "times", {}, "1");
  add("OpenGL", 1000 / Quantile(all.opengl_ms, 0.5), "frames/s", {}, fmt::format("{:.3g}", peer_rate));
  add("OpenGL over " + way, gain(all.peer_ms, all.opengl_ms), "times", {}, "1");
}

sim::ModelPtr ModelOf(const std::string& xml) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "bench.xml", static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  char message[500] = "";
  sim::ModelPtr model(mj_loadXML("bench.xml", files.get(), message, sizeof message));
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(message);
  return model;
}

// A black world in which things show in their own colours.
sim::ModelPtr DarkRoom(const std::string& geoms) {
  return ModelOf(fmt::format(R"(<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset>
    <texture name="spot" type="2d" builtin="gradient" rgb1="1 1 1" rgb2="0 0 0" width="64" height="64"/>
    <material name="spot" texture="spot" specular="0"/>
    <material name="white" rgba="1 1 1 1" specular="0"/>
  </asset>
  <worldbody>{}</worldbody>
</mujoco>)",
                             geoms));
}

std::string PoseOf(const Pose& X_NG) {
  mjtNum qpos[7];
  sim::PoseToMujoco(X_NG, qpos);
  return fmt::format(R"(pos="{} {} {}" quat="{} {} {} {}")", qpos[0], qpos[1], qpos[2], qpos[3], qpos[4],
                     qpos[5], qpos[6]);
}

// Everywhere in the image where the lens shows something for some pixels around.
std::vector<Vector2d> Places(const vision::CameraModel& camera, double step_px, double around_px,
                             RandomStream& random) {
  std::vector<Vector2d> places;
  for (double v = around_px + 2; v < vision::HeightPx(camera) - around_px - 3; v += step_px) {
    for (double u = around_px + 2; u < vision::WidthPx(camera) - around_px - 3; u += step_px) {
      const Vector2d uv(u + random.Uniform(0, 1), v + random.Uniform(0, 1));
      bool shows = true;
      for (const double du : {-around_px, around_px})
        for (const double dv : {-around_px, around_px})
          shows = shows && vision::Ray(camera, uv + Vector2d(du, dv));
      if (shows) places.push_back(uv);
    }
  }
  return places;
}

// A flat round spot, face on, that fades towards its rim.
struct Spot {
  Pose X_CD;  // z along the ray
  double radius;
};

// Where the middle of its light belongs: the mean of where the model puts the texels of its picture, by their
// brightness and by how large they are there.
Vector2d MiddleOfLight(const vision::CameraModel& camera, const mjModel* model, const Spot& spot) {
  const int side = model->tex_width[0];
  const Eigen::Matrix<double, 3, 2> across = spot.X_CD.R.toRotationMatrix().leftCols<2>();
  Vector2d sum = Vector2d::Zero();
  double weights = 0;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const Vector3d p_DQ =
          spot.radius * Vector3d((2 * column + 1.0) / side - 1, (2 * row + 1.0) / side - 1, 0);
      if (p_DQ.norm() > spot.radius) continue;
      Eigen::Matrix<double, 2, 3> d_point;
      const Vector2d uv = *vision::Project(camera, spot.X_CD * p_DQ, &d_point);
      const double weight =
          model->tex_rgb[3 * (side * row + column)] * std::abs((d_point * across).determinant());
      sum += weight * uv, weights += weight;
    }
  }
  return sum / weights;
}

void Markers(const BenchCamera& bench, const sim::RenderOptions& by_opengl, std::uint64_t seed,
             std::vector<records::Figure>& table) {
  constexpr double kRadius_px = 6, kStep_px = 30;
  constexpr int kReach_px = 10;
  RandomStream random(seed, "bench render markers");
  const Pose X_NC{Eigen::Quaterniond(RotationFromTaitBryan({0.4, -0.9, 0.2})), {3, -2, -4}};
  std::vector<Spot> spots;
  std::string geoms;
  for (const Vector2d& uv : Places(bench.camera, kStep_px, kReach_px, random)) {
    Eigen::Matrix<double, 3, 2> d_pixel;
    const Vector3d ray = *vision::Ray(bench.camera, uv, &d_pixel);
    const double distance = 0.5 * std::pow(40, random.Uniform(0, 1));
    const double pixel_rad = std::sqrt(d_pixel.col(0).cross(d_pixel.col(1)).norm());
    spots.push_back({{Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), ray), distance * ray},
                     kRadius_px * pixel_rad * distance});
    geoms += fmt::format(R"(<geom type="cylinder" {} size="{} 1e-5" material="spot"/>)",
                         PoseOf(X_NC * spots.back().X_CD), spots.back().radius);
  }
  const sim::ModelPtr model = DarkRoom(geoms);
  const sim::DataPtr data = sim::MakeData(model.get());
  mj_forward(model.get(), data.get());
  for (const auto& [name, options] : {std::pair("ray", kByRay), std::pair("OpenGL", by_opengl)}) {
    cv::Mat grey;
    cv::extractChannel(Drawer<sim::Renderer>(model.get(), bench.camera, options).Render(data.get(), X_NC),
                       grey, 0);
    std::vector<double> errors;
    for (const Spot& spot : spots) {
      const Vector2d uv = MiddleOfLight(bench.camera, model.get(), spot);
      const cv::Point middle(static_cast<int>(std::lround(uv.x())), static_cast<int>(std::lround(uv.y())));
      const cv::Rect window =
          cv::Rect(middle.x - kReach_px, middle.y - kReach_px, 2 * kReach_px + 1, 2 * kReach_px + 1) &
          cv::Rect(0, 0, grey.cols, grey.rows);
      const cv::Moments m = cv::moments(grey(window));
      errors.push_back((Vector2d(m.m10 / m.m00 + window.x, m.m01 / m.m00 + window.y) - uv).norm());
    }
    table.push_back(
        {fmt::format("{}, {}: {} markers from Project, the farthest", bench.name, name, errors.size()),
         Quantile(errors, 1), "px", 0.05, false, ""});
  }
}

// White boxes against black, whose outlines are straight edges of theirs.
struct Box {
  Pose X_CG;
  Vector3d half;
};

// Where the edge crosses a line across it, from the middle of the line, px: its ends are white and black, and
// between them there is as much light as the edge lets in. None if another thing is in the way.
std::optional<double> Crossing(const cv::Mat& grey, const Vector2d& middle, const Vector2d& outwards) {
  constexpr double kReach_px = 4, kStep_px = 0.125, kPlain_px = 1.5;
  double light = 0;
  for (double s = -kReach_px + kStep_px / 2; s < kReach_px; s += kStep_px) {
    const Vector2d at = middle + s * outwards;
    const int u = static_cast<int>(std::floor(at.x())), v = static_cast<int>(std::floor(at.y()));
    if (u < 0 || v < 0 || u + 1 >= grey.cols || v + 1 >= grey.rows) return std::nullopt;
    const double right = at.x() - u, down = at.y() - v;
    const double value =
        (1 - down) * ((1 - right) * grey.at<uchar>(v, u) + right * grey.at<uchar>(v, u + 1)) +
        down * ((1 - right) * grey.at<uchar>(v + 1, u) + right * grey.at<uchar>(v + 1, u + 1));
    if (s < -kReach_px + kPlain_px && value < 254) return std::nullopt;
    if (s > kReach_px - kPlain_px && value > 1) return std::nullopt;
    light += value / 255 * kStep_px;
  }
  return light - kReach_px;
}

struct EdgeErrors {
  std::vector<double> between, ray, opengl;  // of each edge, the mean along it, px
};

void EdgesOf(const Box& box, const vision::CameraModel& camera, const cv::Mat& by_ray,
             const cv::Mat& by_opengl, EdgeErrors& errors) {
  const Vector3d eye_G = box.X_CG.Inverse().p;
  const auto faces_eye = [&](int axis, double side) { return side * eye_G[axis] > box.half[axis]; };
  for (int along = 0; along < 3; ++along) {
    const int b = (along + 1) % 3, c = (along + 2) % 3;
    for (const double side_b : {-1.0, 1.0}) {
      for (const double side_c : {-1.0, 1.0}) {
        if (faces_eye(b, side_b) == faces_eye(c, side_c)) continue;  // not on the outline
        const auto point = [&](double share) {
          Vector3d p;
          p[along] = share * box.half[along], p[b] = side_b * box.half[b], p[c] = side_c * box.half[c];
          return vision::Project(camera, box.X_CG * p);
        };
        const auto middle = vision::Project(camera, box.X_CG.p);
        double between = 0, ray = 0, opengl = 0;
        int crossings = 0;
        for (double share = -0.8; share <= 0.8; share += 0.02) {
          const auto before = point(share - 0.01), here = point(share), after = point(share + 0.01);
          if (!middle || !before || !here || !after) continue;
          const Vector2d tangent = (*after - *before).normalized();
          Vector2d outwards(-tangent.y(), tangent.x());
          if (outwards.dot(*here - *middle) < 0) outwards = -outwards;
          const auto at_ray = Crossing(by_ray, *here, outwards),
                     at_opengl = Crossing(by_opengl, *here, outwards);
          if (!at_ray || !at_opengl) continue;
          between += *at_ray - *at_opengl, ray += *at_ray, opengl += *at_opengl;
          ++crossings;
        }
        if (crossings < 40) continue;
        errors.between.push_back(std::abs(between / crossings));
        errors.ray.push_back(std::abs(ray / crossings));
        errors.opengl.push_back(std::abs(opengl / crossings));
      }
    }
  }
}

// Where both draw the straight edges of boxes: each edge as a whole, since OpenGL's steps are pixels.
void Edges(const BenchCamera& bench, const sim::RenderOptions& by_opengl, std::uint64_t first_seed,
           std::uint64_t last_seed, StatusLine& line, std::vector<records::Figure>& table) {
  sim::RenderOptions smooth = by_opengl;
  smooth.samples = 4;
  const Pose X_NC{Eigen::Quaterniond(RotationFromTaitBryan({0.4, -0.9, 0.2})), {3, -2, -4}};
  EdgeErrors errors;
  for (std::uint64_t seed = first_seed; seed <= last_seed; ++seed) {
    line.Show(fmt::format("{}, edges: seed {} of {}..{}", bench.name, seed, first_seed, last_seed));
    RandomStream random(seed, "bench render edges");
    std::vector<Box> boxes;
    std::string geoms;
    for (const Vector2d& uv : Places(bench.camera, 110, 30, random)) {
      Eigen::Matrix<double, 3, 2> d_pixel = Eigen::Matrix<double, 3, 2>::Zero();
      const Vector3d ray = *vision::Ray(bench.camera, uv, &d_pixel);
      const double distance = random.Uniform(2, 10);
      const double pixel = distance * std::sqrt(d_pixel.col(0).cross(d_pixel.col(1)).norm());
      Box box{{Eigen::Quaterniond(RotationFromTaitBryan(
                   {random.Uniform(-3, 3), random.Uniform(-1, 1), random.Uniform(-3, 3)})),
               distance * ray},
              {}};
      for (int i = 0; i < 3; ++i) box.half[i] = pixel * random.Uniform(15, 30);
      const Vector3d half = box.half;
      geoms += fmt::format(R"(<geom type="box" {} size="{} {} {}" material="white"/>)",
                           PoseOf(X_NC * box.X_CG), half.x(), half.y(), half.z());
      boxes.push_back(box);
    }
    const sim::ModelPtr model = DarkRoom(geoms);
    const sim::DataPtr data = sim::MakeData(model.get());
    mj_forward(model.get(), data.get());
    cv::Mat seen_by_ray, seen_by_opengl;
    cv::extractChannel(Drawer<sim::Renderer>(model.get(), bench.camera, kByRay).Render(data.get(), X_NC),
                       seen_by_ray, 0);
    cv::extractChannel(Drawer<sim::Renderer>(model.get(), bench.camera, smooth).Render(data.get(), X_NC),
                       seen_by_opengl, 0);
    for (const Box& box : boxes) EdgesOf(box, bench.camera, seen_by_ray, seen_by_opengl, errors);
  }
  line.Clear();
  const auto name = [&](const char* what) {
    return fmt::format("{}, {} edges, {}", bench.name, errors.between.size(), what);
  };
  table.push_back(
      {name("ray from OpenGL, 95th percentile"), Quantile(errors.between, 0.95), "px", 0.1, false, ""});
  table.push_back(
      {name("ray from Project, 95th percentile"), Quantile(errors.ray, 0.95), "px", {}, false, ""});
  table.push_back(
      {name("OpenGL from Project, 95th percentile"), Quantile(errors.opengl, 0.95), "px", {}, false, ""});
}

}  // namespace

void BenchRender(std::uint64_t first_seed, std::uint64_t last_seed, const std::string& opengl,
                 std::vector<records::Figure>& table) {
  // Mesa's software renderer draws with as many threads as there are cores, unless told before it starts.
  setenv("LP_NUM_THREADS", "0", 0);
  const sim::RenderOptions by_opengl{.backend = opengl};
  World world("landing");
  StatusLine line("render");
  for (const BenchCamera& bench : BenchCameras()) {
    Speed(bench, world, by_opengl, first_seed, last_seed, line, table);
    line.Show(bench.name + ", agreement");
    BenchAgreement(bench, world, by_opengl, first_seed, last_seed, table);
    line.Clear();
    Edges(bench, by_opengl, first_seed, last_seed, line, table);
    Markers(bench, by_opengl, first_seed, table);
  }
}

}  // namespace kestrel::bench
