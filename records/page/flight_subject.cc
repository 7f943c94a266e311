// SPDX-License-Identifier: Apache-2.0
#include "records/page/flight_subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string_view>

#include "base/file/files.h"
#include "base/html/html.h"
#include "base/user_file.h"
#include "geometry/tait_bryan.h"
#include "records/page/flight_json.h"

namespace kestrel::records {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFile = "page.json";
constexpr int kPictureSide_px = 512;  // a pad fills no more than that of a page

Eigen::VectorXd VectorIn(const Json& json, Eigen::Index size) {
  const auto all = json.get<std::vector<double>>();
  if (static_cast<Eigen::Index>(all.size()) != size)
    throw std::runtime_error(fmt::format("{} numbers where {} belong", all.size(), size));
  return Eigen::Map<const Eigen::VectorXd>(all.data(), size);
}

Pose PoseIn(const Json& json) {
  const Eigen::VectorXd q = VectorIn(json.at("q"), 4);
  const Eigen::Quaterniond R(q[0], q[1], q[2], q[3]);
  if (!(std::abs(R.norm() - 1) < 1e-3)) throw std::runtime_error("a rotation of no unit length");
  return {R.normalized(), VectorIn(json.at("p"), 3)};
}

FlightSubject::Camera CameraIn(const Json& json, const char* pose) {
  const Eigen::VectorXd fov = VectorIn(json.at("fov_deg"), 2);
  const auto size = json.at("size_px").get<std::vector<int>>();
  if (size.size() != 2) throw std::runtime_error("a camera's size_px that is no width and height");
  return {json.at("name"), json.at("projection"), size[0], size[1], fov[0], fov[1], PoseIn(json.at(pose))};
}

FlightSubject::Pad PadIn(const Json& json) {
  FlightSubject::Pad pad{VectorIn(json.at("size_m"), 2), {}, json.at("picture")};
  if (const Json& placed = json.at("X_NT"); !placed.is_null()) pad.X_NT = PoseIn(placed);
  // It becomes the source of a picture: of nothing else.
  if (!pad.picture.empty() && !pad.picture.starts_with("data:image/"))
    throw std::runtime_error("a pad's picture that is no data:image/");
  return pad;
}

// Between the rays through the ends of the middle row or column; of a lens that does not fill them, twice what it
// sees from its axis.
double SeenAcross_deg(const vision::CameraModel& camera, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const auto from = vision::Ray(camera, a), to = vision::Ray(camera, b);
  if (!from || !to) return Degrees(2 * vision::MaxAngle(camera));
  // From the axis: what is beyond half a turn between the two is not on the other side.
  const auto angle = [](const Eigen::Vector3d& ray) { return std::atan2(ray.head<2>().norm(), ray.z()); };
  return Degrees(angle(*from) + angle(*to));
}

}  // namespace

FlightSubject::Camera CameraOf(const std::string& name, const vision::CameraModel& camera, const Pose& X) {
  const int w = vision::WidthPx(camera), h = vision::HeightPx(camera);
  const double u = (w - 1) / 2.0, v = (h - 1) / 2.0;
  return {name,
          vision::NameOf(camera),
          w,
          h,
          SeenAcross_deg(camera, {-0.5, v}, {w - 0.5, v}),
          SeenAcross_deg(camera, {u, -0.5}, {u, h - 0.5}),
          X};
}

std::string PictureOf(const cv::Mat& picture) {
  if (picture.empty()) return {};
  cv::Mat shown = picture;
  const double share = static_cast<double>(kPictureSide_px) / std::max(picture.cols, picture.rows);
  if (share < 1) cv::resize(picture, shown, {}, share, share, cv::INTER_AREA);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", shown, bytes, {cv::IMWRITE_JPEG_QUALITY, 85});
  return "data:image/jpeg;base64," + Base64({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

void WriteSubject(const std::filesystem::path& folder, const FlightSubject& subject) {
  WriteFile(folder / kFile, SubjectJson(subject).dump(1, ' ', false, Json::error_handler_t::replace) + '\n');
}

FlightSubject ReadSubject(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kFile;
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) throw std::runtime_error(fmt::format("{} {}", file.string(), content.error));
  try {
    const Json json = Json::parse(content.bytes);
    FlightSubject s;
    s.scenario = json.at("scenario");
    s.seed = json.at("seed");
    s.mode = json.at("mode");
    s.mission = json.at("mission");
    s.title = json.at("title");
    s.wanted = json.at("wanted");
    s.again = json.at("again");
    s.version = json.at("version");
    s.rate_hz = json.at("rate_hz");
    if (const Json& camera = json.at("camera"); !camera.is_null()) s.camera = CameraIn(camera, "X_BC");
    if (const Json ground = json.value("ground_camera", Json()); !ground.is_null())
      s.ground_camera = CameraIn(ground, "X_TC");
    if (const Json& pad = json.at("pad"); !pad.is_null()) s.pad = PadIn(pad);
    return s;
  } catch (const std::exception& e) {
    throw std::runtime_error(fmt::format("{}: not of a flight: {}", file.string(), e.what()));
  }
}

}  // namespace kestrel::records
