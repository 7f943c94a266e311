// SPDX-License-Identifier: Apache-2.0
#include "sim/render/opengl/opengl_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <shared_mutex>
#include <stdexcept>

#include "sim/world/frames.h"

namespace kestrel::sim {
namespace {

constexpr DepthRange kVisible{0.02, 500};
// For depth, far ones first. The steps of a depth buffer grow with z^2 / near: one for all would know 500 m
// to a metre only.
constexpr std::array<DepthRange, 3> kDepthParts{{{12, 500}, {0.5, 12.01}, {0.02, 0.501}}};
constexpr int kMaxSide_px = 8192;
constexpr int kSceneRoom = 2000;  // drawn things beyond the geoms of the model
constexpr int kBandRows = 16;
// Octaves of textures' sizes: OpenGL goes by the longer side of a pixel's footprint and interpolates between sizes,
// which blurs by more than the pixel does. With so much less it is nearest to the mean over many rays a pixel.
constexpr double kSharpening = 0.4;

// MuJoCo fills its process-wide table of OpenGL functions anew for each context: nobody may draw meanwhile.
std::shared_mutex gl_functions;

// The camera of MuJoCo's scene. It takes top and bottom of the frustum at the near plane, and the middle
// between left and right; half the width it derives from the height and the aspect of the viewport, so pixels
// must be square. The image ends half a pixel beyond the centres of its outer pixels.
mjvGLCamera EyeOf(const vision::Pinhole& c, const Pose& X_NV, DepthRange range) {
  mjvGLCamera eye{};
  eye.frustum_near = static_cast<float>(range.near_m);
  eye.frustum_far = static_cast<float>(range.far_m);
  eye.frustum_top = static_cast<float>(range.near_m * (c.cy + 0.5) / c.fy);
  eye.frustum_bottom = static_cast<float>(range.near_m * (c.cy + 0.5 - c.height_px) / c.fy);
  eye.frustum_center = static_cast<float>(range.near_m * ((c.width_px - 1) / 2.0 - c.cx) / c.fx);
  const Eigen::Vector3d p_MV = SwapNedNwu(X_NV.p);
  const Eigen::Vector3d forward_M = SwapNedNwu(X_NV.R * Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d up_M = SwapNedNwu(X_NV.R * -Eigen::Vector3d::UnitY());
  for (int i = 0; i < 3; ++i) {
    eye.pos[i] = static_cast<float>(p_MV[i]);
    eye.forward[i] = static_cast<float>(forward_M[i]);
    eye.up[i] = static_cast<float>(up_M[i]);
  }
  return eye;
}

// Whether a ball may show in a picture: none of the five planes of the frustum has all of it outside.
bool MayShow(const vision::Pinhole& c, const Eigen::Vector3d& p_VQ, double radius) {
  const double left = c.cx + 1, right = c.width_px - c.cx, top = c.cy + 1, bottom = c.height_px - c.cy;
  const auto inside = [&](double across,
                          double slope) {  // across: from the axis towards the plane, in pixels
    return c.fx * across - slope * p_VQ.z() <= radius * std::hypot(c.fx, slope);
  };
  return p_VQ.z() >= -radius && inside(-p_VQ.x(), left) && inside(p_VQ.x(), right) &&
         inside(-p_VQ.y(), top) && inside(p_VQ.y(), bottom);
}

// What the world and the camera are between at a time.
struct Between {
  const SceneState *before, *after;
  double share = 0;  // of the way from one to the other
  const SceneState& nearest() const { return share < 0.5 ? *before : *after; }
};
Between Find(std::span<const SceneState> states, double t_s) {
  const auto after =
      std::find_if(states.begin(), states.end(), [&](const SceneState& i) { return i.t_s > t_s; });
  if (after == states.begin()) return {&states.front(), &states.front()};
  if (after == states.end()) return {&states.back(), &states.back()};
  const SceneState& before = *std::prev(after);
  return {&before, &*after, (t_s - before.t_s) / (after->t_s - before.t_s)};
}

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
Eigen::Quaterniond Rotation(const mjtNum* mat) {
  return Eigen::Quaterniond(RowMajor(Eigen::Map<const RowMajor>(mat)));
}

void MoveBetween(const Between& b, mjvGeom& geom) {
  const mjtNum* const p0 = b.before->data->geom_xpos + 3 * geom.objid;
  const mjtNum* const p1 = b.after->data->geom_xpos + 3 * geom.objid;
  const mjtNum* const R0 = b.before->data->geom_xmat + 9 * geom.objid;
  const mjtNum* const R1 = b.after->data->geom_xmat + 9 * geom.objid;
  if (std::equal(p0, p0 + 3, p1) && std::equal(R0, R0 + 9, R1)) return;
  const RowMajor R = Rotation(R0).slerp(b.share, Rotation(R1)).toRotationMatrix();
  for (int i = 0; i < 3; ++i) geom.pos[i] = static_cast<float>(p0[i] + b.share * (p1[i] - p0[i]));
  for (int i = 0; i < 9; ++i) geom.mat[i] = static_cast<float>(R.data()[i]);
}

void Check(const vision::CameraModel& camera, const RenderOptions& options) {
  const int width = vision::WidthPx(camera), height = vision::HeightPx(camera);
  if (width < 1 || height < 1 || width > kMaxSide_px || height > kMaxSide_px)
    throw std::runtime_error(
        fmt::format("The renderer cannot draw an image of {} x {} pixels: each side from 1 to {}.", width,
                    height, kMaxSide_px));
  const Eigen::VectorXd all = vision::Parameters(camera);
  if (!(all[0] > 0) || !(all[1] > 0) || !all.allFinite())
    throw std::runtime_error(
        fmt::format("The renderer needs positive focal lengths and a finite principal point, "
                    "but fx = {}, fy = {}, cx = {}, cy = {}.",
                    all[0], all[1], all[2], all[3]));
  if (options.samples < 0)
    throw std::runtime_error(
        fmt::format("The renderer cannot take {} samples for each pixel.", options.samples));
}

}  // namespace

OpenGlRenderer::OpenGlRenderer(const mjModel* model, const vision::CameraModel& camera,
                               const RenderOptions& options, std::optional<LensFaces> faces)
    : model_(model), shadows_(options.shadows) {
  Check(camera, options);
  std::optional<LensFaces> only;
  if (!faces) only = OnlyFace(camera);
  direct_ = only.has_value();
  lens_ = only ? std::move(*only) : faces ? std::move(*faces) : PlanFaces(camera, kMaxSide_px);
  if (lens_.faces.empty())
    throw std::runtime_error(
        fmt::format("None of the {} x {} pixels of the camera has a ray: its lens shows nothing.",
                    lens_.width_px, lens_.height_px));
  int width = 1, height = 1;
  for (const Face& face : lens_.faces) {
    width = std::max(width, face.camera.width_px);
    height = std::max(height, face.camera.height_px);
  }
  rgb_.resize(3 * lens_.pixels);
  context_ = MakeGlContext(options.backend);
  name_ = context_->RendererName();

  mjv_defaultOption(&visible_);
  std::fill(visible_.flags, visible_.flags + mjNVISFLAG, 0);
  visible_.flags[mjVIS_TEXTURE] = visible_.flags[mjVIS_STATIC] = 1;
  std::fill(visible_.sitegroup, visible_.sitegroup + mjNGROUP, 0);  // marks for the program, not for the eye

  mjModel shown = *model;  // shares the arrays: only these numbers are read from the copy
  shown.vis.global.offwidth = width;
  shown.vis.global.offheight = height;
  shown.vis.quality.offsamples = options.samples;
  if (!options.shadows) shown.vis.quality.shadowsize = 0;
  mjr_defaultContext(&gpu_);
  {
    const std::unique_lock lock(gl_functions);
    mjr_makeContext(&shown, &gpu_, mjFONTSCALE_50);
  }
  // The faces' finer pixels are for edges. Of textures, a pixel of the lens shows what its own size lets
  // through.
  context_->BlurTextures(direct_ ? -kSharpening : std::log2(kFinerThanLens));
  mjr_setBuffer(mjFB_OFFSCREEN, &gpu_);
  if (gpu_.currentBuffer != mjFB_OFFSCREEN || gpu_.offWidth != width || gpu_.offHeight != height) {
    mjr_freeContext(&gpu_);
    throw std::runtime_error(
        fmt::format("{} cannot draw off screen at {} x {} pixels.", name_, width, height));
  }
  try {
    if (!direct_) lookup_ = std::make_unique<LensLookup>(*context_, lens_);
  } catch (const std::runtime_error&) {
    mjr_freeContext(&gpu_);
    throw;
  }
  mjv_defaultScene(&scene_);
  mjv_makeScene(model, &scene_, model->ngeom + kSceneRoom);
}

OpenGlRenderer::~OpenGlRenderer() {
  const std::shared_lock lock(gl_functions);
  lookup_.reset();
  mjv_freeScene(&scene_);
  mjr_freeContext(&gpu_);
}

void OpenGlRenderer::SetScene(const mjData* data, const Pose& X_NC) {
  X_NC_ = X_NC;
  // Planes without end are centred on the eye. The light on the camera shines along its axis, not that of
  // each face.
  const mjvGLCamera eye = EyeOf(lens_.faces.front().camera, X_NC, kVisible);
  scene_.camera[0] = scene_.camera[1] = eye;
  mjvCamera as_it_is;
  mjv_defaultCamera(&as_it_is);
  as_it_is.type = mjCAMERA_USER;
  // MuJoCo asks for the state to be writable to draw the perturbations of a mouse, of which there are none.
  mjv_updateScene(model_, const_cast<mjData*>(data), &visible_, nullptr, &as_it_is, mjCAT_ALL, &scene_);
  for (int i = 0; i < scene_.nlight; ++i) {
    mjvLight& light = scene_.lights[i];
    if (!light.headlight) continue;
    light.headlight = 0;
    std::copy(eye.pos, eye.pos + 3, light.pos);
    std::copy(eye.forward, eye.forward + 3, light.dir);
  }
  scene_.flags[mjRND_SHADOW] = shadows_;
  scene_.flags[mjRND_REFLECTION] = 0;
  scene_.flags[mjRND_SKYBOX] = scene_.flags[mjRND_HAZE] = 1;
  geoms_.assign(scene_.geoms, scene_.geoms + scene_.ngeom);
}

void OpenGlRenderer::SetScene(std::span<const SceneState> states, double t_s) {
  const Between now = Find(states, t_s);
  const Pose &a = now.before->X_NC, &b = now.after->X_NC;
  SetScene(now.nearest().data, {a.R.slerp(now.share, b.R), a.p + now.share * (b.p - a.p)});
  if (now.share > 0 && now.before->data != now.after->data)
    for (mjvGeom& geom : geoms_)
      if (geom.objtype == mjOBJ_GEOM) MoveBetween(now, geom);
}

void OpenGlRenderer::Draw(const Face& face, DepthRange range) {
  const Pose X_NV{X_NC_.R * face.R_CV, X_NC_.p};
  scene_.camera[0] = scene_.camera[1] = EyeOf(face.camera, X_NV, range);  // two eyes, which MuJoCo averages
  // Things beside the picture cost time, unless their shadows are in it.
  const Pose X_VN = X_NV.Inverse();
  scene_.ngeom = 0;
  for (const mjvGeom& geom : geoms_) {
    const double radius = geom.objtype == mjOBJ_GEOM ? model_->geom_rbound[geom.objid] : 0;  // 0: without end
    const Eigen::Vector3d p_VQ = X_VN * SwapNedNwu(Eigen::Vector3d(geom.pos[0], geom.pos[1], geom.pos[2]));
    if (shadows_ || !(radius > 0) || MayShow(face.camera, p_VQ, radius)) scene_.geoms[scene_.ngeom++] = geom;
  }
  mjr_setBuffer(mjFB_OFFSCREEN, &gpu_);
  mjr_render({0, 0, face.camera.width_px, face.camera.height_px}, &scene_, &gpu_);
}

void OpenGlRenderer::DrawRows(Rows rows, cv::Mat& image) {
  if (direct_) {
    const Face& face = lens_.faces.front();
    Draw(face, kVisible);
    mjr_readPixels(rgb_.data(), nullptr, {0, 0, lens_.width_px, lens_.height_px}, &gpu_);
    const cv::Mat rgb(lens_.height_px, lens_.width_px, CV_8UC3, rgb_.data());
    for (int v = rows.first; v < rows.end; ++v)
      cv::cvtColor(rgb.row(lens_.height_px - 1 - v), image.row(v), cv::COLOR_RGB2BGR);
    return;
  }
  const auto patches = std::span(lens_.patches)
                           .subspan(static_cast<std::size_t>(rows.first) * lens_.width_px,
                                    static_cast<std::size_t>(rows.end - rows.first) * lens_.width_px);
  std::vector<bool> used(lens_.faces.size());
  for (const Patch& patch : patches)
    if (patch.face != Patch::kOutside) used[patch.face] = true;
  for (std::size_t k = 0; k < lens_.faces.size(); ++k) {
    if (!used[k]) continue;
    Draw(lens_.faces[k], kVisible);
    lookup_->Take(k, gpu_);
  }
  lookup_->Fill(rows.first, rows.end, image);
}

cv::Mat OpenGlRenderer::Render(const mjData* data, const Pose& X_NC) {
  const std::shared_lock lock(gl_functions);
  cv::Mat image(lens_.height_px, lens_.width_px, CV_8UC3);
  SetScene(data, X_NC);
  DrawRows({0, lens_.height_px}, image);
  return image;
}

cv::Mat OpenGlRenderer::Render(std::span<const SceneState> states, const Shutter& shutter) {
  const std::shared_lock lock(gl_functions);
  const int rows_at_once = shutter.line_s == 0 ? lens_.height_px : kBandRows;
  cv::Mat image(lens_.height_px, lens_.width_px, CV_8UC3), sum(image.size(), CV_32FC3, cv::Scalar::all(0));
  for (int first = 0; first < lens_.height_px; first += rows_at_once) {
    const Rows rows{first, std::min(first + rows_at_once, lens_.height_px)};
    const double middle_s = shutter.row_0_s + shutter.line_s * (rows.first + rows.end - 1) / 2;
    for (int k = 0; k < shutter.samples; ++k) {
      SetScene(states, middle_s + shutter.exposure_s * ((k + 0.5) / shutter.samples - 0.5));
      DrawRows(rows, image);
      if (shutter.samples > 1)
        cv::accumulate(image.rowRange(rows.first, rows.end), sum.rowRange(rows.first, rows.end));
    }
  }
  if (shutter.samples > 1) sum.convertTo(image, CV_8U, 1.0 / shutter.samples);
  return image;
}

Surfaces OpenGlRenderer::Trace(const mjData* data, const Pose& X_NC) {
  const std::shared_lock lock(gl_functions);
  SetScene(data, X_NC);
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 1;
  for (mjvGeom& geom : geoms_) geom.segid = geom.objtype == mjOBJ_GEOM ? geom.objid : -1;
  // Of all faces: the id, -1 for the sky, and one over the depth, which a plane has linear in the picture.
  std::vector<int> ids(lens_.pixels, -1);
  std::vector<float> inverse_depth(lens_.pixels), depth(lens_.pixels);
  for (const Face& face : lens_.faces) {
    const mjrRect whole{0, 0, face.camera.width_px, face.camera.height_px};
    for (const DepthRange& range : kDepthParts) {
      Draw(face, range);
      mjr_readPixels(rgb_.data() + 3 * face.first, depth.data() + face.first, whole, &gpu_);
      const std::size_t end = face.first + static_cast<std::size_t>(whole.width) * whole.height;
      for (std::size_t i = face.first; i < end; ++i) {
        const int id = rgb_[3 * i] + (rgb_[3 * i + 1] << 8) + (rgb_[3 * i + 2] << 16) - 1;
        if (id < 0) continue;
        ids[i] = id;
        inverse_depth[i] =
            static_cast<float>(1 / range.near_m + depth[i] * (1 / range.far_m - 1 / range.near_m));
      }
    }
  }
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 0;

  Surfaces seen{cv::Mat(lens_.height_px, lens_.width_px, CV_32F),
                cv::Mat(lens_.height_px, lens_.width_px, CV_32S)};
  for (std::size_t i = 0; i < lens_.patches.size(); ++i) {
    const Patch& patch = lens_.patches[i];
    float& distance = seen.depth_m.ptr<float>()[i];
    int& geom = seen.geom.ptr<int>()[i];
    if (patch.face == Patch::kOutside) {
      distance = std::numeric_limits<float>::quiet_NaN();
      geom = -2;
      continue;
    }
    const Face& face = lens_.faces[patch.face];
    const double right = (patch.x & 0xFFFF) / 65536.0, up = (patch.y & 0xFFFF) / 65536.0;
    const std::size_t row = face.camera.width_px;
    const std::size_t low = face.first + (patch.y >> 16) * row + (patch.x >> 16);
    const std::size_t high = low + (up > 0 ? row : 0);  // not beyond the last row or column
    const std::array<std::size_t, 4> four{low, low + (right > 0), high, high + (right > 0)};
    const std::size_t nearest = four[(right >= 0.5) + 2 * (up >= 0.5)];
    geom = ids[nearest];
    if (geom < 0) {
      distance = std::numeric_limits<float>::infinity();
      continue;
    }
    double inverse = inverse_depth[nearest];
    if (std::all_of(four.begin(), four.end(), [&](std::size_t k) { return ids[k] == geom; }))
      inverse = (1 - up) * ((1 - right) * inverse_depth[four[0]] + right * inverse_depth[four[1]]) +
                up * ((1 - right) * inverse_depth[four[2]] + right * inverse_depth[four[3]]);
    distance = static_cast<float>(lens_.stretch[i] / inverse);
  }
  return seen;
}

}  // namespace kestrel::sim
