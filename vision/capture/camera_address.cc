// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/camera_address.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <system_error>
#include <utility>
#include <vector>

#include "base/nearest_name.h"
#include "base/user_file.h"
#include "vision/capture/recorded/recorded_images.h"
#include "vision/capture/rtp_stream.h"
#include "vision/image_file.h"

namespace kestrel::vision {
namespace {

using Kind = OpenCvSourceOptions::Kind;

struct Form {
  const char* scheme;
  const char* example;
  const char* what;
  std::vector<std::string> options;
};

const std::vector<Form>& Forms() {
  static const std::vector<Form> forms = {
      {"v4l2", "v4l2:/dev/video0", "a camera of Video4Linux", {"width", "height", "rate", "colour"}},
      {"aravis",
       "aravis:ID",
       "a GenICam camera (GigE Vision, USB3 Vision); without ID the first",
       {"width", "height", "rate", "colour", "exposure_us", "gain"}},
      {"dc1394", "dc1394:0", "a camera of IEEE 1394, by its number", {"width", "height", "rate", "colour"}},
      {"rtp",
       "rtp://127.0.0.1:5600",
       "RTP of MJPEG that comes to this address",
       {"width", "height", "colour"}},
      {"raw",
       "raw://127.0.0.1:5600?width=640&height=480",
       "RTP of raw video that comes to this address; a lost packet tears the image: loopback only",
       {"width", "height", "colour"}},
      {"gst", "gst:PIPELINE", "a pipeline of GStreamer, up to its appsink", {"width", "height", "colour"}},
      {"file",
       "file:PATH",
       "a video, a folder of images, a pattern of them (image%04d.png), or a recording (EuRoC, TUM, KITTI, "
       "MCAP)",
       {"width", "height", "rate", "colour", "bits", "topic"}},
  };
  return forms;
}

std::optional<double> ToNumber(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || at != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

// The options of one address, and the mistakes of the whole.
class Reader {
 public:
  explicit Reader(const std::string& address) : address_(address) {}

  void Wrong(const std::string& key, const std::string& what, const std::string& remedy = {}) {
    mistakes_.Add(PlaceOfCamera(address_), key, what, remedy);
  }
  void ThrowIfAny() const { mistakes_.ThrowIfAny(); }
  Mistakes& mistakes() { return mistakes_; }

  void Take(const std::string& options, const Form& form) {
    for (std::size_t from = 0; from < options.size();) {
      const std::size_t end = std::min(options.find('&', from), options.size());
      const std::string each = options.substr(from, end - from);
      from = end + 1;
      const std::size_t equals = each.find('=');
      const std::string key = each.substr(0, equals);
      if (equals == std::string::npos) {
        Wrong(each, "is not of the form key=value");
      } else if (std::find(form.options.begin(), form.options.end(), key) == form.options.end()) {
        const auto near = NearestName(key, form.options);
        Wrong(key, fmt::format("is no option of {}:", form.scheme),
              fmt::format("{}valid are {}", near ? fmt::format("did you mean {}? ", *near) : "",
                          fmt::join(form.options, ", ")));
      } else if (!given_.emplace(key, each.substr(equals + 1)).second) {
        Wrong(key, "is given twice");
      }
    }
  }

  std::optional<double> Number(const std::string& key, double low, double high) {
    const auto found = given_.find(key);
    if (found == given_.end()) return std::nullopt;
    const std::optional<double> value = ToNumber(found->second);
    if (value && *value >= low && *value <= high) return value;
    Wrong(key, fmt::format("= {} must be a number from {:g} to {:g}", found->second, low, high));
    return std::nullopt;
  }

  cv::Size Size() {
    constexpr double kMost = 16384;
    const auto side = [&](const char* key) {
      const std::optional<double> value = Number(key, 1, kMost);
      if (value && *value != std::floor(*value)) Wrong(key, "must be a whole number of pixels");
      return value ? static_cast<int>(*value) : 0;
    };
    const cv::Size size(side("width"), side("height"));
    if (given_.contains("width") != given_.contains("height"))
      Wrong(given_.contains("width") ? "height" : "width", "must be given too");
    return size;
  }

  std::string Text(const std::string& key) const {
    const auto found = given_.find(key);
    return found == given_.end() ? "" : found->second;
  }

  bool Colour() {
    const auto found = given_.find("colour");
    if (found == given_.end()) return false;
    if (found->second != "true" && found->second != "false")
      Wrong("colour", fmt::format("= {} must be true or false", found->second));
    return found->second == "true";
  }

 private:
  std::string address_;
  Mistakes mistakes_;
  std::map<std::string, std::string> given_;
};

void Receive(Reader& reader, const Form& form, const std::string& rest, OpenCvSourceOptions& source) {
  std::smatch parts;
  static const std::regex host_and_port(R"(//([0-9A-Za-z][0-9A-Za-z.-]*):(\d{1,5}))");
  int port = 0;
  if (std::regex_match(rest, parts, host_and_port)) port = std::stoi(parts[2]);
  if (port < 1 || port > 65535) {
    reader.Wrong("", fmt::format("must be {}://HOST:PORT, the port from 1 to 65535, as in {}", form.scheme,
                                 form.example));
    return;
  }
  const bool raw = std::string(form.scheme) == "raw";
  if (raw && source.size.empty())
    reader.Wrong("", fmt::format("needs width and height, as in {}", form.example));
  // GStreamer gives a raw image that lacks packets as if it were whole, and a JPEG only if it is.
  source.host = parts[1], source.port = port;
  source.payloads = PayloadsOf(raw ? RtpStream::Coding::kRaw : RtpStream::Coding::kJpeg);
  source.what = ReceivingPipeline({raw ? RtpStream::Coding::kRaw : RtpStream::Coding::kJpeg, parts[1], port},
                                  source.size, source.colour);
}

}  // namespace

Place PlaceOfCamera(const std::string& address) { return "--camera " + address; }

CameraAddress ParseCameraAddress(const std::string& address) {
  Reader reader(address);
  std::vector<std::string> schemes;
  for (const Form& form : Forms()) schemes.emplace_back(form.scheme);
  const std::size_t colon = address.find(':');
  const std::string scheme = address.substr(0, colon);
  const auto form =
      std::find_if(Forms().begin(), Forms().end(), [&](const Form& f) { return scheme == f.scheme; });
  if (colon == std::string::npos || form == Forms().end()) {
    const auto near = NearestName(scheme, schemes);
    reader.Wrong("",
                 fmt::format("names no kind of camera{}; valid are\n{}",
                             near ? fmt::format(" (did you mean {}:?)", *near) : "", CameraAddressForms()));
    reader.ThrowIfAny();
  }

  // A file's name and a pipeline may have a question mark of their own: then what follows is no option.
  std::string rest = address.substr(colon + 1), options;
  const std::size_t mark = rest.rfind('?');
  static const std::regex key_values(
      R"((topic=[^&\s!]*|[a-z_]+=[^&\s/!]*)(&(topic=[^&\s!]*|[a-z_]+=[^&\s/!]*))*)");
  const bool may_have_its_own = scheme == "file" || scheme == "gst";
  if (mark != std::string::npos &&
      (!may_have_its_own ||
       std::regex_match(rest.begin() + static_cast<long>(mark) + 1, rest.end(), key_values))) {
    options = rest.substr(mark + 1);
    rest.resize(mark);
  }
  reader.Take(options, *form);
  const cv::Size size = reader.Size();
  const bool colour = reader.Colour();
  std::optional<int> bits;
  if (const auto given = reader.Number("bits", 8, 16)) {
    bits = static_cast<int>(*given);
    if (*given != *bits) reader.Wrong("bits", "must be a whole number");
  }
  const double rate_hz = reader.Number("rate", 0.01, 10000).value_or(0);

  CameraAddress camera;
  if (scheme == "aravis") {
#ifdef KESTREL_WITHOUT_ARAVIS
    reader.Wrong("", "this build has no Aravis; build anew with Debian's libaravis-dev and libusb-1.0-0-dev");
#endif
    camera = AravisSourceOptions{.id = rest,
                                 .size = size,
                                 .rate_hz = rate_hz,
                                 .exposure_us = reader.Number("exposure_us", 1, 1e7),
                                 .gain = reader.Number("gain", -100, 10000),
                                 .colour = colour};
  } else if (std::error_code error;
             scheme == "file" &&
             (IsRecording(rest) || rest.find('%') != std::string::npos || LooksLikeImage(rest))) {
    const auto recorded = std::make_shared<const RecordedImages>(
        OpenRecordedImages(rest, reader.Text("topic"), reader.mistakes()));
    camera = FolderSourceOptions{.images = rest,
                                 .topic = reader.Text("topic"),
                                 .opened = recorded,
                                 .size = size,
                                 .rate_hz = rate_hz,
                                 .as_recorded = recorded->stamped() && rate_hz == 0,
                                 .colour = colour,
                                 .bits = bits};
  } else {
    OpenCvSourceOptions source{.what = rest, .size = size, .rate_hz = rate_hz, .colour = colour};
    if (rest.empty()) reader.Wrong("", fmt::format("names nothing; it must be like {}", form->example));
    if (scheme == "v4l2") {
      source.kind = Kind::kV4l2;
      if (!rest.empty() && rest[0] != '/')
        reader.Wrong("", "must be the path of a device, as v4l2:/dev/video0");
    } else if (scheme == "dc1394") {
      source.kind = Kind::kIeee1394;
      const auto number = ToNumber(rest);
      if (!number || *number < 0 || *number > 63 || *number != std::floor(*number))
        reader.Wrong("", "must be the number of a camera from 0 to 63, as dc1394:0");
    } else if (scheme == "file") {
      source.kind = Kind::kFile;
      if (!IsFile(rest)) reader.Wrong("", "there is no file or folder: " + NoSuchFile(rest));
    } else {
      source.kind = Kind::kGStreamer;
      if (scheme != "gst") Receive(reader, *form, rest, source);
    }
    camera = source;
  }
  reader.ThrowIfAny();
  return camera;
}

ImageSourceMaker SourceAt(const CameraAddress& address) {
  struct {
    ImageSourceMaker operator()(const OpenCvSourceOptions& o) const { return OpenCvSource(o); }
#ifdef KESTREL_WITHOUT_ARAVIS
    ImageSourceMaker operator()(const AravisSourceOptions&) const { return {}; }  // its address was refused
#else
    ImageSourceMaker operator()(const AravisSourceOptions& o) const { return AravisSource(o); }
#endif
    ImageSourceMaker operator()(const FolderSourceOptions& o) const { return FolderSource(o); }
  } const make;
  return std::visit(make, address);
}

cv::Size SizeAt(const CameraAddress& address) {
  return std::visit([](const auto& options) { return options.size; }, address);
}

std::string CameraAddressForms() {
  std::string text;
  for (const Form& form : Forms())
    text += fmt::format("  {:<42} {}\n  {:<42} options: {}\n", form.example, form.what, "",
                        fmt::join(form.options, ", "));
  return text +
         "  Options follow as ?key=value&key=value. rate: images per second; colour: true or false (grey); "
         "bits: "
         "of a folder's images whose pixels have 16, how many the camera has; topic: which camera of a "
         "recording (cam1, /camera/image_raw). The images of a recording with stamps come by these, unless a "
         "rate is given.";
}

}  // namespace kestrel::vision
