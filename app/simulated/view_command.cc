// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/view_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/option/bits_option.h"
#include "app/option/one_of.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/print_note.h"
#include "base/user_file.h"
#include "flight/simulated/scenario.h"
#include "geometry/tait_bryan.h"
#include "records/video/video.h"
#include "records/video/video_reader.h"
#include "vision/camera/calibration_file.h"
#include "vision/camera/views.h"
#include "vision/image_file.h"
#include "vision/write_image.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxSide_px = 8192;
constexpr double kSteepest_deg = 89;  // of a cylinder's rows: at 90 they never end

// Which options go with which picture.
const std::map<std::string, std::vector<std::string>> kOptions = {
    {"perspective", {"--yaw-deg", "--pitch-deg", "--roll-deg", "--fov-deg"}},
    {"panorama", {"--yaw-deg", "--pitch-deg", "--roll-deg", "--azimuth-deg", "--elevation-deg"}},
    {"cylinder", {"--yaw-deg", "--pitch-deg", "--roll-deg", "--azimuth-deg", "--elevation-deg"}},
    {"polar", {"--alpha-deg", "--radius-px"}},
    {"sphere", {"--yaw-deg", "--pitch-deg", "--roll-deg"}}};

std::vector<std::string> KindsOfView() {
  std::vector<std::string> kinds;
  for (const auto& [kind, options] : kOptions) kinds.push_back(kind);
  return kinds;
}

struct Range {
  double from = 0, to = 0;
};

bool Number(std::string_view text, double& value) {
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc{} && end.ptr == text.data() + text.size() && std::isfinite(value);
}

// "A..B", either way round, both within [low, high]. None: not given, or wrong.
std::optional<Range> ParseRange(const char* option, const std::string& text, double low, double high,
                                Mistakes& mistakes) {
  if (text.empty()) return std::nullopt;
  Range range;
  const std::size_t dots = text.find("..");
  if (dots != std::string::npos && Number(std::string_view(text).substr(0, dots), range.from) &&
      Number(std::string_view(text).substr(dots + 2), range.to) && range.from != range.to &&
      std::min(range.from, range.to) >= low && std::max(range.from, range.to) <= high) {
    return range;
  }
  mistakes.Add(option, "", fmt::format("'{}' is not a range", text),
               fmt::format("valid: A..B within {:g}..{:g}", low, high));
  return std::nullopt;
}

std::optional<Range> ParseRising(const char* option, const std::string& text, double low, double high,
                                 Mistakes& mistakes) {
  const auto range = ParseRange(option, text, low, high, mistakes);
  if (range && range->to < range->from) {
    mistakes.Add(option, "", fmt::format("'{}' falls", text), "valid: A..B with A < B");
    return std::nullopt;
  }
  return range;
}

cv::Size ParseSize(const std::string& text, Mistakes& mistakes) {
  if (text.empty()) return {};
  const std::size_t x = text.find('x');
  cv::Size size;
  const auto side = [](std::string_view s, int& value) {
    const auto end = std::from_chars(s.data(), s.data() + s.size(), value);
    return end.ec == std::errc{} && end.ptr == s.data() + s.size() && value >= 1 && value <= kMaxSide_px;
  };
  if (x == std::string::npos || !side(std::string_view(text).substr(0, x), size.width) ||
      !side(std::string_view(text).substr(x + 1), size.height)) {
    mistakes.Add("--size", "", fmt::format("'{}' is not a size", text),
                 fmt::format("valid: WIDTHxHEIGHT, 1 to {} px each, such as 800x600", kMaxSide_px));
    return {};
  }
  return size;
}

double Angle(const char* option, const std::optional<double>& degrees, double otherwise, double low,
             double high, Mistakes& mistakes) {
  const double value = degrees.value_or(otherwise);
  if (!(value >= low && value <= high))
    mistakes.Add(option, "", fmt::format("{:g} is out of range", value),
                 fmt::format("valid: {:g} to {:g}", low, high));
  return Radians(value);
}

void RefuseOptionsOfOthers(const ViewArguments& a, Mistakes& mistakes) {
  const std::pair<const char*, bool> given[] = {
      {"--yaw-deg", a.yaw_deg.has_value()},      {"--pitch-deg", a.pitch_deg.has_value()},
      {"--roll-deg", a.roll_deg.has_value()},    {"--fov-deg", a.fov_deg.has_value()},
      {"--azimuth-deg", !a.azimuth_deg.empty()}, {"--elevation-deg", !a.elevation_deg.empty()},
      {"--alpha-deg", !a.alpha_deg.empty()},     {"--radius-px", !a.radius_px.empty()}};
  const std::vector<std::string>& valid = kOptions.at(a.as);
  for (const auto& [option, is_given] : given) {
    if (is_given && std::find(valid.begin(), valid.end(), option) == valid.end())
      mistakes.Add(option, "", fmt::format("means nothing for --as {}", a.as),
                   fmt::format("valid: {}", fmt::join(valid, ", ")));
  }
}

// The arguments, read; what was not given is left to the camera.
struct Wish {
  cv::Size size;  // empty: as fits the image
  Eigen::Matrix3d R_VC;
  double field = 0;  // rad
  std::optional<Range> azimuth, elevation, alpha, radius;
};

Wish ReadWish(const ViewArguments& a, Mistakes& mistakes) {
  RefuseOptionsOfOthers(a, mistakes);
  Wish w;
  w.size = ParseSize(a.size, mistakes);
  // A sphere is looked at from in front, a little from the side and from above.
  const bool sphere = a.as == "sphere";
  const double yaw = Angle("--yaw-deg", a.yaw_deg, sphere ? 150 : 0, -360, 360, mistakes);
  const double pitch = Angle("--pitch-deg", a.pitch_deg, sphere ? -25 : 0, -180, 180, mistakes);
  const double roll = Angle("--roll-deg", a.roll_deg, 0, -360, 360, mistakes);
  w.R_VC = vision::ViewRotation(yaw, pitch, roll);
  w.field = Angle("--fov-deg", a.fov_deg, 90, 1, 175, mistakes);
  const double steepest = a.as == "cylinder" ? kSteepest_deg : 90;
  w.azimuth = ParseRising("--azimuth-deg", a.azimuth_deg, -360, 360, mistakes);
  w.elevation = ParseRising("--elevation-deg", a.elevation_deg, -steepest, steepest, mistakes);
  w.alpha = ParseRising("--alpha-deg", a.alpha_deg, -720, 720, mistakes);
  w.radius = ParseRange("--radius-px", a.radius_px, 0, 1e5, mistakes);
  if (w.azimuth && w.azimuth->to - w.azimuth->from > 360)
    mistakes.Add("--azimuth-deg", "", fmt::format("'{}' is more than a whole turn", a.azimuth_deg));
  return w;
}

vision::PolarUnwrapping MakePolar(const Wish& w, const vision::CameraModel& camera) {
  vision::PolarUnwrapping p;
  p.centre = std::visit([](const auto& c) { return Eigen::Vector2d(c.cx, c.cy); }, camera);
  const double rim = std::max({p.centre.x(), p.centre.y(), vision::WidthPx(camera) - 1 - p.centre.x(),
                               vision::HeightPx(camera) - 1 - p.centre.y()});
  const Range alpha = w.alpha.value_or(Range{0, 360}), radius = w.radius.value_or(Range{rim, 0});
  p.alpha_from = Radians(alpha.from), p.alpha_to = Radians(alpha.to);
  p.radius_top = radius.from, p.radius_bottom = radius.to;
  // As many columns as there are pixels around the middle radius.
  const double around = (radius.from + radius.to) / 2 * (p.alpha_to - p.alpha_from);
  const double across = std::abs(radius.to - radius.from);
  p.width_px = w.size.empty() ? std::clamp(static_cast<int>(around), 1, kMaxSide_px) : w.size.width;
  p.height_px = w.size.empty() ? std::clamp(static_cast<int>(across), 1, kMaxSide_px) : w.size.height;
  return p;
}

vision::Panorama MakePanorama(const Wish& w, vision::Panorama::Rows rows, const vision::CameraModel& camera) {
  vision::Panorama p = vision::WholePanorama(camera, w.R_VC, rows).value_or(vision::Panorama{});
  p.rows = rows;
  p.R_VC = w.R_VC;
  if (w.azimuth) p.azimuth_from = Radians(w.azimuth->from), p.azimuth_to = Radians(w.azimuth->to);
  if (w.elevation) p.elevation_from = Radians(w.elevation->from), p.elevation_to = Radians(w.elevation->to);
  const cv::Size size = w.size.empty() ? vision::MatchedSize(p, camera) : w.size;
  p.width_px = std::min(size.width, kMaxSide_px), p.height_px = std::min(size.height, kMaxSide_px);
  return p;
}

vision::View MakeView(const std::string& as, const Wish& w, const vision::CameraModel& camera) {
  if (as == "polar") return MakePolar(w, camera);
  if (as == "panorama") return MakePanorama(w, vision::Panorama::Rows::kElevation, camera);
  if (as == "cylinder") return MakePanorama(w, vision::Panorama::Rows::kTangent, camera);
  if (as == "sphere") {
    const cv::Size size = w.size.empty() ? cv::Size(800, 800) : w.size;
    return vision::SpherePicture{size.width, size.height, w.R_VC};
  }
  const cv::Size size = w.size.empty() ? cv::Size(vision::WidthPx(camera), vision::HeightPx(camera)) : w.size;
  const double f = size.width / (2 * std::tan(w.field / 2));
  return vision::PerspectiveView{
      {size.width, size.height, f, f, (size.width - 1) / 2.0, (size.height - 1) / 2.0}, w.R_VC};
}

// The view of an image; of a sphere the part without image is dark, so that it is seen to be a ball.
cv::Mat PictureOf(const vision::View& view, const vision::ViewTable& table, const cv::Mat& image) {
  cv::Mat seen = vision::Look(table, image);
  if (!std::holds_alternative<vision::SpherePicture>(view)) return seen;
  cv::Mat ball(seen.size(), seen.type(), cv::Scalar::all(0));
  cv::circle(ball, {seen.cols / 2, seen.rows / 2}, std::min(seen.cols, seen.rows) / 2 - 1,
             cv::Scalar::all(48), cv::FILLED, cv::LINE_AA);
  seen.copyTo(ball, table.shown);
  return ball;
}

// One line on a terminal, rewritten five times a second.
class Progress {
 public:
  Progress(double frames, bool wanted) : frames_(frames), wanted_(wanted && isatty(STDERR_FILENO)) {}
  ~Progress() {
    if (shown_) PrintNote("\r\033[K");
  }
  void Show(int frame) {
    const auto now = std::chrono::steady_clock::now();
    if (!wanted_ || now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    shown_ = true;
    const double rate = frame / std::max(std::chrono::duration<double>(now - start_).count(), 1e-3);
    PrintNote("\r\033[Kframe {}{}  {:.0f} frames/s", frame,
              frames_ > 0 ? fmt::format(" of about {:.0f}", frames_) : "", rate);
    std::fflush(stderr);
  }

 private:
  double frames_;
  bool wanted_, shown_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_ = start_;
};

// Returns the number of frames.
int TurnVideo(records::VideoReader& video, const vision::View& view, const vision::ViewTable& table,
              const ViewArguments& a) {
  records::Video out(a.out, video.rate_hz());
  Progress progress(video.frames(), !a.quiet);
  int frames = 0;
  for (; const auto frame = video.Next(); progress.Show(++frames)) out.Write(PictureOf(view, table, *frame));
  if (frames == 0) throw std::runtime_error(fmt::format("{} has no frames", a.input));
  out.Close();
  return frames;
}

}  // namespace

CLI::App* AddViewCommand(CLI::App& app, ViewArguments& a) {
  CLI::App* view = app.add_subcommand("view", "Turn a wide image or video into another picture of it");
  view->add_option("input", a.input, "An image or a video file, as the camera took it")
      ->type_name("FILE")
      ->required();
  view->add_option("--camera", a.camera,
                   "A name in models/cameras, or a calibration file of Kestrel, Kalibr or OpenCV")
      ->type_name("CAMERA")
      ->required();
  view->add_option("--camera-name", a.camera_name, "Which camera of a Kalibr file (default: its first)");
  view->add_option("--as", a.as,
                   "perspective: as a camera without distortion would see it; panorama: even in azimuth and "
                   "elevation; cylinder: a panorama with upright walls in proportion; polar: the image's own "
                   "circles unrolled, without use of the lens; sphere: a ball with the image on it")
      ->check(OneOf(KindsOfView()))
      ->capture_default_str();
  view->add_option("--out", a.out, "The file to write: .png or .jpg, or .mp4 of a video")
      ->type_name("FILE")
      ->required();
  view->add_option("--yaw-deg", a.yaw_deg, "Turns the view to the right, off the camera's axis");
  view->add_option("--pitch-deg", a.pitch_deg,
                   "then up; +90 makes a panorama of a camera that looks straight down, -90 straight up");
  view->add_option("--roll-deg", a.roll_deg, "then clockwise");
  view->add_option("--fov-deg", a.fov_deg, "Field over the width of a perspective view (default 90)");
  view->add_option("--azimuth-deg", a.azimuth_deg,
                   "A..B of a panorama, right of straight ahead (default: all that the lens sees)");
  view->add_option("--elevation-deg", a.elevation_deg, "A..B of a panorama, upwards (default: likewise)");
  view->add_option("--alpha-deg", a.alpha_deg,
                   "A..B of a polar view, from the image's right downwards (default 0..360)");
  view->add_option("--radius-px", a.radius_px,
                   "A..B of a polar view, top row to bottom row (default: the image's edge to its centre)");
  view->add_option("--size", a.size, "WIDTHxHEIGHT in pixels (default: about the image's own resolution)");
  AddBitsOption(*view, a.bits);
  view->add_flag("--quiet", a.quiet, "Print nothing but errors");
  view->footer(
      "Examples:\n"
      "  kestrel view flight.mp4 --camera calib-camchain.yaml --yaw-deg 30 --fov-deg 80 --out ahead.mp4\n"
      "  kestrel view mirror.png --camera hyperbolic_mirror --as panorama --pitch-deg 90 --out around.png\n"
      "  kestrel view down.png --camera fisheye --as sphere --out ball.png\n"
      "A view finer than the image is blurred; one that is much coarser shows aliases.");
  return view;
}

void ViewCommand(const ViewArguments& a) {
  Mistakes mistakes;
  const Wish wish = ReadWish(a, mistakes);
  cv::Mat image;
  std::optional<records::VideoReader> video;
  std::optional<cv::Size> size;  // of the input, if it can be read
  std::string note;
  if (!IsFile(a.input) || vision::LooksLikeImage(a.input)) {
    image = vision::ReadImage(a.input, vision::ImageColours::kAsStored, a.bits, mistakes, note);
    if (!image.empty()) size = image.size();
  } else {
    try {
      size = video.emplace(a.input).size();
    } catch (const std::runtime_error&) {
      mistakes.Add(a.input, "", "is neither an image nor a video that can be read");
    }
  }
  vision::CameraModel camera;
  std::string name = a.camera;
  if (const auto file = ModelFile(Model::kCamera, name, "", "--camera", mistakes))
    camera = vision::LoadCamera(*file, mistakes, a.camera_name, size);
  if (video ? !HasEnding(a.out, {".mp4"}) : !HasEnding(a.out, {".png", ".jpg", ".jpeg"})) {
    mistakes.Add(
        "--out", "",
        fmt::format("'{}' does not name {}", a.out,
                    video ? "a video; valid: an ending .mp4" : "an image; valid: an ending .png or .jpg"));
  } else if (SameFile(a.out, a.input)) {
    mistakes.Add("--out", "", fmt::format("'{}' is the input itself", a.out), "valid: another file");
  } else {
    CheckWritableFile(a.out, "--out", mistakes);
  }
  mistakes.ThrowIfAny();

  const vision::View view = MakeView(a.as, wish, camera);
  const vision::ViewTable table = vision::MakeViewTable(view, camera);
  const double shown = vision::ShownShare(table);
  if (shown == 0) {
    throw InputError({},
                     fmt::format("--as {}: the view would be black: it lies outside of what the lens sees, "
                                 "which ends {:.1f} deg from its axis",
                                 a.as, Degrees(vision::MaxAngle(camera))));
  }
  if (video) {
    const int frames = TurnVideo(*video, view, table, a);
    if (!a.quiet) fmt::print("{} frames, ", frames);
  } else {
    vision::WriteImage(a.out, PictureOf(view, table, image));
  }
  if (!a.quiet) {
    if (!note.empty()) fmt::print("{}\n", note);
    fmt::print("{}: {} x {} px, of which the lens shows {:.0f} %\n", a.out, table.shown.cols,
               table.shown.rows, 100 * shown);
  }
}

}  // namespace kestrel::app
