// SPDX-License-Identifier: Apache-2.0
#include "app/stabilise/stabilise_video.h"

#include <fmt/format.h>

#include <chrono>
#include <deque>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <variant>

#include "app/simulated/images_input.h"
#include "app/simulated/interlace_watch.h"
#include "app/stabilise/stabilise_tally.h"
#include "base/file/files.h"
#include "base/stopwatch.h"
#include "records/video/video.h"
#include "vision/enhance/stabilisation/stabiliser.h"
#include "vision/horizon/skyline.h"

namespace kestrel::app {
namespace {

cv::Mat Bgr(const cv::Mat& image) {
  cv::Mat bgr = image;
  if (image.channels() == 1) cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

cv::Mat WithMatches(const cv::Mat& image, const std::vector<vision::PointPair>& pairs) {
  cv::Mat drawn = Bgr(image).clone();
  for (const vision::PointPair& pair : pairs) {
    const cv::Point from(cvRound(pair.from.x()), cvRound(pair.from.y())),
        to(cvRound(pair.to.x()), cvRound(pair.to.y()));
    cv::line(drawn, from, to, {0, 200, 255}, 1, cv::LINE_AA);
    cv::circle(drawn, to, 2, {80, 255, 80}, 1, cv::LINE_AA);
  }
  return drawn;
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

}  // namespace

bool StabiliseVideo(const StabiliseArguments& a, ImageInput& input,
                    const std::optional<vision::CameraModel>& camera, const std::optional<Gyro>& gyro,
                    const std::atomic<bool>& stopped) {
  vision::Stabiliser stabiliser(a.options, camera, input.rate_hz);
  std::optional<vision::Skyline> skyline;
  if (a.options.level)
    skyline.emplace(*camera, PoseOf(a.mount).R.toRotationMatrix(), cv::Mat(), vision::SkylineOptions());
  std::optional<records::Video> out, beside;
  if (!a.out.empty()) out.emplace(a.out, input.rate_hz);
  if (!a.before_after.empty()) beside.emplace(a.before_after, input.rate_hz);
  FrameProgress progress(!a.quiet);
  InterlaceWatch interlace;
  StabiliseTally tally(camera ? &*camera : nullptr, a.options.motion.opencl, a.options.level);
  std::deque<ImageBefore> waiting;
  cv::Size size;
  std::string broke_off;
  int frames = 0;
  const auto tell_left_out = [&] {
    for (; !waiting.empty() && waiting.front().left_out; waiting.pop_front())
      tally.AddLeftOut(waiting.front());
  };
  const auto show = [&](const std::optional<vision::StabilisedImage>& image) {
    if (!image) return false;
    tell_left_out();
    tally.Add(*image, waiting.front());
    if (out) out->Write(Bgr(image->image));
    if (beside) beside->Write(SideBySide(waiting.front().drawn, image->image));
    waiting.pop_front();
    return true;
  };
  const auto next = [&]() -> std::optional<vision::Frame> {
    if (stopped || (a.frames > 0 && frames >= a.frames)) return std::nullopt;
    try {
      return NextImage(input, frames, a.quiet);
    } catch (const std::runtime_error& e) {
      broke_off = e.what();
      return std::nullopt;
    }
  };
  try {
    while (const auto frame = next()) {
      ImageBefore before;
      before.number = frames++, before.t_s = frame->t_s;
      if (frame->image.empty()) {
        before.left_out = vision::StabilisedState::kUnreadable;
        waiting.push_back(before);
        continue;
      }
      if (size.empty()) size = frame->image.size();
      if (frame->image.size() != size && (out || beside || camera)) {
        before.left_out = vision::StabilisedState::kResized;
        waiting.push_back(before);
        broke_off = fmt::format("an image of {} x {} pixels after those of {} x {}", frame->image.cols,
                                frame->image.rows, size.width, size.height);
        break;
      }
      before.interlaced = interlace.Add(frame->image);
      const auto start = std::chrono::steady_clock::now();
      vision::ImageAttitudes attitudes;
      attitudes.readout_s = a.readout_s;
      if (gyro) attitudes.R_NC_rows = gyro->track.Rows(frame->t_s + gyro->offset_s, a.readout_s);
      if (skyline) {
        const vision::SkylineResult seen = skyline->Measure(frame->image);
        if (const auto* fix = std::get_if<vision::SkylineFix>(&seen)) before.down_C = fix->down_C;
      }
      attitudes.down_C = before.down_C;
      const auto image = stabiliser.Step(frame->image, frame->t_s, attitudes);
      before.ms = 1e3 * SecondsSince(start);
      before.drawn = beside ? WithMatches(frame->image, stabiliser.last_inliers()) : frame->image;
      waiting.push_back(before);
      show(image);
      progress.Show(frames);
    }
    while (show(stabiliser.Finish())) {}
    tell_left_out();
  } catch (const std::runtime_error& e) {
    broke_off = e.what();
  }
  progress.Clear();
  if (!a.csv.empty()) WriteFile(a.csv, tally.csv());
  try {
    if (out) out->Close();
    if (beside) beside->Close();
  } catch (const std::runtime_error& e) {
    if (broke_off.empty()) broke_off = e.what();
  }
  if (!a.quiet) {
    for (const std::string& sentence : tally.Sentences()) fmt::print("{}\n", sentence);
    if (a.options.mode == "smooth" && frames > 1)
      fmt::print("the view comes {:.2g} s late\n", stabiliser.Lag() / input.rate_hz);
    if (const std::string told = interlace.Sentence(a.input); !told.empty()) fmt::print("{}\n", told);
  }
  if (!broke_off.empty())
    throw std::runtime_error(fmt::format("{}: it broke off after {} images, which are written: {}", a.input,
                                         tally.images(), broke_off));
  return tally.Achieved();
}

}  // namespace kestrel::app
