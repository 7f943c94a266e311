// SPDX-License-Identifier: Apache-2.0
#include "app/stabilise/stabilise_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "app/option/bits_option.h"
#include "app/option/one_of.h"
#include "app/simulated/images_input.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/end_signals.h"
#include "base/stopwatch.h"
#include "geometry/pose.h"
#include "records/video/video.h"
#include "vision/enhance/stabilisation/gyro_file.h"
#include "vision/enhance/stabilisation/gyro_offset.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::app {
namespace {

std::atomic<bool> stopped = false;

bool ByGyro(const StabiliseArguments& a) { return a.options.by == "gyro" || a.options.by == "both"; }

cv::Mat Bgr(const cv::Mat& image) {
  cv::Mat bgr = image;
  if (image.channels() == 1) cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

// How the camera turned from image to image, for the offset of a gyro's clock. The input is read to its end.
std::vector<vision::ImageTurn> TurnsOf(const StabiliseArguments& a, const vision::CameraModel& camera,
                                       ImageInput input) {
  vision::StabiliserOptions sphere = a.options;
  sphere.by = "sphere";
  vision::ImageFollower follower(sphere, camera, {}, false);
  std::vector<vision::ImageTurn> turns;
  std::optional<Eigen::Quaterniond> before;
  double before_s = 0;
  constexpr int kEnough = 600;
  for (int i = 0; i < kEnough && !stopped; ++i) {
    const auto frame = input.next();
    if (!frame) break;
    cv::Mat grey = frame->image;
    if (grey.channels() == 3) cv::cvtColor(frame->image, grey, cv::COLOR_BGR2GRAY);
    const vision::FollowedImage followed = follower.Step(grey, frame->t_s, {});
    const bool known = followed.state == vision::StabilisedState::kFollowed;
    if (known && before)
      turns.push_back({before_s, frame->t_s, LogRotation(before->conjugate() * followed.R_NC)});
    before = followed.R_NC, before_s = frame->t_s;
  }
  return turns;
}

std::string Row(const vision::StabilisedImage& image, const vision::CameraModel* camera, const cv::Size& size,
                double ms) {
  std::string row =
      fmt::format("{},{:.4f},{},{},{},{:.3f},{:.4f}", image.number, image.t_s, vision::NameOf(image.state),
                  image.points, image.inliers, image.rms_px, image.strength);
  // How the view shows the middle of the image.
  constexpr double kStep_px = 10;
  const Eigen::Vector2d middle((size.width - 1) / 2.0, (size.height - 1) / 2.0);
  const auto at = vision::ShownAt(image.view, camera, middle),
             right = vision::ShownAt(image.view, camera, middle + Eigen::Vector2d(kStep_px, 0));
  if (!at || !right) return row + fmt::format(",,,,,{:.2f}\n", ms);
  const Eigen::Vector2d along = *right - *at,
                        shift = *at - Eigen::Vector2d((image.view.size.width - 1) / 2.0,
                                                      (image.view.size.height - 1) / 2.0);
  return row + fmt::format(",{:.3f},{:.3f},{:.4f},{:.5f},{:.2f}\n", shift.x(), shift.y(),
                           std::atan2(along.y(), along.x()) * 180 / M_PI, along.norm() / kStep_px, ms);
}

// Before and after, side by side, of the height of the image.
cv::Mat SideBySide(const cv::Mat& before, const cv::Mat& after) {
  cv::Mat right = Bgr(after), both;
  if (right.rows != before.rows)
    cv::resize(right, right, {2 * (right.cols * before.rows / right.rows / 2), before.rows}, 0, 0,
               cv::INTER_AREA);
  cv::hconcat(before, right, both);
  return both;
}

struct Gyro {
  vision::GyroTrack track;
  double offset_s = 0;
};

void Follow(const StabiliseArguments& a, ImageInput& input, const std::optional<vision::CameraModel>& camera,
            const std::optional<Gyro>& gyro) {
  vision::Stabiliser stabiliser(a.options, camera, input.rate_hz);
  const vision::CameraModel* lens = camera ? &*camera : nullptr;
  std::string csv =
      "frame,t_s,state,points,inliers,rms_px,strength,shift_x_px,shift_y_px,turn_deg,scale,stabilise_ms\n";
  std::optional<records::Video> out, beside;
  if (!a.out.empty()) out.emplace(a.out, input.rate_hz);
  if (!a.before_after.empty()) beside.emplace(a.before_after, input.rate_hz);
  FrameProgress progress(!a.quiet);
  std::deque<std::pair<cv::Mat, double>> before;  // images with what was matched, and the time that each took
  std::map<std::string, int> states;
  cv::Size size;
  std::string broke_off;
  int frames = 0, shown = 0;
  double sum_ms = 0;
  const auto show = [&](const std::optional<vision::StabilisedImage>& image) {
    if (!image) return false;
    csv += Row(*image, lens, before.front().first.size(), before.front().second);
    ++states[vision::NameOf(image->state)], ++shown;
    if (out) out->Write(Bgr(image->image));
    if (beside) beside->Write(SideBySide(before.front().first, image->image));
    before.pop_front();
    return true;
  };
  try {
    while (!stopped && (a.frames == 0 || frames < a.frames)) {
      const auto frame = input.next();
      if (!frame) break;
      if (size.empty()) size = frame->image.size();
      if (frame->image.size() != size && (out || beside || camera))
        throw std::runtime_error(fmt::format("an image of {} x {} pixels after those of {} x {}",
                                             frame->image.cols, frame->image.rows, size.width, size.height));
      vision::ImageAttitudes attitudes;
      attitudes.readout_s = a.readout_s;
      if (gyro) attitudes.R_NC_rows = gyro->track.Rows(frame->t_s + gyro->offset_s, a.readout_s);
      const auto start = std::chrono::steady_clock::now();
      auto image = stabiliser.Step(frame->image, frame->t_s, attitudes);
      const double ms = 1e3 * SecondsSince(start);
      sum_ms += ms;
      cv::Mat matched = Bgr(frame->image).clone();
      if (beside)
        for (const vision::PointPair& pair : stabiliser.last_inliers()) {
          const cv::Point from(cvRound(pair.from.x()), cvRound(pair.from.y())),
              to(cvRound(pair.to.x()), cvRound(pair.to.y()));
          cv::line(matched, from, to, {0, 200, 255}, 1, cv::LINE_AA);
          cv::circle(matched, to, 2, {80, 255, 80}, 1, cv::LINE_AA);
        }
      before.emplace_back(matched, ms);
      show(image);
      progress.Show(++frames);
    }
    while (show(stabiliser.Finish())) {}
  } catch (const std::runtime_error& e) {
    broke_off = e.what();
  }
  progress.Clear();
  if (!a.csv.empty()) WriteFile(a.csv, csv);
  try {
    if (out) out->Close();
    if (beside) beside->Close();
  } catch (const std::runtime_error& e) {
    if (broke_off.empty()) broke_off = e.what();
  }
  if (!a.quiet && frames > 0) {
    std::string counts;
    for (const auto& [name, count] : states)
      counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, name);
    fmt::print("{} images: {}; {:.1f} ms each, {} images late\n", shown, counts, sum_ms / frames,
               stabiliser.Lag());
  }
  if (!broke_off.empty())
    throw std::runtime_error(
        fmt::format("{}: it broke off after {} images, which are written: {}", a.input, shown, broke_off));
}

// The gyro and its clock. A mistake: no file of a gyro, or one that has nothing to do with the video.
std::optional<Gyro> OpenGyro(const StabiliseArguments& a, const vision::CameraModel& camera,
                             Mistakes& mistakes) {
  const std::size_t before = mistakes.all().size();
  Gyro gyro{vision::GyroTrack(vision::ReadGyroFile(a.imu, mistakes)), a.imu_offset_s.value_or(0)};
  if (mistakes.all().size() > before) return std::nullopt;
  if (a.imu_offset_s) return gyro;
  const auto offset = vision::EstimateGyroOffset(TurnsOf(a, camera, OpenImages(a, stopped, mistakes)),
                                                 gyro.track, a.max_offset_s);
  if (!offset) {
    mistakes.Add(
        "--imu", "",
        fmt::format("'{}', from {:.3f} to {:.3f} s, turns as the video does at no offset of up to {} s",
                    a.imu, gyro.track.begin_s(), gyro.track.end_s(), a.max_offset_s),
        "valid: the rates in the camera's axes while it was filmed, of the same clock within --max-offset-s; "
        "--imu-offset-s where the offset is known");
    return std::nullopt;
  }
  gyro.offset_s = offset->offset_s;
  if (!a.quiet)
    fmt::print(
        "the gyro's clock is {:+.4f} s from the video's, by {} turns of which it leaves {:.1f} % "
        "unexplained\n",
        offset->offset_s, offset->turns, 100 * offset->unlike);
  return gyro;
}

}  // namespace

CLI::App* AddStabiliseCommand(CLI::App& app, StabiliseArguments& a) {
  CLI::App* command =
      app.add_subcommand("stabilise", "Steady a video: the view stands still, or goes along a smooth path");
  command
      ->add_option("input", a.input,
                   "A video file, a folder of images or a camera's address, as of kestrel fly")
      ->type_name("INPUT")
      ->required();
  command
      ->add_option(
          "--mode", a.options.mode,
          "reference: the view stands still; smooth: it goes smoothly, late by --lag-s; offline: the same, "
          "with all the images that count")
      ->check(OneOf({"reference", "smooth", "offline"}))
      ->capture_default_str();
  command
      ->add_option(
          "--by", a.options.by,
          "vision: a plane's motion; sphere: the camera's rotation, by vision; gyro: its rotation by --imu "
          "alone; both. All but vision need --camera")
      ->check(OneOf({"vision", "sphere", "gyro", "both"}))
      ->capture_default_str();
  command->add_option("--model", a.options.motion.model, "What an image may do from one to the next")
      ->check(OneOf(vision::MotionModelNames()))
      ->capture_default_str();
  command->add_option("--method", a.options.motion.method, "How points are found again")
      ->check(OneOf({"lk", "sift", "surf", "orb"}))
      ->capture_default_str();
  command->add_option("--points", a.options.motion.max_points, "Maximum number of points in an image")
      ->check(CLI::Range(20, 5000))
      ->capture_default_str();
  command->add_option("--lag-s", a.options.lag_s, "How late the view comes")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--cutoff-hz", a.options.cutoff_hz, "What is faster is taken out of the path")
      ->check(CLI::Range(0.05, 5.0))
      ->capture_default_str();
  command->add_option("--crop", a.options.crop, "Share of the image's width and height that is shown")
      ->check(CLI::Range(0.2, 1.0))
      ->capture_default_str();
  command->add_flag("--no-scale", a.no_scale, "Do not enlarge what is shown to the image's size");
  command->add_flag("--unbounded", a.unbounded, "Let the view leave the image rather than follow its shakes");
  command->add_option("--border", a.options.border, "What is shown where the image has nothing")
      ->check(OneOf({"black", "blurred", "filled"}))
      ->capture_default_str();
  command
      ->add_option("--camera", a.camera,
                   "A name in models/cameras, or a calibration file of Kestrel, Kalibr or OpenCV")
      ->type_name("CAMERA");
  command->add_option("--camera-name", a.camera_name, "Which camera of a Kalibr file (default: its first)");
  command->add_option("--imu", a.imu, "CSV of a gyro: t_s, wx_rad_s, wy_rad_s, wz_rad_s in the camera's axes")
      ->type_name("FILE");
  command->add_option("--imu-offset-s", a.imu_offset_s,
                      "What is to be added to the video's time for the gyro's (default: it is estimated)");
  command->add_option("--max-offset-s", a.max_offset_s, "Within which the offset is looked for")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  command
      ->add_option(
          "--readout-s", a.readout_s,
          "From the first row's exposure to the last one's, of a rolling shutter; negative: from below")
      ->check(CLI::Range(-0.2, 0.2));
  command->add_option("--out", a.out, "The video (.mp4)")->type_name("FILE");
  command
      ->add_option("--before-after", a.before_after,
                   "A video of both side by side, with what was matched drawn (.mp4)")
      ->type_name("FILE");
  command->add_option("--csv", a.csv, "A row for each image: state, points, path")->type_name("FILE");
  command
      ->add_option("--frames", a.frames,
                   "End after so many images (default: with the input, or when interrupted)")
      ->check(CLI::Range(1, 100000000));
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  kestrel stabilise flight.mp4 --out steady.mp4 --before-after both.mp4 --csv path.csv\n"
      "  kestrel stabilise hover.mp4 --mode reference --border filled --out still.mp4\n"
      "  kestrel stabilise flight.mp4 --by both --imu gyro.csv --camera my_calibration.yaml --readout-s 0.03 "
      "--out "
      "steady.mp4");
  return command;
}

void StabiliseCommand(const StabiliseArguments& given) {
  StabiliseArguments a = given;
  a.options.scale = !a.no_scale, a.options.bound = !a.unbounded;
  Mistakes mistakes;
  stopped = false;
  ImageInput input = OpenImages(a, stopped, mistakes);
  std::error_code none;
  const bool live = !std::filesystem::exists(a.input, none);
  if (input.still)
    mistakes.Add(a.input, "", "one image, which has no motion", "valid: a video, or a folder of images");
  std::optional<vision::CameraModel> camera;
  if (!a.camera.empty()) camera = ReadCamera(a, input.size, mistakes);
  if (a.camera.empty() && a.options.by != "vision")
    mistakes.Add("--camera", "", fmt::format("not given, and --by {} needs it", a.options.by),
                 "valid: a calibration file, or --by vision");
  if (ByGyro(a) == a.imu.empty())
    mistakes.Add("--imu", "",
                 a.imu.empty() ? fmt::format("not given, and --by {} needs it", a.options.by)
                               : fmt::format("of no use to --by {}", a.options.by),
                 "valid: --by gyro or both, with --imu");
  if (ByGyro(a) && live)
    mistakes.Add("--imu", "", "a file, and the input is a camera that goes on",
                 "valid: with a video or a folder");
  if (a.out.empty() && a.csv.empty() && a.before_after.empty())
    mistakes.Add("--out", "", "not given, nor --csv or --before-after: there would be no result");
  CheckOutputFiles(a, false, a.imu, mistakes);
  if (!a.before_after.empty()) {
    StabiliseArguments other = a;
    other.out = a.before_after;
    CheckOutputFiles(other, false, a.imu, mistakes);
    if (a.before_after == a.out)
      mistakes.Add("--before-after", "", fmt::format("'{}' is that of --out too", a.out),
                   "valid: another file");
  }
  mistakes.ThrowIfAny();
  std::optional<Gyro> gyro;
  if (ByGyro(a)) gyro = OpenGyro(a, *camera, mistakes);
  mistakes.ThrowIfAny();
  if (!a.quiet && !input.note.empty()) fmt::print("{}\n", input.note);
  OnEndSignals([](int) { stopped = true; });
  Follow(a, input, camera, gyro);
}

}  // namespace kestrel::app
