// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/camera_model.h"
#include "vision/enhance/canvas/blending.h"
#include "vision/enhance/canvas/canvas.h"
#include "vision/enhance/canvas/projection.h"
#include "vision/enhance/canvas/surface.h"
#include "vision/enhance/mosaic/adjustment.h"
#include "vision/enhance/mosaic/image_registration.h"
#include "vision/enhance/mosaic/motion_estimate.h"

namespace kestrel::vision {

struct MosaicOptions {
  MosaicModel model = MosaicModel::kPlane;
  Surface surface = Surface::kPlane;  // a model of a plane is drawn on a plane alone
  Blending blending = Blending::kFeather;
  // Of the images. A rotation needs it, and so do poses; without it a plane is seen by a pinhole.
  std::optional<CameraModel> camera;
  double ground_down_m = 0;  // z of the ground in N, of a plane with poses
  double pose_sigma_m = 1;   // how far off the poses may be
  double pose_sigma_deg = 1;
  double keyframe_overlap = 0.65;  // an image that shares less than that with the last keyframe is the next
  int max_points = 150;            // that are followed
  bool opencl = false;             // on a device of OpenCL, if there is one
  bool loops = true;   // keyframes that show the same again are joined and all adjusted; otherwise images are
                       // chained alone, as the thesis does
  bool redraw = true;  // the canvas anew, from the images that are kept, when the adjustment has moved them
  std::int64_t most_bytes = 1'000'000'000;  // of images that are kept and of the canvas, half each
};

enum class MosaicState {
  kFirst,       // it begins the mosaic
  kFollowed,    // registered to the last keyframe
  kFound,       // registered again, by features, after a jump or a loss
  kByPose,      // by the pose alone: it agrees with no image
  kLost,        // it agrees with no image; not in the mosaic
  kNoTexture,   // nothing in it can be followed; not in the mosaic
  kOblique,     // it sees the plane almost from its side; not in the mosaic, and begins none
  kOtherSize,   // of another size than the first; not in the mosaic
  kUnreadable,  // it came empty; not in the mosaic
  kFull         // the memory for images is used up; not in the mosaic
};
const char* NameOf(MosaicState state);
bool IsPlaced(MosaicState state);

// What became of an image.
struct MosaicStep {
  MosaicState state = MosaicState::kLost;
  int number = 0;     // of the image, from 0
  int keyframe = -1;  // which it is placed by, or is itself; none: -1
  bool is_keyframe = false;
  int agreed = 0;             // places
  double rms_px = 0;          // of those that agree
  double shared = 0;          // with the keyframe, 0 to 1
  int loops = 0;              // keyframes that were joined to older ones
  bool adjusted = false;      // all were placed anew
  double moved_px = 0;        // by which the farthest was moved
  bool against_pose = false;  // images agree on a motion, and its pose rules that out
};

// A mosaic that grows image by image, thesis 4.3: registration, reprojection and blending. Deviations: an image is
// registered to the last keyframe and not to the one before it, so that errors add up by keyframes alone; a
// keyframe is registered to all that it overlaps, and loops are closed by bundle adjustment; the canvas grows.
// With poses, W is laid out by N: on a plane, x of the surface is east and y south; about the vertical, the
// middle of a cylinder or sphere is north. Without, W is the first image's camera, and what turns is straightened at
// the end.
// The same images give the same bits.
class Mosaic {
 public:
  // Throws std::invalid_argument for a rotation without a camera or a plane on another surface.
  explicit Mosaic(const MosaicOptions& options);

  // The next image, CV_8UC1 or CV_8UC3, all of one kind, or empty where it could not be read. X_NC: where the camera is, if that is known; the first
  // that is, over the ground, lays out W anew for all before it. The image is copied where it is kept.
  MosaicStep Add(const cv::Mat& image, double t_s, const std::optional<Pose>& X_NC = std::nullopt);

  // All keyframes anew from all that is known, and the canvas drawn anew. The end of a mosaic.
  AdjustmentResult Adjust();

  // As it stands. stride: of every so many pixels one, for a quick look.
  MosaicPicture Picture(int stride = 1) const;
  cv::Size CanvasSize() const { return canvas_ ? canvas_->extent().size() : cv::Size(); }
  // The places of the last image that agreed, and where they are in its keyframe.
  const std::vector<PixelPair>& last_pairs() const { return last_pairs_; }

  int images() const { return static_cast<int>(placements_.size()); }
  int keyframes() const { return static_cast<int>(keyframes_.size()); }
  int loops() const { return loops_; }
  // Where an image lies; none: it is not in the mosaic.
  std::optional<Eigen::Matrix3d> M_WC(int image) const;
  // A pixel of an image on the surface, in pixels of it. None: not in the mosaic.
  std::optional<Eigen::Vector2d> PlaceOf(int image, const Eigen::Vector2d& uv) const;
  // The ground under the surface: takes (u, v, 1) of the surface to (x north, y east, 1) of N, m. None without
  // poses, or not of a plane.
  std::optional<Eigen::Matrix3d> GroundFromSurface() const;
  const Projection& projection() const { return *projection_; }  // from the first image on
  const MosaicOptions& options() const { return options_; }

  // The images that are kept, for a composition of them all: every keyframe, and others where they alone show
  // something.
  struct Kept {
    int number;  // of the image
    cv::Mat image;
    Eigen::Matrix3d M_WC;
  };
  std::vector<Kept> kept() const;
  std::int64_t bytes() const;  // of images that are kept and of the canvas
  // How many images of this size and number of channels can be kept, and how many pixels the canvas can have
  // before it is scaled down.
  static std::int64_t MostKept(const MosaicOptions& options, cv::Size size, int channels);
  static std::int64_t MostPixels(const MosaicOptions& options, int channels);

 private:
  using MaybePlaced = std::optional<Eigen::Matrix3d>;
  struct Placement {
    MosaicState state = MosaicState::kLost;
    int keyframe = -1;
    Eigen::Matrix3d M_KC = Eigen::Matrix3d::Identity();  // in the keyframe's camera
  };
  struct KeptImage {
    int number;
    cv::Mat image;
    cv::Rect part;  // of the surface, when it was placed last
  };
  // A keyframe that is being joined to older ones that show the same.
  struct Joining {
    int keyframe;
    std::vector<int> candidates;  // to be tried, the best last
    std::vector<int> joined;
    bool looked_far;
  };
  struct Found {
    int keyframe;
    MotionEstimate motion;  // of the image in the keyframe
  };
  MosaicStep Refuse(MosaicState state, MosaicStep step);
  void Begin(const cv::Mat& image);
  bool CanLayOut(const std::optional<Pose>& X_NC) const;
  void LayOutAt(const Pose& X_NC);
  bool LayOutAnew(const Pose& X_NC, const Eigen::Matrix3d& M_WC);
  bool IsOblique(const Eigen::Matrix3d& M_WC) const;
  Eigen::Matrix3d FromPose(const Pose& X_NC) const;
  GroundParallax ParallaxAt(const Pose& X_NC) const;
  double PoseSigma_px() const;
  bool AgreesWithPoses(int keyframe, const Eigen::Matrix3d& M_KC, const MaybePlaced& M_WC_pose);
  std::optional<Found> Follow(RegisteredImage& image, const MaybePlaced& M_WC_pose);
  std::optional<Found> Find(RegisteredImage& image, const MaybePlaced& M_WC_pose);
  void MakeKeyframe(const cv::Mat& image, RegisteredImage registered, const Eigen::Matrix3d& M_WC,
                    const MaybePlaced& M_WC_pose, const Found* found, MosaicStep& step);
  void BeginJoins(int joined_already);
  bool JoinNext(MosaicStep& step);
  void AdjustWhenDue(MosaicStep& step);
  AdjustmentResult AdjustKeyframes(int most_iterations, double* moved_px);
  void Keep(KeptImage kept);
  void KeepWhatAloneShows();
  double UncoveredShare(const Eigen::Matrix3d& M_WC) const;
  bool HasRoom() const;
  void RedrawTile();
  void Redraw();

  MosaicOptions options_;
  CameraModel camera_;
  std::optional<Projection> projection_;
  std::optional<Canvas> canvas_;
  int type_ = 0;                       // of the images
  std::vector<Placement> placements_;  // of each image
  std::vector<RegisteredImage> keyframes_;
  std::vector<Eigen::Matrix3d> M_WK_;   // of each keyframe
  std::vector<MaybePlaced> M_WK_pose_;  // by its pose
  std::vector<AdjustmentEdge> edges_;
  std::vector<AdjustmentPrior> priors_;
  std::vector<KeptImage> kept_;
  std::deque<Joining> joining_;
  std::vector<cv::Rect> stale_;     // tiles of the canvas, drawn before the adjustment
  int stale_halvings_ = 0;          // of the canvas, when they were listed
  std::vector<KeptImage> pending_;  // since the last keyframe, that showed what no other did
  int current_ = 0;                 // keyframe that images are registered to
  Eigen::Matrix3d M_KC_last_ = Eigen::Matrix3d::Identity(), M_KC_before_ = Eigen::Matrix3d::Identity();
  MaybePlaced M_WC_pose_last_;
  std::vector<PixelPair> last_pairs_;
  int lost_ = 0;  // images in a row
  int loops_ = 0, since_adjusted_ = 0;
  bool loop_is_open_ = false;
  double moved_px_ = 0;         // since the canvas was drawn anew
  std::size_t drawn_anew_ = 0;  // keyframes there were then
  bool against_pose_ = false;   // of the image that is being added
  bool has_poses_ = false;
  // With poses: the place of the first camera that has one, north and east, and its height over the ground, m.
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero();
};

}  // namespace kestrel::vision
