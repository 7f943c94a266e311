// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/images/truth_images.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <regex>
#include <stdexcept>
#include <string>

#include "base/file/files.h"
#include "vision/write_image.h"

namespace kestrel::flight {
namespace fs = std::filesystem;
namespace {

constexpr float kUnknownFlow = 1e10f;
constexpr int kFirstGeom = 2;  // value of geom 0; below it the sky and what is outside the lens

std::string NameOr(const mjModel* model, mjtObj kind, int id) {
  const char* name = mj_id2name(model, kind, id);
  return name && *name ? name : fmt::format("{}", id);
}

}  // namespace

std::string GeomsCsv(const mjModel* model) {
  std::string geoms = "value,name,body\n0,outside the lens,\n1,sky,\n";
  for (int g = 0; g < model->ngeom; ++g)
    geoms += fmt::format("{},{},{}\n", g + kFirstGeom, NameOr(model, mjOBJ_GEOM, g),
                         NameOr(model, mjOBJ_BODY, model->geom_bodyid[g]));
  return geoms;
}

cv::Mat GeomPicture(const cv::Mat& geom) {
  cv::Mat values;
  cv::add(geom, kFirstGeom, values, {}, CV_16U);
  return values;
}

// As cv::writeOpticalFlow does, which does not tell whether all of it could be written.
std::string FlowFile(const cv::Mat& flow_px) {
  const std::int32_t size[] = {flow_px.cols, flow_px.rows};
  cv::Mat flow = flow_px.clone();
  flow.forEach<cv::Vec2f>([](cv::Vec2f& v, const int*) {
    if (std::isnan(v[0])) v = {kUnknownFlow, kUnknownFlow};
  });
  std::string bytes = "PIEH";
  bytes.append(reinterpret_cast<const char*>(size), sizeof size);
  bytes.append(flow.ptr<char>(), flow.total() * flow.elemSize());
  return bytes;
}

TruthImages::TruthImages(fs::path folder, const mjModel* model) : folder_(std::move(folder)) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", folder_.string(), error.message()));
  static const std::regex ours(R"(\d{6,}_(image\.png|depth\.tiff|geom\.png|flow\.flo)(\.part)?)");
  for (const auto& entry : fs::directory_iterator(folder_))
    if (std::regex_match(entry.path().filename().string(), ours)) fs::remove(entry.path());
  WriteFile(folder_ / "geoms.csv", GeomsCsv(model));
}

fs::path TruthImages::Name(std::int64_t sequence, const char* what) const {
  return folder_ / fmt::format("{:06}_{}", sequence, what);
}

void TruthImages::Write(std::int64_t sequence, const sim::RenderedFrame& picture) {
  vision::WriteImage(Name(sequence, "image.png"), picture.image);
  vision::WriteImage(Name(sequence, "depth.tiff"), picture.surfaces.depth_m);
  vision::WriteImage(Name(sequence, "geom.png"), GeomPicture(picture.surfaces.geom));
  if (last_ && !picture.flow_here.empty()) WriteFile(Name(*last_, "flow.flo"), FlowFile(picture.flow_here));
  last_ = sequence;
}

}  // namespace kestrel::flight
