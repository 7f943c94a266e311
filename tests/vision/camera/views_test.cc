// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/views.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

KannalaBrandt Fisheye() {
  KannalaBrandt c;
  c.width_px = 640, c.height_px = 480;
  c.fx = c.fy = 241, c.cx = 322.3, c.cy = 236.8;
  c.k1 = -0.01, c.k2 = 0.002;
  c.max_angle_rad = Radians(95);
  return c;
}

Unified Mirror() {
  Unified c;
  c.width_px = 640, c.height_px = 480;
  c.fx = c.fy = 210, c.cx = 319.5, c.cy = 239.5;
  c.xi = 0.8;
  c.max_angle_rad = Radians(115);
  return c;
}

std::vector<CameraModel> WideCameras() { return {Fisheye(), Mirror()}; }

std::vector<Matrix3d> Turns() {
  return {ViewRotation(0, 0, 0), ViewRotation(0.5, -0.3, 0.2), ViewRotation(-0.9, 0.4, 2.5),
          ViewRotation(0, pi / 2, 0)};
}

Pinhole VirtualPinhole() { return {500, 400, 300, 310, 240.2, 205.7}; }

// What a camera sees of a scene that is given as a brightness, 0 to 1, of directions in C.
cv::Mat Photograph(const CameraModel& camera, const std::function<double(const Vector3d&)>& brightness) {
  cv::Mat image(HeightPx(camera), WidthPx(camera), CV_8UC1, cv::Scalar(0));
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      if (const auto ray = Ray(camera, Vector2d(u, v)))
        image.at<uchar>(v, u) = cv::saturate_cast<uchar>(20 + 220 * brightness(*ray));
    }
  }
  return image;
}

// An edge across which the brightness rises over some pixels, so that a crossing is known to a small part of
// one.
double Edge(double angle) { return 0.5 + 0.5 * std::tanh(angle / 0.02); }

// Where a row of brightness crosses the middle between dark and bright; NaN: nowhere.
double Crossing(const std::vector<double>& row) {
  constexpr double kMiddle = 20 + 220 * 0.5;
  for (std::size_t i = 1; i < row.size(); ++i) {
    if ((row[i - 1] < kMiddle) != (row[i] < kMiddle))
      return static_cast<double>(i - 1) + (kMiddle - row[i - 1]) / (row[i] - row[i - 1]);
  }
  return std::numeric_limits<double>::quiet_NaN();
}
std::vector<double> RowOf(const cv::Mat& image, int v, int from, int to) {
  std::vector<double> row;
  for (int u = from; u < to; ++u) row.push_back(image.at<uchar>(v, u));
  return row;
}

// The largest distance of points from their best straight line.
double Bend(const std::vector<Vector2d>& points) {
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Vector2d& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Vector2d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(0);
  double most = 0;
  for (const Vector2d& p : points) most = std::max(most, std::abs(normal.dot(p - mean)));
  return most;
}

Panorama Around(double azimuth_from_deg, double azimuth_to_deg, Panorama::Rows rows, const Matrix3d& R_VC) {
  return {700,  300, Radians(azimuth_from_deg), Radians(azimuth_to_deg), Radians(-50), Radians(40),
          rows, R_VC};
}

TEST(PerspectiveViewTest, ShowsAPointWhereTheVirtualCameraWouldSeeIt) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (const CameraModel& camera : WideCameras()) {
    for (const Matrix3d& R_VC : Turns()) {
      const PerspectiveView view{VirtualPinhole(), R_VC};
      int seen = 0;
      for (int i = 0; i < 300; ++i) {
        const Vector3d p_CQ(coordinate(random), coordinate(random), coordinate(random));
        const auto in_view = view.camera.Project(R_VC * p_CQ);
        if (!in_view) continue;
        const auto in_image = Project(camera, p_CQ);
        const auto source = SourceOf(view, camera, *in_view);
        if (!source) {
          // Only because the lens or the image ends.
          const bool inside = in_image && in_image->x() > 1e-6 && in_image->y() > 1e-6 &&
                              in_image->x() < 639 - 1e-6 && in_image->y() < 479 - 1e-6;
          EXPECT_FALSE(inside) << p_CQ.transpose();
          continue;
        }
        ++seen;
        ASSERT_TRUE(in_image);
        EXPECT_LT((*source - *in_image).norm(), 1e-6) << p_CQ.transpose();
      }
      EXPECT_GT(seen, 20);
    }
  }
}

TEST(PerspectiveViewTest, StraightEdgesOfTheWorldAreStraight) {
  // Walls that cross the scene 1 m ahead: planes through the camera's viewpoint and an edge on the wall.
  for (const CameraModel& camera : WideCameras()) {
    for (const Vector3d& normal_of_plane :
         {Vector3d(1, 0.3, -0.5), Vector3d(1, -0.2, 0.6), Vector3d(1, 0.1, 0.1)}) {
      const Vector3d n = normal_of_plane.normalized();
      const cv::Mat image =
          Photograph(camera, [&](const Vector3d& ray) { return Edge(std::asin(n.dot(ray))); });
      const PerspectiveView view{{600, 440, 260, 260, 299.5, 219.5}, ViewRotation(0.1, -0.05, 0.2)};
      const cv::Mat seen = Look(MakeViewTable(view, camera), image);
      std::vector<Vector2d> bent, straight;
      for (int v = 20; v < 420; v += 10) {
        const double before = Crossing(RowOf(image, v, 60, 580)), after = Crossing(RowOf(seen, v, 30, 570));
        if (std::isfinite(before)) bent.emplace_back(60 + before, v);
        if (std::isfinite(after)) straight.emplace_back(30 + after, v);
      }
      ASSERT_GT(straight.size(), 25u);
      EXPECT_LT(Bend(straight), 0.1);
      if (std::abs(n.z()) > 0.3) {
        EXPECT_GT(Bend(bent), 3);
      }
    }
  }
}

TEST(ViewRotationTest, YawIsToTheRightPitchIsUpRollIsClockwise) {
  const auto ahead = [](const Matrix3d& R_VC) -> Vector3d { return R_VC.transpose() * Vector3d::UnitZ(); };
  const auto right = [](const Matrix3d& R_VC) -> Vector3d { return R_VC.transpose() * Vector3d::UnitX(); };
  EXPECT_LT((ahead(ViewRotation(pi / 2, 0, 0)) - Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((ahead(ViewRotation(0, pi / 2, 0)) + Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((ahead(ViewRotation(0, 0, pi / 2)) - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((right(ViewRotation(0, 0, pi / 2)) - Vector3d::UnitY()).norm(), 1e-12);
  // Yaw first, then the pitch of the turned view.
  EXPECT_LT((ahead(ViewRotation(pi / 2, pi / 4, 0)) - Vector3d(1, -1, 0).normalized()).norm(), 1e-12);
  EXPECT_NEAR(ViewRotation(0.3, 0.4, 0.5).determinant(), 1, 1e-12);
}

TEST(PanoramaTest, ShowsAPointAtItsAzimuthAndElevation) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (const auto rows : {Panorama::Rows::kElevation, Panorama::Rows::kTangent}) {
    for (const CameraModel& camera : WideCameras()) {
      for (const Matrix3d& R_VC : Turns()) {
        const Panorama panorama = Around(-180, 180, rows, R_VC);
        int seen = 0;
        for (int i = 0; i < 300; ++i) {
          const Vector3d p_CQ(coordinate(random), coordinate(random), coordinate(random));
          const Vector3d q = R_VC * p_CQ;
          // By the definition: even columns of azimuth, even rows of elevation or of height on a cylinder.
          const double column = 700 * (std::atan2(q.x(), q.z()) + pi) / (2 * pi) - 0.5;
          const auto height = [&](double elevation) {
            return rows == Panorama::Rows::kTangent ? std::tan(elevation) : elevation;
          };
          const double top = height(Radians(40)), bottom = height(Radians(-50));
          const double at = height(std::atan2(-q.y(), std::hypot(q.x(), q.z())));
          const double row = 300 * (top - at) / (top - bottom) - 0.5;
          const auto in_view = Project(panorama, p_CQ);
          EXPECT_EQ(in_view.has_value(), at <= top && at >= bottom);
          if (!in_view) continue;
          EXPECT_LT((*in_view - Vector2d(column, row)).norm(), 1e-9);
          const auto source = SourceOf(panorama, camera, *in_view);
          const auto in_image = Project(camera, p_CQ);
          if (!source) continue;
          ++seen;
          ASSERT_TRUE(in_image);
          EXPECT_LT((*source - *in_image).norm(), 1e-6);
        }
        EXPECT_GT(seen, 40);
      }
    }
  }
}

TEST(PanoramaTest, AnUprightEdgeStandsInOneColumnAndALevelOneInOneRow) {
  const CameraModel camera = Fisheye();
  const Matrix3d R_VC = ViewRotation(0, pi / 2, 0);  // the camera looks straight down
  for (const auto rows : {Panorama::Rows::kElevation, Panorama::Rows::kTangent}) {
    Panorama panorama = Around(-180, 180, rows, R_VC);
    panorama.elevation_from = Radians(-70), panorama.elevation_to = Radians(-40);
    const ViewTable table = MakeViewTable(panorama, camera);
    for (const double azimuth : {-2.0, 0.3, 1.5}) {
      const cv::Mat image = Photograph(camera, [&](const Vector3d& ray) {
        const Vector3d q = R_VC * ray;
        return Edge(std::hypot(q.x(), q.z()) * WrapAngle(std::atan2(q.x(), q.z()) - azimuth));
      });
      const cv::Mat seen = Look(table, image);
      const double expected = 700 * (azimuth + pi) / (2 * pi) - 0.5;
      const int first = static_cast<int>(expected) - 30;
      for (int v = 5; v < 300; v += 20)
        EXPECT_NEAR(first + Crossing(RowOf(seen, v, first, first + 60)), expected, 0.15) << v;
    }
    const double elevation = Radians(-55);
    const cv::Mat image = Photograph(
        camera, [&](const Vector3d& ray) { return Edge(std::asin(-(R_VC * ray).y()) - elevation); });
    const cv::Mat seen = Look(table, image).t();
    const double share = rows == Panorama::Rows::kElevation
                             ? 0.5
                             : (std::tan(Radians(-40)) - std::tan(elevation)) /
                                   (std::tan(Radians(-40)) - std::tan(Radians(-70)));
    for (int u = 5; u < 700; u += 40)
      EXPECT_NEAR(Crossing(RowOf(seen, u, 0, 300)), 300 * share - 0.5, 0.25) << u;
  }
}

TEST(PanoramaTest, APartIsCutFromTheWhole) {
  const CameraModel camera = Fisheye();
  for (const auto rows : {Panorama::Rows::kElevation, Panorama::Rows::kTangent}) {
    const Panorama whole = Around(-180, 180, rows, ViewRotation(0.2, 1.2, 0));
    const Panorama part = Around(120, 260, rows, whole.R_VC);  // over the cut of the whole
    int compared = 0;
    for (int v = 0; v < part.height_px; v += 10) {
      for (int u = 0; u < part.width_px; u += 5) {
        const double azimuth_deg = 120 + (u + 0.5) * 140.0 / 700;
        const double wrapped_deg = azimuth_deg > 180 ? azimuth_deg - 360 : azimuth_deg;
        const auto here = SourceOf(part, camera, Vector2d(u, v));
        const auto there = SourceOf(whole, camera, Vector2d((wrapped_deg + 180) / 360 * 700 - 0.5, v));
        ASSERT_EQ(here.has_value(), there.has_value());
        if (!here) continue;
        ++compared;
        EXPECT_LT((*here - *there).norm(), 1e-9);
      }
    }
    EXPECT_GT(compared, 300);
  }
}

TEST(PanoramaTest, TheLastColumnIsOneStepBeforeTheFirst) {
  const CameraModel camera = Fisheye();
  const Panorama p = Around(-180, 180, Panorama::Rows::kElevation, ViewRotation(0, pi / 2, 0));
  const auto at = [&](double u) { return SourceOf(p, camera, Vector2d(u, 290)).value(); };
  const double step = (at(1) - at(0)).norm();
  EXPECT_GT(step, 0.5);
  EXPECT_NEAR((at(0) - at(699)).norm(), step, 0.05 * step);
  EXPECT_LT((at(700) - at(0)).norm(), 1e-9);
}

TEST(PanoramaTest, TheWholeHoldsWhatTheLensSees) {
  for (const CameraModel& camera : WideCameras()) {
    for (const Matrix3d& R_VC : Turns()) {
      const auto whole = WholePanorama(camera, R_VC, Panorama::Rows::kElevation);
      ASSERT_TRUE(whole);
      Panorama roomy = *whole;  // by the last digits of the outermost rays
      roomy.elevation_from -= 1e-9, roomy.elevation_to += 1e-9;
      for (int v = 0; v < 480; v += 4) {
        for (int u = 0; u < 640; u += 4) {
          const auto ray = Ray(camera, Vector2d(u, v));
          EXPECT_TRUE(!ray || Project(roomy, *ray)) << u << ' ' << v;
        }
      }
      EXPECT_NEAR(whole->width_px / (whole->azimuth_to - whole->azimuth_from), MeanResolution(camera), 1);
    }
  }
  // Ahead only what is there, and all around where the camera looks straight down.
  const auto ahead = WholePanorama(Fisheye(), ViewRotation(0, 0, 0), Panorama::Rows::kElevation);
  EXPECT_LT(ahead->azimuth_to - ahead->azimuth_from, Radians(200));
  EXPECT_NEAR(ahead->azimuth_to + ahead->azimuth_from, 0, Radians(4));
  const auto down = WholePanorama(Fisheye(), ViewRotation(0, pi / 2, 0), Panorama::Rows::kElevation);
  EXPECT_NEAR(down->azimuth_to - down->azimuth_from, 2 * pi, 1e-12);
  EXPECT_NEAR(down->elevation_from, -pi / 2, 1e-12);
  const auto cylinder = WholePanorama(Fisheye(), ViewRotation(0, pi / 2, 0), Panorama::Rows::kTangent);
  EXPECT_GE(cylinder->elevation_from, Radians(-75) - 1e-12);
}

TEST(PolarUnwrappingTest, TakesEvenStepsOfRadiusAndAngle) {
  const CameraModel camera = Fisheye();
  const PolarUnwrapping polar{360, 100, {322.3, 236.8}, 0, 2 * pi, 220, 20};
  for (const double u : {0.0, 45.5, 200.0, 359.0}) {
    for (const double v : {0.0, 50.0, 99.0}) {
      const double alpha = Radians(u + 0.5), radius = 220 - 2 * (v + 0.5);
      const auto source = SourceOf(polar, camera, Vector2d(u, v));
      ASSERT_TRUE(source);
      EXPECT_NEAR(source->x(), radius * std::cos(alpha) + 322.3, 1e-9);
      EXPECT_NEAR(source->y(), radius * std::sin(alpha) + 236.8, 1e-9);
    }
  }
  EXPECT_FALSE(SourceOf(PolarUnwrapping{360, 100, {322.3, 236.8}, 0, 2 * pi, 300, 20}, camera,
                        Vector2d(90, 0)));  // below the image's lower edge
}

TEST(SpherePictureTest, PutsEachPixelWhereItsRayMeetsTheSphere) {
  const CameraModel camera = Fisheye();
  for (const Matrix3d& R_VC : {ViewRotation(pi, 0, 0), ViewRotation(1.4, -0.4, 0.1)}) {
    const SpherePicture sphere{301, 301, R_VC};
    int near = 0, far = 0;
    for (int v = 0; v < 301; v += 5) {
      for (int u = 0; u < 301; u += 5) {
        const Vector2d at((u - 150) / 150.5, (v - 150) / 150.5);
        const auto source = SourceOf(sphere, camera, Vector2d(u, v));
        EXPECT_FALSE(source && at.norm() > 1);
        if (!source) continue;
        const auto ray = Ray(camera, *source);
        ASSERT_TRUE(ray);
        const Vector3d on_sphere = R_VC * *ray;  // seen along z of V: its x and y are what the picture shows
        EXPECT_LT((on_sphere.head<2>() - at).norm(), 1e-6);
        (on_sphere.z() < 0 ? near : far) += 1;
        if (on_sphere.z() <= 0) continue;
        // The far side shows only through what the lens leaves open on the near side.
        const auto before = Project(camera, R_VC.transpose() * Vector3d(at.x(), at.y(), -on_sphere.z()));
        EXPECT_FALSE(before && before->x() >= 0 && before->y() >= 0 && before->x() <= 639 &&
                     before->y() <= 479);
      }
    }
    EXPECT_GT(near, 500);
    if (R_VC(2, 2) > -0.99) {
      EXPECT_GT(far, 100);
    }
  }
  // From straight in front: the axis in the middle, and the right of the image on the left.
  const SpherePicture front{301, 301, ViewRotation(pi, 0, 0)};
  EXPECT_LT((SourceOf(front, camera, {150, 150}).value() - Vector2d(322.3, 236.8)).norm(), 1e-6);
  EXPECT_GT(SourceOf(front, camera, {100, 150})->x(), 322.3 + 50);
  EXPECT_LT(SourceOf(front, camera, {150, 100})->y(), 236.8 - 50);
}

TEST(ViewTableTest, HoldsTheSourcesAndIsBlackWhereTheLensShowsNothing) {
  const CameraModel camera = Fisheye();
  const cv::Mat white(480, 640, CV_8UC3, cv::Scalar(255, 250, 245));
  const std::vector<View> views = {PerspectiveView{VirtualPinhole(), ViewRotation(1.3, 0.2, 0)},
                                   Around(-180, 180, Panorama::Rows::kElevation, ViewRotation(0, 0.5, 0)),
                                   PolarUnwrapping{360, 200, {322.3, 236.8}, 0, 2 * pi, 380, 0},
                                   SpherePicture{300, 260, ViewRotation(2.5, 0.3, 0)}};
  for (const View& view : views) {
    const ViewTable table = MakeViewTable(view, camera);
    const cv::Mat seen = Look(table, white);
    ASSERT_EQ(seen.size(), SizeOf(view));
    ASSERT_EQ(seen.type(), CV_8UC3);
    int shown = 0;
    for (int v = 0; v < seen.rows; ++v) {
      for (int u = 0; u < seen.cols; ++u) {
        const auto source = SourceOf(view, camera, Vector2d(u, v));
        ASSERT_EQ(table.shown.at<uchar>(v, u), source ? 255 : 0);
        const cv::Vec3b colour = seen.at<cv::Vec3b>(v, u);
        EXPECT_EQ(colour, source ? cv::Vec3b(255, 250, 245) : cv::Vec3b(0, 0, 0)) << u << ' ' << v;
        if (!source) continue;
        ++shown;
        const cv::Vec2s whole = table.place.at<cv::Vec2s>(v, u);
        const int fraction = table.fraction.at<ushort>(v, u);
        EXPECT_NEAR(whole[0] + (fraction & 31) / 32.0, source->x(), 0.6 / 32);
        EXPECT_NEAR(whole[1] + (fraction >> 5) / 32.0, source->y(), 0.6 / 32);
      }
    }
    EXPECT_NEAR(ShownShare(table), static_cast<double>(shown) / static_cast<double>(seen.total()), 1e-12);
    EXPECT_GT(ShownShare(table), 0.1);
    EXPECT_LT(ShownShare(table), 0.95);
  }
}

TEST(ViewTableTest, BehindTheLensThereIsNothing) {
  const PerspectiveView behind{{200, 200, 300, 300, 99.5, 99.5}, ViewRotation(pi, 0, 0)};
  EXPECT_EQ(ShownShare(MakeViewTable(behind, CameraModel(Fisheye()))), 0);
}

TEST(MeanResolutionTest, IsThatOfTheSolidAngle) {
  KannalaBrandt round = Fisheye();  // the whole circle of the lens within the image
  round.fx = round.fy = 120, round.k1 = round.k2 = 0;
  const double angle = round.max_angle_rad;
  const double expected = std::sqrt(pi * std::pow(120 * angle, 2) / (2 * pi * (1 - std::cos(angle))));
  EXPECT_NEAR(MeanResolution(round), expected, 0.01 * expected);
}

TEST(CentralPinholeTest, KeepsTheResolutionOfTheMiddleAndEndsWhereTheLensDoes) {
  const CameraModel camera = Fisheye();
  const auto narrow = CentralPinhole(camera, Radians(90));
  ASSERT_TRUE(narrow);
  EXPECT_NEAR(narrow->fx, 241, 0.01);
  EXPECT_NEAR(narrow->width_px, 482, 1);
  EXPECT_NEAR(narrow->height_px, 482, 1);
  EXPECT_EQ(ShownShare(MakeViewTable(PerspectiveView{*narrow}, camera)), 1);

  const auto wide = CentralPinhole(camera, Radians(170));
  ASSERT_TRUE(wide);
  for (const double u : {0.0, wide->width_px - 1.0})
    EXPECT_TRUE(SourceOf(PerspectiveView{*wide}, camera, {u, wide->cy}));
  for (const double v : {0.0, wide->height_px - 1.0})
    EXPECT_TRUE(SourceOf(PerspectiveView{*wide}, camera, {wide->cx, v}));
  // A pixel of the image's edge is the edge of the view.
  EXPECT_NEAR(SourceOf(PerspectiveView{*wide}, camera, {wide->cx, 0})->y(), 0, 1);
  EXPECT_NEAR(SourceOf(PerspectiveView{*wide}, camera, {wide->cx, wide->height_px - 1.0})->y(), 479, 1);

  KannalaBrandt aside = Fisheye();
  aside.cx = -300;  // sees only what is to the right of its axis
  EXPECT_FALSE(CentralPinhole(aside, Radians(90)));
}

}  // namespace
}  // namespace kestrel::vision
