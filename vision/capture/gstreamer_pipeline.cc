// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/gstreamer_pipeline.h"

#include <fmt/format.h>
#include <gio/gio.h>
#include <gst/gst.h>

#include <functional>
#include <mutex>
#include <utility>

#include "base/stopwatch.h"

namespace kestrel::vision {
namespace {

constexpr double kLook_s = 0.05;  // how often it is asked whether the pipeline has failed

struct GstUnref {
  void operator()(void* object) const { gst_object_unref(object); }
};
template <class T>
using GstOwned = std::unique_ptr<T, GstUnref>;

// Whether a pipeline has ended and why; told by the threads of its elements.
struct PipelineEnd {
  std::mutex mutex;
  std::string error;  // the first
  bool over = false;

  void Fail(const std::string& why) {
    const std::lock_guard lock(mutex);
    if (!over) error = why;
    over = true;
  }
};

// Nothing is left on the bus, which nobody reads.
GstBusSyncReply Receive(GstBus*, GstMessage* message, gpointer end) {
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
    GError* error = nullptr;
    gst_message_parse_error(message, &error, nullptr);
    static_cast<PipelineEnd*>(end)->Fail(error->message);
    g_error_free(error);
  } else if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS) {
    static_cast<PipelineEnd*>(end)->Fail("the stream has ended");
  }
  gst_message_unref(message);
  return GST_BUS_DROP;
}

// Those of a kind, wherever in the pipeline.
void EachOf(GstElement* pipeline, const char* kind, const std::function<void(GstElement*)>& take) {
  GstIterator* all = gst_bin_iterate_all_by_element_factory_name(GST_BIN(pipeline), kind);
  GValue item = G_VALUE_INIT;
  while (gst_iterator_next(all, &item) == GST_ITERATOR_OK) {
    take(GST_ELEMENT(g_value_get_object(&item)));
    g_value_unset(&item);
  }
  gst_iterator_free(all);
}

// A copy; empty: it is none that is known here.
cv::Mat ImageOf(GstSample* sample) {
  const GstCaps* caps = gst_sample_get_caps(sample);
  GstBuffer* buffer = gst_sample_get_buffer(sample);
  if (!caps || !buffer || gst_caps_get_size(caps) == 0) return {};
  const GstStructure* form = gst_caps_get_structure(caps, 0);
  int width = 0, height = 0;
  const char* format = gst_structure_get_string(form, "format");
  if (!format || !gst_structure_get_int(form, "width", &width) ||
      !gst_structure_get_int(form, "height", &height) || width < 1 || height < 1)
    return {};
  const std::string name = format;
  if (name != "BGR" && name != "GRAY8") return {};
  const int type = name == "BGR" ? CV_8UC3 : CV_8UC1;
  // Rows begin at multiples of four bytes (video/x-raw without a GstVideoMeta, which appsink does not offer
  // to take).
  const std::size_t row = static_cast<std::size_t>(width) * static_cast<std::size_t>(CV_MAT_CN(type));
  const std::size_t step = (row + 3) / 4 * 4;
  GstMapInfo map;
  if (!gst_buffer_map(buffer, &map, GST_MAP_READ)) return {};
  cv::Mat image;
  if (map.size >= step * static_cast<std::size_t>(height - 1) + row)
    image = cv::Mat(height, width, type, map.data, step).clone();
  gst_buffer_unmap(buffer, &map);
  return image;
}

}  // namespace

struct GStreamerPipeline::Impl {
  ~Impl() {
    if (!pipeline) return;
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
    const GstOwned<GstBus> bus(gst_element_get_bus(pipeline.get()));
    gst_bus_set_sync_handler(bus.get(), nullptr, nullptr, nullptr);
  }

  // Null: its end tells why.
  void Make(const std::string& description) {
    GError* error = nullptr;
    if (gst_init_check(nullptr, nullptr, &error)) {
      GstElement* made =
          gst_parse_launch_full(description.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error);
      if (made) pipeline.reset(GST_ELEMENT(gst_object_ref_sink(made)));
    }
    if (error) end.Fail(error->message);
    g_clear_error(&error);
    if (!pipeline) return end.Fail("GStreamer cannot make it");
    if (!GST_IS_PIPELINE(pipeline.get())) {
      pipeline.reset();
      return end.Fail("is no pipeline: it needs a source and, between exclamation marks, what follows it");
    }
    const GstOwned<GstBus> bus(gst_element_get_bus(pipeline.get()));
    gst_bus_set_sync_handler(bus.get(), Receive, &end, nullptr);
    EachOf(pipeline.get(), "appsink",
           [&](GstElement* each) { sink.reset(GST_ELEMENT(gst_object_ref(each))); });
    if (!sink) return end.Fail("it has no appsink, where images are taken");
    GstCaps* caps = gst_caps_from_string("video/x-raw,format=(string){BGR,GRAY8}");
    g_object_set(sink.get(), "caps", caps, nullptr);
    gst_caps_unref(caps);
  }

  void SetState(GstState state) {
    if (gst_element_set_state(pipeline.get(), state) == GST_STATE_CHANGE_FAILURE)
      end.Fail("GStreamer cannot start it");
  }

  void Filter(const RtpPayloads& payloads) {
    EachOf(pipeline.get(), "udpsrc", [&](GstElement* source) {
      GSocket* socket = nullptr;
      g_object_get(source, "used-socket", &socket, nullptr);
      if (!socket) return end.Fail("its UDP socket is not there");
      if (const std::string why = TakeRtpOnly(g_socket_get_fd(socket), payloads); !why.empty()) end.Fail(why);
      g_object_unref(socket);
    });
  }

  bool Failed() {
    const std::lock_guard lock(end.mutex);
    return end.over;
  }
  std::string Why() {
    const std::lock_guard lock(end.mutex);
    return end.error;
  }

  // The next that the sink has; empty: it has failed.
  cv::Mat Pull() {
    for (const double until_s = MonotonicNow_s() + kSilent_s; !Failed();) {
      GstSample* sample = nullptr;
      g_signal_emit_by_name(sink.get(), "try-pull-sample", static_cast<GstClockTime>(kLook_s * GST_SECOND),
                            &sample);
      if (sample) {
        cv::Mat image = ImageOf(sample);
        gst_sample_unref(sample);
        if (image.empty()) end.Fail("what comes is no image of grey levels or BGR");
        return image;
      }
      if (MonotonicNow_s() > until_s) end.Fail(fmt::format("no image came within {:g} s", kSilent_s));
    }
    return {};
  }

  PipelineEnd end;  // outlives the pipeline
  GstOwned<GstElement> pipeline, sink;
  cv::Mat first;
};

GStreamerPipeline::GStreamerPipeline() = default;
GStreamerPipeline::~GStreamerPipeline() = default;

bool GStreamerPipeline::Open(const std::string& description, const std::optional<RtpPayloads>& payloads) {
  impl_ = std::make_unique<Impl>();
  impl_->Make(description);
  // Sockets are there when it is ready, and nothing is read from them before it plays.
  if (!impl_->Failed()) impl_->SetState(GST_STATE_READY);
  if (!impl_->Failed() && payloads) impl_->Filter(*payloads);
  if (!impl_->Failed()) impl_->SetState(GST_STATE_PLAYING);
  if (!impl_->Failed()) impl_->first = impl_->Pull();
  if (!impl_->first.empty()) return true;
  error_ = impl_->Why();
  impl_.reset();
  return false;
}

cv::Mat GStreamerPipeline::Next() {
  if (!impl_) return {};
  cv::Mat image = std::exchange(impl_->first, cv::Mat());
  if (image.empty()) image = impl_->Pull();
  if (image.empty()) error_ = impl_->Why();
  return image;
}

}  // namespace kestrel::vision
