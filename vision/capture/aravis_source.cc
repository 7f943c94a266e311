// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/aravis_source.h"

#include <arv.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "base/clock_sync.h"
#include "base/stopwatch.h"
#include "vision/capture/block_count.h"
#include "vision/capture/live_camera.h"

namespace kestrel::vision {
namespace {

constexpr int kBuffers = 3;            // one is filled, one is read, one is between
constexpr double kFrameHeld_s = 0.05;  // how long a damaged image may hold up those after it
constexpr double kPoll_s = 0.05;

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using Owned = std::unique_ptr<T, Unref>;

// What one of Aravis's functions returns; throws the error that it tells.
template <class Function, class... Arguments>
auto Ask(const char* what, Function* function, Arguments... arguments) {
  GError* error = nullptr;
  const auto check = [&] {
    if (!error) return;
    const std::string message = fmt::format("{}: {}", what, error->message);
    g_error_free(error);
    throw std::runtime_error(message);
  };
  if constexpr (std::is_void_v<decltype(function(arguments..., &error))>) {
    function(arguments..., &error);
    check();
  } else {
    const auto result = function(arguments..., &error);
    check();
    return result;
  }
}

void MustBe(const char* what, double wanted, double got) {
  constexpr double kNear = 0.02;  // cameras count exposure and rate in steps of theirs
  if (std::abs(got - wanted) > kNear * std::abs(wanted))
    throw std::runtime_error(fmt::format("{}: {:g} was asked for, the camera gives {:g}", what, wanted, got));
}

struct Format {
  ArvPixelFormat format;
  const char* name;
  int channels;
  int to_grey, to_colour;  // of cv::cvtColor; -1: as it is
};

// OpenCV names a Bayer pattern by the second and third pixel of its second row, GenICam by the first two of
// its first.
constexpr Format kFormats[] = {
    {ARV_PIXEL_FORMAT_BAYER_RG_8, "BayerRG8", 1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR},
    {ARV_PIXEL_FORMAT_BAYER_BG_8, "BayerBG8", 1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR},
    {ARV_PIXEL_FORMAT_BAYER_GB_8, "BayerGB8", 1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR},
    {ARV_PIXEL_FORMAT_BAYER_GR_8, "BayerGR8", 1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR},
    {ARV_PIXEL_FORMAT_BGR_8_PACKED, "BGR8", 3, cv::COLOR_BGR2GRAY, -1},
    {ARV_PIXEL_FORMAT_RGB_8_PACKED, "RGB8", 3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR},
    {ARV_PIXEL_FORMAT_MONO_8, "Mono8", 1, -1, cv::COLOR_GRAY2BGR},
};

class AravisReader final : public ImageSource {
 public:
  explicit AravisReader(AravisSourceOptions options) : options_(std::move(options)) {}
  ~AravisReader() override {
    if (!camera_) return;
    // A camera that is gone would be waited for.
    if (stream_ && !lost_) arv_camera_stop_acquisition(camera_.get(), nullptr);
    g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_.get()), this);
    stream_.reset();
    camera_.reset();  // ends the threads that know this
  }

  bool Open() override {
    try {
      camera_.reset(Ask("the camera", arv_camera_new, Id().c_str()));
      if (!camera_) throw std::runtime_error("there is no camera " + Id());
      arv_camera_set_range_check_policy(camera_.get(), ARV_RANGE_CHECK_POLICY_ENABLE);
      g_signal_connect(arv_camera_get_device(camera_.get()), "control-lost",
                       G_CALLBACK(+[](ArvDevice*, AravisReader* self) { self->lost_ = true; }), this);
      SetUp();
      Start();
      return true;
    } catch (const std::runtime_error& error) {
      error_ = error.what();
      return false;
    }
  }

  std::optional<Grabbed> Grab() override {
    const double begun_s = MonotonicNow_s();
    while (!lost_) {
      if (ArvBuffer* buffer = Newest()) {
        std::optional<Grabbed> grabbed = Read(buffer);
        arv_stream_push_buffer(stream_.get(), buffer);
        return grabbed;
      }
      if (MonotonicNow_s() - begun_s > silent_s_) {
        error_ = fmt::format("no undamaged image for {:.1f} s", silent_s_);
        return std::nullopt;
      }
    }
    error_ = "control of the camera was lost";
    return std::nullopt;
  }

  std::string Error() const override { return error_; }

 private:
  std::string Id() const {
    if (!options_.id.empty()) return options_.id;
    arv_update_device_list();
    const char* first = arv_get_n_devices() > 0 ? arv_get_device_id(0) : nullptr;
    if (!first) throw std::runtime_error("there is no camera");
    return first;
  }

  void SetUp() {
    ArvCamera* camera = camera_.get();
    arv_camera_clear_triggers(camera, nullptr);  // of those that have any
    Ask("acquisition mode", arv_camera_set_acquisition_mode, camera, ARV_ACQUISITION_MODE_CONTINUOUS);
    SetFormat();
    if (!options_.size.empty()) SetSize();
    if (options_.rate_hz > 0) {
      Ask("rate", arv_camera_set_frame_rate, camera, options_.rate_hz);
      MustBe("rate in Hz", options_.rate_hz, Ask("rate", arv_camera_get_frame_rate, camera));
    }
    if (options_.exposure_us) {
      if (arv_camera_is_exposure_auto_available(camera, nullptr))
        Ask("automatic exposure", arv_camera_set_exposure_time_auto, camera, ARV_AUTO_OFF);
      Ask("exposure", arv_camera_set_exposure_time, camera, *options_.exposure_us);
      MustBe("exposure in us", *options_.exposure_us, Ask("exposure", arv_camera_get_exposure_time, camera));
    }
    if (options_.gain) {
      if (arv_camera_is_gain_auto_available(camera, nullptr))
        Ask("automatic gain", arv_camera_set_gain_auto, camera, ARV_AUTO_OFF);
      Ask("gain", arv_camera_set_gain, camera, *options_.gain);
      MustBe("gain", *options_.gain, Ask("gain", arv_camera_get_gain, camera));
    }
  }

  void SetFormat() {
    guint count = 0;
    gint64* has = Ask("list of pixel formats", arv_camera_dup_available_pixel_formats, camera_.get(), &count);
    const auto available = [&](const Format& each) { return std::count(has, has + count, each.format) > 0; };
    const Format* found = std::find_if(std::begin(kFormats), std::end(kFormats), available);
    const Format& mono = *(std::end(kFormats) - 1);
    if (!options_.colour && available(mono)) found = &mono;
    g_free(has);
    if (found == std::end(kFormats))
      throw std::runtime_error("the camera has none of Mono8, Bayer of 8 bits, BGR8 and RGB8");
    format_ = found;
    Ask("pixel format", arv_camera_set_pixel_format, camera_.get(), found->format);
    if (Ask("pixel format", arv_camera_get_pixel_format, camera_.get()) != found->format)
      throw std::runtime_error(fmt::format("the camera does not take the pixel format {}", found->name));
  }

  void SetSize() {
    ArvCamera* camera = camera_.get();
    const int width = options_.size.width, height = options_.size.height;
    const bool movable = arv_camera_is_region_offset_available(camera, nullptr);
    // First to the corner, since the offset that is set may leave no room for the size.
    Ask("size", arv_camera_set_region, camera, movable ? 0 : -1, movable ? 0 : -1, width, height);
    if (movable) {
      int sensor_width = 0, sensor_height = 0;
      Ask("size of the sensor", arv_camera_get_sensor_size, camera, &sensor_width, &sensor_height);
      const auto middle = [](int whole, int part, int step) {
        const int offset = std::max(0, (whole - part) / 2);
        return offset - offset % std::max(1, step);
      };
      const int x = middle(sensor_width, width, Ask("offset", arv_camera_get_x_offset_increment, camera));
      const int y = middle(sensor_height, height, Ask("offset", arv_camera_get_y_offset_increment, camera));
      Ask("offset", arv_camera_set_region, camera, x, y, width, height);
    }
    int x = 0, y = 0, got_width = 0, got_height = 0;
    Ask("size", arv_camera_get_region, camera, &x, &y, &got_width, &got_height);
    if (got_width != width || got_height != height)
      throw std::runtime_error(fmt::format("size: {}x{} was asked for, the camera gives {}x{}", width, height,
                                           got_width, got_height));
  }

  void Start() {
    ArvCamera* camera = camera_.get();
    GError* unknown = nullptr;
    const double rate_hz = arv_camera_get_frame_rate(camera, &unknown);
    if (!unknown && rate_hz > 0) silent_s_ = std::max(kAravisSilent_s, 3 / rate_hz);
    g_clear_error(&unknown);
    // An ordinary socket, also for who may have another: that one receives nothing on loopback.
    if (arv_camera_is_gv_device(camera))
      arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    stream_.reset(Ask("stream", arv_camera_create_stream, camera, nullptr, nullptr));
    if (!stream_) throw std::runtime_error("the camera gives no stream");
    if (ARV_IS_GV_STREAM(stream_.get()))
      g_object_set(stream_.get(), "frame-retention", static_cast<guint>(kFrameHeld_s * 1e6), nullptr);
    const std::size_t size = Ask("size of an image in bytes", arv_camera_get_payload, camera);
    for (int i = 0; i < kBuffers; ++i) arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(size));
    Ask("start", arv_camera_start_acquisition, camera);
  }

  // The newest undamaged image of those that came; to be pushed back. Null: none within kPoll_s.
  ArvBuffer* Newest() {
    ArvBuffer* newest = nullptr;
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream_.get(), static_cast<guint64>(kPoll_s * 1e6));
    for (; buffer; buffer = arv_stream_try_pop_buffer(stream_.get())) {
      const bool good = arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS;
      if (good) Receive(buffer);
      ArvBuffer* done = good ? std::exchange(newest, buffer) : buffer;
      if (done) arv_stream_push_buffer(stream_.get(), done);
    }
    return newest;
  }

  // Aravis stamps what comes by the time of day.
  void Receive(ArvBuffer* buffer) {
    const double now_s = MonotonicNow_s();
    const double ago_s = 1e-6 * static_cast<double>(g_get_real_time()) -
                         1e-9 * static_cast<double>(arv_buffer_get_system_timestamp(buffer));
    // A time of day that was set meanwhile tells nothing.
    arrived_s_ = now_s - (ago_s > 0 && ago_s < silent_s_ ? ago_s : 0);
    clock_.AddSample(Stamp_s(buffer), arrived_s_);
  }

  static double Stamp_s(ArvBuffer* buffer) {
    return 1e-9 * static_cast<double>(arv_buffer_get_timestamp(buffer));
  }

  std::optional<Grabbed> Read(ArvBuffer* buffer) {
    const cv::Size size(arv_buffer_get_image_width(buffer), arv_buffer_get_image_height(buffer));
    std::size_t bytes = 0;
    const void* data = arv_buffer_get_image_data(buffer, &bytes);
    if (!options_.size.empty() && size != options_.size) {
      error_ = fmt::format("an image of {}x{} came", size.width, size.height);
      return std::nullopt;
    }
    const ArvPixelFormat format = arv_buffer_get_image_pixel_format(buffer);
    if (format != format_->format || !data ||
        bytes < static_cast<std::size_t>(size.area() * format_->channels)) {
      error_ = fmt::format("an image of {}x{} came in {} bytes and pixel format {:#x}, not in {}", size.width,
                           size.height, bytes, format, format_->name);
      return std::nullopt;
    }
    const cv::Mat raw(size, CV_8UC(format_->channels), const_cast<void*>(data));  // read only
    Grabbed grabbed;
    const int conversion = options_.colour ? format_->to_colour : format_->to_grey;
    if (conversion < 0)
      grabbed.image = raw.clone();
    else
      cv::cvtColor(raw, grabbed.image, conversion);
    // A camera without a clock of its own gives nought, or the same for ever.
    const double stamp_s = Stamp_s(buffer);
    grabbed.stamp_s = stamp_s > newest_s_ ? clock_.ToOurs(stamp_s).value_or(arrived_s_) : arrived_s_;
    newest_s_ = std::max(newest_s_, stamp_s);
    grabbed.count = blocks_.Of(arv_buffer_get_frame_id(buffer));
    return grabbed;
  }

  AravisSourceOptions options_;
  std::string error_;
  std::atomic<bool> lost_ = false;  // set by a thread of Aravis's
  const Format* format_ = nullptr;
  double silent_s_ = kAravisSilent_s;
  double arrived_s_ = 0;  // the newest image
  double newest_s_ = 0;   // stamp, by the camera's clock
  ClockSync clock_;
  BlockCount blocks_;
  Owned<ArvCamera> camera_;
  Owned<ArvStream> stream_;
};

}  // namespace

ImageSourceMaker AravisSource(const AravisSourceOptions& options) {
  return [options] { return std::make_unique<AravisReader>(options); };
}

}  // namespace kestrel::vision
