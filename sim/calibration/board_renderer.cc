// SPDX-License-Identifier: Apache-2.0
#include "sim/calibration/board_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>

#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "sim/world/mjcf.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxSide_px = 8192;    // of an image that is drawn
constexpr double kEdge_px = 4;       // no corner of a chessboard nearer to the edge of the image
constexpr double kMinFacing = 0.35;  // cosine between a board's normal and the ray to it
// Along the sides of a square or disc of a board that is found whole only, and of a tag or marker.
constexpr double kMinSquare_px = 11, kMinTag_px = 22;

// T is MuJoCo's world: both have z up and out of the picture.
const Pose kX_NT{Eigen::Quaterniond(0, 1, 0, 0), Vector3d::Zero()};

ModelPtr MakeBoardModel(const vision::Board& board) {
  constexpr double kThickness_m = 0.01;
  const vision::BoardPicture picture = vision::DrawBoard(board);
  cv::Mat grey;  // print is neither white nor black
  picture.grey.convertTo(grey, CV_8U, 190.0 / 255, 30);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", grey, png);
  const Vector2d middle = (picture.sheet.low + picture.sheet.high) / 2;
  const Vector2d half = (picture.sheet.high - picture.sheet.low) / 2;
  // The board shines by itself, all of it alike: no light falls on it.
  const std::string mjcf = fmt::format(
      R"(<mujoco>
  <visual><headlight active="0"/></visual>
  <asset>
    <texture name="wall" type="skybox" builtin="flat" rgb1="0.4 0.4 0.4" rgb2="0.4 0.4 0.4" width="16" height="96"/>
    <texture name="board" type="2d" file="board.png"/>
    <material name="board" texture="board" emission="1" specular="0" shininess="0" reflectance="0"/>
  </asset>
  <worldbody>
    <geom name="board" type="box" pos="{} {} {}" size="{} {} {}" material="board"/>
  </worldbody>
</mujoco>)",
      middle.x(), middle.y(), -kThickness_m / 2, half.x(), half.y(), kThickness_m / 2);
  CompiledModel compiled = CompileMjcf(mjcf, {{"board.png", std::string(png.begin(), png.end())}});
  if (!compiled.model)
    throw std::runtime_error(fmt::format("The board does not load: {}.", compiled.message));
  return std::move(compiled.model);
}

// Nothing is known of the parameters of an added model that could make it finer.
int FineFor(const vision::CameraModel& camera) {
  if (std::holds_alternative<vision::AddedModel>(camera)) return 1;
  return std::clamp(kMaxSide_px / std::max(vision::WidthPx(camera), vision::HeightPx(camera)), 1, 4);
}

// How far apart in the image the ends of a short length of the board are at a pose, along its x and y, px;
// none where the board cannot be seen.
struct Seen {
  Vector2d pixel;
  double min_px = 0;
};
std::optional<Seen> SeenAt(const vision::CameraModel& camera, const Pose& X_CT, const Vector2d& place,
                           double length_m) {
  const Vector3d p_CQ = X_CT * Vector3d(place.x(), place.y(), 0);
  const double facing = -(X_CT.R * Vector3d::UnitZ()).dot(p_CQ.normalized());
  Eigen::Matrix<double, 2, 3> d_point;
  const auto uv = vision::Project(camera, p_CQ, &d_point);
  if (!uv || !(facing > kMinFacing)) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> axes = X_CT.R.toRotationMatrix().leftCols<2>() * length_m;
  // The smaller height of the parallelogram that a square of that length is seen as.
  const Eigen::Matrix2d sides = d_point * axes;
  const double longest = std::max(sides.col(0).norm(), sides.col(1).norm());
  return Seen{*uv, std::abs(sides.determinant()) / std::max(longest, 1e-12)};
}

bool InView(const vision::CameraModel& camera, const vision::Board& board,
            const std::vector<Vector2d>& places, const Pose& X_CT) {
  const bool whole = vision::IsSeenWholeOnly(board);
  const double length = vision::DetailOf(board);
  std::size_t seen = 0;
  for (const Vector2d& place : places) {
    const auto at = SeenAt(camera, X_CT, place, length);
    const bool good = at && at->min_px > (whole ? kMinSquare_px : kMinTag_px) && at->pixel.x() > kEdge_px &&
                      at->pixel.y() > kEdge_px && at->pixel.x() < vision::WidthPx(camera) - 1 - kEdge_px &&
                      at->pixel.y() < vision::HeightPx(camera) - 1 - kEdge_px;
    if (whole && !good) return false;
    seen += good;
  }
  if (!whole) return 3 * seen > places.size();
  // A detector wants the white around it too.
  const vision::Rectangle sheet = vision::Sheet(board);
  for (const Vector2d& corner : {sheet.low, sheet.high, Vector2d(sheet.low.x(), sheet.high.y()),
                                 Vector2d(sheet.high.x(), sheet.low.y())}) {
    if (!vision::Project(camera, X_CT * Vector3d(corner.x(), corner.y(), 0))) return false;
  }
  return true;
}

}  // namespace

std::vector<Pose> SpreadPoses(const vision::CameraModel& camera, const vision::Board& board, int count,
                              std::uint64_t seed) {
  constexpr int kTries = 400, kMostPlaces = 20000;
  const std::vector<Vector2d> places = vision::Corners(board);
  const Vector2d size = places.back() - places.front();
  RandomStream random(seed, "board poses");
  // Places that fill the plane evenly however many there are: the multiples of the plastic number's powers
  // (M. Roberts, 2018).
  constexpr double kPlastic = 1.324717957244746;
  Vector2d share(random.Uniform(0, 1), random.Uniform(0, 1));
  std::vector<Pose> poses;
  for (int place = 0; static_cast<int>(poses.size()) < count; ++place) {
    if (place == kMostPlaces || (place == 200 && poses.empty())) {
      const bool whole = vision::IsSeenWholeOnly(board);
      throw std::runtime_error(
          fmt::format("no place before this camera of {} x {} pixels, whose lens sees {:.1f} deg from its "
                      "axis, shows {} of "
                      "the {} with {} of {:g} px at least; valid: a wider lens, more pixels, or a board of "
                      "fewer and larger "
                      "{}",
                      vision::WidthPx(camera), vision::HeightPx(camera), Degrees(vision::MaxAngle(camera)),
                      whole ? "all" : "a third", vision::Describe(board), whole ? "squares" : "tags",
                      whole ? kMinSquare_px : kMinTag_px, whole ? "squares" : "tags"));
    }
    share.x() = std::fmod(share.x() + 1 / kPlastic, 1.0);
    share.y() = std::fmod(share.y() + 1 / (kPlastic * kPlastic), 1.0);
    const auto ray = vision::Ray(
        camera, {share.x() * (vision::WidthPx(camera) - 1), share.y() * (vision::HeightPx(camera) - 1)});
    Eigen::Matrix<double, 2, 3> d_point;
    if (!ray || !vision::Project(camera, *ray, &d_point)) continue;
    const double px_per_rad = d_point.norm() / std::numbers::sqrt2;
    const double image_px = std::min(vision::WidthPx(camera), vision::HeightPx(camera));
    for (int i = 0; i < kTries; ++i) {
      // How large the board is in the image, from a quarter of it to more than all.
      const double extent_px = image_px * std::exp(random.Uniform(std::log(0.2), std::log(1.8)));
      const double range = px_per_rad * size.norm() / extent_px;
      const double about = random.Uniform(-std::numbers::pi, std::numbers::pi),
                   tilt = random.Uniform(0, 0.87);
      const double roll = random.Uniform(-std::numbers::pi, std::numbers::pi);
      const double corner = random.Uniform(0, static_cast<double>(places.size()));
      const Vector2d& anchor = places[static_cast<std::size_t>(corner)];
      Pose X_CT;
      X_CT.R = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), -*ray) *
               ExpRotation(tilt * Vector3d(std::cos(about), std::sin(about), 0)) * ExpRotation({0, 0, roll});
      X_CT.p = range * *ray - X_CT.R * Vector3d(anchor.x(), anchor.y(), 0);
      if (!InView(camera, board, places, X_CT)) continue;
      poses.push_back(X_CT);
      break;
    }
  }
  return poses;
}

vision::CameraModel Refined(const vision::CameraModel& camera, int n) {
  vision::CameraModel fine = camera;
  std::visit(
      [n](auto& c) {
        c.width_px *= n, c.height_px *= n;
        if constexpr (requires { c.fx; }) c.fx *= n, c.fy *= n;
        c.cx = n * c.cx + (n - 1) / 2.0, c.cy = n * c.cy + (n - 1) / 2.0;
        if constexpr (requires { c.skew; }) c.skew *= n;
      },
      fine);
  return fine;
}

BoardRenderer::BoardRenderer(const vision::Board& board, const vision::CameraModel& camera,
                             const BoardRendererOptions& options)
    : options_(options),
      fine_(FineFor(camera)),
      size_(vision::WidthPx(camera), vision::HeightPx(camera)),
      model_(MakeBoardModel(board)),
      data_(MakeData(model_.get())),
      renderer_(model_.get(), Refined(camera, fine_),
                {.backend = options.backend, .threads = options.threads}) {
  mj_forward(model_.get(), data_.get());
}

cv::Mat BoardRenderer::Render(const Pose& X_CT, std::uint64_t seed, std::int64_t number) {
  const cv::Mat bgr = renderer_.Render(data_.get(), kX_NT * X_CT.Inverse());
  cv::Mat fine, light;
  cv::extractChannel(bgr, fine, 1);  // all three are alike
  fine.convertTo(fine, CV_32F);
  if (options_.blur_px > 0) cv::GaussianBlur(fine, fine, {}, options_.blur_px * fine_);
  cv::resize(fine, light, size_, 0, 0, cv::INTER_AREA);
  RandomStream random(RandomStream::Mix(seed) ^ static_cast<std::uint64_t>(number), "board noise");
  cv::Mat image(size_, CV_8UC1);
  for (int v = 0; v < size_.height; ++v) {
    for (int u = 0; u < size_.width; ++u) {
      const double value = light.at<float>(v, u) + options_.noise_grey * random.Normal();
      image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(value);
    }
  }
  return image;
}

}  // namespace kestrel::sim
