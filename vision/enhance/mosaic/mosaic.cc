// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/mosaic.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "vision/camera/views.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLeastCorners = 20;  // of an image that can be followed

cv::Mat GreyOf(const cv::Mat& image) {
  if (image.channels() == 1) return image.clone();
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// Of a plane without a camera any pinhole will do: the homographies are the same, with other numbers. By this one
// the first image's pixels are those of the surface.
Pinhole AnyPinhole(cv::Size size) {
  const double f_px = std::max(size.width, size.height);
  return {.width_px = size.width,
          .height_px = size.height,
          .fx = f_px,
          .fy = f_px,
          .cx = std::floor((size.width - 1) / 2.0),
          .cy = std::floor((size.height - 1) / 2.0)};
}

// W laid out by N, of a camera that turns: x east, y down, z north.
Matrix3d NorthUp() {
  Matrix3d R_WN;
  R_WN << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return R_WN;
}

// A homography is known up to scale; this one keeps its numbers from growing.
Matrix3d Normalised(MosaicModel model, const Matrix3d& M) {
  return model == MosaicModel::kPlane ? Matrix3d(M / M(2, 2)) : M;
}

}  // namespace

const char* NameOf(MosaicState state) {
  switch (state) {
    case MosaicState::kFirst:
      return "first";
    case MosaicState::kFollowed:
      return "followed";
    case MosaicState::kFound:
      return "found";
    case MosaicState::kByPose:
      return "by_pose";
    case MosaicState::kLost:
      return "lost";
    case MosaicState::kNoTexture:
      return "no_texture";
    case MosaicState::kOblique:
      return "oblique";
    case MosaicState::kOtherSize:
      return "other_size";
    case MosaicState::kUnreadable:
      return "unreadable";
    case MosaicState::kFull:
      return "full";
  }
  return "";
}

bool IsPlaced(MosaicState state) {
  return state == MosaicState::kFirst || state == MosaicState::kFollowed || state == MosaicState::kFound ||
         state == MosaicState::kByPose;
}

Mosaic::Mosaic(const MosaicOptions& options) : options_(options) {
  if (options.model == MosaicModel::kRotation && !options.camera)
    throw std::invalid_argument("a mosaic of rotations needs the camera");
  if (options.model == MosaicModel::kPlane && options.surface != Surface::kPlane)
    throw std::invalid_argument("the mosaic of a plane is drawn on a plane");
}

void Mosaic::Begin(const cv::Mat& image) {
  camera_ = options_.camera.value_or(AnyPinhole(image.size()));
  type_ = image.type();
  projection_.emplace(camera_, options_.surface, CentralResolution(camera_));
  canvas_.emplace(options_.blending, image.channels(), options_.most_bytes / 2);
}

bool Mosaic::CanLayOut(const std::optional<Pose>& X_NC) const {
  return X_NC && options_.camera &&
         (options_.model == MosaicModel::kRotation || X_NC->p.z() < options_.ground_down_m);
}

void Mosaic::LayOutAt(const Pose& X_NC) {
  has_poses_ = true;
  first_ = {X_NC.p.x(), X_NC.p.y(), options_.ground_down_m - X_NC.p.z()};
}

// By the pose of an image that is at M_WC in a mosaic without poses.
bool Mosaic::LayOutAnew(const Pose& X_NC, const Matrix3d& M_WC) {
  LayOutAt(X_NC);
  const Matrix3d M_VW = FromPose(X_NC) * M_WC.inverse();
  std::vector<Matrix3d> M_VK;
  for (const Matrix3d& M : M_WK_) M_VK.push_back(Normalised(options_.model, M_VW * M));
  if (std::any_of(M_VK.begin(), M_VK.end(), [this](const Matrix3d& M) { return IsOblique(M); })) {
    has_poses_ = false;
    return false;
  }
  M_WK_ = std::move(M_VK);
  Redraw();
  return true;
}

// Of a plane seen from its side an image is stretched without end.
bool Mosaic::IsOblique(const Matrix3d& M_WC) const {
  constexpr double kMostStretched = 30;
  const cv::Rect part = projection_->PartOf(M_WC);
  return part.empty() || (options_.surface == Surface::kPlane &&
                          1.0 * part.width * part.height > kMostStretched * projection_->image_size().area());
}

// Of a plane: the ground is met by the ray r = R_NC ray at p + r (g - p_z) / r_z, from which (north, east, 1)
// follows by a matrix, and W by the first image's place and height, so that f_px pixels are as long as that.
Matrix3d Mosaic::FromPose(const Pose& X_NC) const {
  const Matrix3d R = X_NC.R.toRotationMatrix();
  if (options_.model == MosaicModel::kRotation) return NorthUp() * R;
  const double height_m = options_.ground_down_m - X_NC.p.z();
  Matrix3d ground, W;
  ground.row(0) = height_m * R.row(0) + X_NC.p.x() * R.row(2);
  ground.row(1) = height_m * R.row(1) + X_NC.p.y() * R.row(2);
  ground.row(2) = R.row(2);
  W << 0, 1, -first_.y(), -1, 0, first_.x(), 0, 0, first_.z();
  return W * ground;
}

// The centre is where the first camera was. Nothing is known of the ground for one that is not over it.
GroundParallax Mosaic::ParallaxAt(const Pose& X_NC) const {
  const double height_m = options_.ground_down_m - X_NC.p.z();
  if (height_m <= 0) return {};
  const Matrix3d R_CN = X_NC.R.toRotationMatrix().transpose();
  const Vector3d centre(first_.x(), first_.y(), options_.ground_down_m - first_.z());
  return {R_CN * (X_NC.p - centre) / height_m, R_CN.col(2)};
}

double Mosaic::PoseSigma_px() const {
  const double f = CentralResolution(camera_), turned_px = f * options_.pose_sigma_deg * M_PI / 180;
  const double moved_px =
      options_.model == MosaicModel::kRotation ? 0 : f * options_.pose_sigma_m / std::max(first_.z(), 1e-3);
  return std::max(std::hypot(turned_px, moved_px), 1e-2);
}

MosaicStep Mosaic::Refuse(MosaicState state, MosaicStep step) {
  step.state = state;
  placements_.push_back({state, -1, Matrix3d::Identity()});
  return step;
}

MosaicStep Mosaic::Add(const cv::Mat& image, double, const std::optional<Pose>& X_NC) {
  MosaicStep step;
  step.number = images();
  last_pairs_.clear();
  against_pose_ = false;
  if (image.empty()) return Refuse(MosaicState::kUnreadable, step);
  if ((projection_ && (image.size() != projection_->image_size() || image.type() != type_)) ||
      (!projection_ && options_.camera &&
       image.size() != cv::Size(WidthPx(*options_.camera), HeightPx(*options_.camera))))
    return Refuse(MosaicState::kOtherSize, step);
  RegisteredImage registered(GreyOf(image), options_.max_points, options_.opencl);
  if (keyframes_.empty()) {
    if (static_cast<int>(registered.corners().size()) < kLeastCorners)
      return Refuse(MosaicState::kNoTexture, step);
    Begin(image);
    if (CanLayOut(X_NC)) LayOutAt(*X_NC);
    const MaybePlaced M_WC = has_poses_ ? MaybePlaced(FromPose(*X_NC)) : std::nullopt;
    if (IsOblique(M_WC.value_or(Matrix3d::Identity()))) {
      projection_.reset(), canvas_.reset();
      has_poses_ = false;
      return Refuse(MosaicState::kOblique, step);
    }
    step.state = MosaicState::kFirst;
    MakeKeyframe(image, std::move(registered), M_WC.value_or(Matrix3d::Identity()), M_WC, nullptr, step);
    DrawImage(*projection_, image, M_WK_[0], *canvas_, options_.blending);
    return step;
  }
  const bool by_pose = has_poses_ && CanLayOut(X_NC);
  MaybePlaced M_WC_pose = by_pose ? MaybePlaced(FromPose(*X_NC)) : std::nullopt;
  if (by_pose && options_.model == MosaicModel::kRotation) registered.parallax = ParallaxAt(*X_NC);
  std::optional<Found> found = lost_ == 0 ? Follow(registered, M_WC_pose) : std::nullopt;
  step.state = MosaicState::kFollowed;
  if (!found) {
    found = Find(registered, M_WC_pose);
    step.state = MosaicState::kFound;
  }
  step.against_pose = against_pose_ && !found;
  Matrix3d M_WC;
  if (found) {
    M_WC = M_WK_[static_cast<std::size_t>(found->keyframe)] * found->motion.M_AB;
    step.agreed = static_cast<int>(found->motion.pairs.size());
    step.rms_px = found->motion.rms_px;
    last_pairs_ = found->motion.pairs;
    step.shared = SharedWith(camera_, found->motion.M_AB);
  } else if (M_WC_pose) {
    step.state = MosaicState::kByPose;
    M_WC = *M_WC_pose;
  } else {
    ++lost_;
    return Refuse(static_cast<int>(registered.corners().size()) < kLeastCorners ? MosaicState::kNoTexture
                                                                                : MosaicState::kLost,
                  step);
  }
  if (found && !has_poses_ && CanLayOut(X_NC) && LayOutAnew(*X_NC, M_WC)) M_WC_pose = M_WC = FromPose(*X_NC);
  M_WC = Normalised(options_.model, M_WC);
  if (IsOblique(M_WC)) {
    ++lost_;
    return Refuse(MosaicState::kOblique, step);
  }
  lost_ = 0;
  constexpr double kLeastAgreed = 0.4;  // of the keyframe's places that it shares: then they run out
  const bool is_new =
      !found || step.shared < options_.keyframe_overlap ||
      step.agreed <
          kLeastAgreed * step.shared *
              static_cast<double>(keyframes_[static_cast<std::size_t>(found->keyframe)].corners().size());
  if (is_new) {
    if (!HasRoom() && !pending_.empty()) pending_.pop_back();  // of those the one that it shows most of
    if (!HasRoom()) return Refuse(MosaicState::kFull, step);
    MakeKeyframe(image, std::move(registered), M_WC, M_WC_pose, found ? &*found : nullptr, step);
  } else {
    const Matrix3d M_KC = Normalised(options_.model, found->motion.M_AB);
    M_KC_before_ = found->keyframe == current_ ? M_KC_last_ : M_KC;
    M_KC_last_ = M_KC, M_WC_pose_last_ = M_WC_pose;
    current_ = found->keyframe;
    step.keyframe = current_;
    placements_.push_back({step.state, current_, M_KC});
    // What its pose says of the keyframe.
    if (M_WC_pose) priors_.push_back({current_, *M_WC_pose * M_KC.inverse(), PoseSigma_px()});
    constexpr double kWorthKeeping = 0.02;
    constexpr std::size_t kMostPending = 24;
    if (pending_.size() < kMostPending && HasRoom() && UncoveredShare(M_WC) > kWorthKeeping)
      pending_.push_back({step.number, image.clone(), projection_->PartOf(M_WC)});
  }
  // A little with each image, so that none takes long.
  JoinNext(step);
  AdjustWhenDue(step);
  RedrawTile();
  DrawImage(*projection_, image, *this->M_WC(step.number), *canvas_, options_.blending);
  return step;
}

MosaicPicture Mosaic::Picture(int stride) const {
  return canvas_ ? canvas_->Picture(stride) : MosaicPicture();
}

std::optional<Matrix3d> Mosaic::M_WC(int image) const {
  if (image < 0 || image >= images()) return std::nullopt;
  const Placement& its = placements_[static_cast<std::size_t>(image)];
  if (!IsPlaced(its.state)) return std::nullopt;
  return Normalised(options_.model, M_WK_[static_cast<std::size_t>(its.keyframe)] * its.M_KC);
}

std::optional<Vector2d> Mosaic::PlaceOf(int image, const Vector2d& uv) const {
  const auto M = M_WC(image);
  return M ? projection_->ToSurface(*M, uv) : std::nullopt;
}

std::optional<Matrix3d> Mosaic::GroundFromSurface() const {
  if (!has_poses_ || options_.model != MosaicModel::kPlane) return std::nullopt;
  const double metres = first_.z() / projection_->f_px();  // of a pixel
  Matrix3d ground;
  ground << 0, -metres, first_.x(), metres, 0, first_.y(), 0, 0, 1;
  return ground;
}

std::vector<Mosaic::Kept> Mosaic::kept() const {
  std::vector<Kept> all;
  for (const KeptImage& each : kept_) all.push_back({each.number, each.image, *M_WC(each.number)});
  return all;
}

std::int64_t Mosaic::bytes() const {
  std::int64_t sum = canvas_ ? canvas_->bytes() : 0;
  for (const auto* images : {&kept_, &pending_})
    for (const KeptImage& each : *images)
      sum += static_cast<std::int64_t>(each.image.total() * each.image.elemSize());
  for (const RegisteredImage& keyframe : keyframes_)
    sum += static_cast<std::int64_t>(keyframe.grey().total());
  return sum;
}

std::int64_t Mosaic::MostKept(const MosaicOptions& options, cv::Size size, int channels) {
  return options.most_bytes / 2 / (std::int64_t{size.area()} * (channels + 1));
}

std::int64_t Mosaic::MostPixels(const MosaicOptions& options, int channels) {
  return options.most_bytes / 2 / (static_cast<std::int64_t>(sizeof(float)) * (channels + 1));
}

bool Mosaic::HasRoom() const {
  return static_cast<std::int64_t>(kept_.size() + pending_.size()) <
         MostKept(options_, projection_->image_size(), CV_MAT_CN(type_));
}

}  // namespace kestrel::vision
