// SPDX-License-Identifier: Apache-2.0
#include "vision/target/balloon_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "base/random.h"
#include "vision/least_squares.h"

namespace kestrel::vision {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLines = 72;                                 // from the middle outwards, by colour
constexpr double kReach = 1.8;                             // of those lines, by the guessed radius
constexpr int kMaxSteps = 120;                             // on each
constexpr int kTrials = 120;                               // of the consensus
constexpr double kStep_px = 0.5;                           // across the outline
constexpr double kTukey = 4.685;                           // deviations
constexpr double kSharp_px = 1.5;                          // half of the width of a sharp edge
constexpr double kApart_px = 1.5;                          // edge points err independently
constexpr double kMinAgreement = 0.6;                      // of the edge points found
constexpr double kMaxUneven_px = 0.6, kMaxUneven = 0.015;  // of the outline; by its radius
constexpr double kUneven_px = 0.15;  // what the edge points of one side may err otherwise than the others'
constexpr double kBlurUneven = 0.1, kBlurSigma = 0.08, kBlurBias = 0.01;  // by an edge's width
// The middle of a disc's blurred edge lies variance / (2 radius) inside of it; the variance of a pixel along
// an axis, 1/12, and of the interpolation between pixels, 1/6 on average, px^2.
constexpr double kEdgeVariance_px2 = 0.25;

// Samples of the image along lines, a row each; what lies off the image is not valid.
struct Lines {
  cv::Mat bgr, weights;
  cv::Mat x, y;
  int Steps() const { return x.cols; }
  bool Valid(int line, int i, const cv::Size& image) const {
    const float u = x.at<float>(line, i), v = y.at<float>(line, i);
    return u >= 0 && v >= 0 && u <= static_cast<float>(image.width - 1) &&
           v <= static_cast<float>(image.height - 1);
  }
  Vector3d At(int line, int i) const {
    const cv::Vec3b& p = bgr.at<cv::Vec3b>(line, i);
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  }
  bool Matches(int line, int i) const { return weights.at<uchar>(line, i) > 127; }
};

void Sample(const cv::Mat& image, const ColourModel& model, Lines& lines) {
  cv::remap(image, lines.bgr, lines.x, lines.y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  model.BackProject(lines.bgr, lines.weights);
}

// A point of an edge: its ray, how many radians a pixel is across the outline, the line that it was found on.
struct EdgePoint {
  Vector2d pixel;
  Vector3d ray;
  double rad_per_px = 0;
  int line = 0;
};

// Two unit vectors across the axis.
Eigen::Matrix<double, 3, 2> Across(const Vector3d& axis) {
  Eigen::Matrix<double, 3, 2> E;
  E.col(0) = axis.unitOrthogonal();
  E.col(1) = axis.cross(E.col(0));
  return E;
}
double Angle(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// Where lines from the middle outwards leave the target's colour, coarsely.
std::vector<EdgePoint> LeavingPoints(const cv::Mat& image, const CameraModel& camera,
                                     const ColourModel& model, const Vector2d& centre, double radius_px) {
  const int steps = std::clamp(static_cast<int>(kReach * radius_px + 6), 12, kMaxSteps);
  const double step = (kReach * radius_px + 6) / steps;
  Lines lines;
  lines.x.create(kLines, steps, CV_32F), lines.y.create(kLines, steps, CV_32F);
  for (int k = 0; k < kLines; ++k) {
    const double c = std::cos(2 * M_PI * k / kLines), s = std::sin(2 * M_PI * k / kLines);
    for (int i = 0; i < steps; ++i) {
      lines.x.at<float>(k, i) = static_cast<float>(centre.x() + c * step * i);
      lines.y.at<float>(k, i) = static_cast<float>(centre.y() + s * step * i);
    }
  }
  Sample(image, model, lines);
  std::vector<EdgePoint> points;
  for (int k = 0; k < kLines; ++k) {
    int run = 0;
    for (int i = 0; i < steps && lines.Valid(k, i, image.size()); ++i) {
      if (lines.Matches(k, i)) {
        ++run;
        continue;
      }
      if (run >= 2) {
        const Vector2d pixel = centre + (step * (i - 0.5)) * Vector2d(std::cos(2 * M_PI * k / kLines),
                                                                      std::sin(2 * M_PI * k / kLines));
        Eigen::Matrix<double, 3, 2> d_pixel;
        if (const auto ray = Ray(camera, pixel, &d_pixel))
          points.push_back({pixel, *ray, d_pixel.norm() / std::sqrt(2.0), k});
      }
      run = 0;
    }
  }
  return points;
}

// The cone with most of the lines' points near it, by random triples: a circular cone is a plane through the
// unit sphere.
std::optional<OutlineCone> Consensus(const std::vector<EdgePoint>& points, double guessed_half_angle) {
  if (points.size() < 6) return {};
  SampleSequence samples;
  const auto draw = [&]() -> const EdgePoint& { return points[samples.Next(points.size())]; };
  std::optional<OutlineCone> best;
  double best_score = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const EdgePoint &a = draw(), &b = draw(), &c = draw();
    Vector3d n = (b.ray - a.ray).cross(c.ray - a.ray);
    const double size = n.norm(),
                 span = std::min({(b.ray - a.ray).norm(), (c.ray - a.ray).norm(), (c.ray - b.ray).norm()});
    if (span < 0.3 * guessed_half_angle || !(size > 0)) continue;
    n *= (n.dot(a.ray) > 0 ? 1 : -1) / size;
    const double half_angle = Angle(n, a.ray);
    if (half_angle < 0.3 * guessed_half_angle || half_angle > 2.5 * guessed_half_angle) continue;
    std::array<double, kLines> lines{};
    for (const EdgePoint& p : points) {
      const double off_px = std::abs(Angle(n, p.ray) - half_angle) / p.rad_per_px;
      const double allowed_px = 1.2 + 0.03 * half_angle / p.rad_per_px;
      const double vote = std::max(0.0, 1 - off_px * off_px / (allowed_px * allowed_px));
      double& line = lines[static_cast<std::size_t>(p.line)];
      line = std::max(line, vote);
    }
    double score = 0;
    for (const double vote : lines) score += vote;
    if (score > best_score) best_score = score, best = OutlineCone{n, half_angle};
  }
  return best;
}

// The place, px along the profile, where it is halfway between what is inside and outside; and how wide the
// edge is.
struct Crossing {
  double at = 0, width = 0;
};
class Profile {
 public:
  Profile(const Lines& lines, int line, const cv::Size& image, double min_contrast)
      : lines_(lines), line_(line), min_contrast_(min_contrast), middle_((lines.Steps() - 1) / 2) {
    while (from_ < lines.Steps() && !lines.Valid(line, from_, image)) ++from_;
    until_ = from_;
    while (until_ < lines.Steps() && lines.Valid(line, until_, image)) ++until_;
  }

  // inner_px: how far inwards there is balloon, not its other side.
  std::optional<Crossing> Find(double inner_px) const {
    const double reach = middle_ * kStep_px, inner = std::min(reach, inner_px);
    Vector3d in, out;
    if (!Mean(-inner, -inner / 3, true, in) || !Mean(reach / 3, reach, false, out)) return {};
    auto crossing = Cross(in, out, {});
    if (!crossing) return {};
    // Once more by what is next to a sharp edge: shading and background vary further off.
    if (crossing->width < 2 * kSharp_px) {
      const double t = crossing->at;
      if (!Mean(std::max(-inner, t - 4), t - kSharp_px, true, in) || !Mean(t + kSharp_px, t + 4, false, out))
        return {};
      crossing = Cross(in + Shading(t, inner), out, t);
    }
    return crossing;
  }

 private:
  int Index(double t) const { return middle_ + static_cast<int>(std::lround(t / kStep_px)); }
  // matching: only if most of it has the target's colour.
  bool Mean(double from, double to, bool matching, Vector3d& mean) const {
    int count = 0, matches = 0;
    mean.setZero();
    for (int i = std::max(from_, Index(from)); i <= std::min(until_ - 1, Index(to)); ++i) {
      ++count;
      const bool match = lines_.Matches(line_, i);
      matches += match;
      mean += lines_.At(line_, i);
    }
    if (count < 3 || (matching && 2 * matches <= count)) return false;
    mean /= count;
    return true;
  }
  // How the inside goes on from where its mean was taken to the edge: a ball is shaded towards its rim.
  Vector3d Shading(double t, double inner) const {
    const double from = std::max(-inner, t - 6), to = t - kSharp_px;
    if (to - from < 3) return Vector3d::Zero();
    Vector3d far, near;
    const double half = (from + to) / 2;
    if (!Mean(from, half, true, far) || !Mean(half, to, true, near)) return Vector3d::Zero();
    const Vector3d slope = (near - far) / ((to - from) / 2);
    const double mean_at = (std::max(-inner, t - 4) + to) / 2;
    return slope * (t - mean_at) * 0.5;  // half of the way: noise is extrapolated too
  }
  // The steepest of the crossings, or that nearest to a place.
  std::optional<Crossing> Cross(const Vector3d& in, const Vector3d& out, std::optional<double> near) const {
    const Vector3d d = in - out;
    if (d.norm() < min_contrast_) return {};
    const auto level = [&](int i) { return (lines_.At(line_, i) - out).dot(d) / d.squaredNorm(); };
    std::optional<Crossing> best;
    double best_score = -1e9;
    for (int i = from_; i + 1 < until_; ++i) {
      const double a = level(i), b = level(i + 1);
      if (!(a >= 0.5 && b < 0.5)) continue;
      const double at = (i - middle_ + (a - 0.5) / (a - b)) * kStep_px;
      int first = i, last = i + 1;
      while (first > from_ && level(first) < 0.8) --first;
      while (last + 1 < until_ && level(last) > 0.2) ++last;
      const int back = std::max(from_, i - 2), on = std::min(until_ - 1, i + 3);
      const double score = near ? -std::abs(at - *near) : level(back) - level(on);
      if (score > best_score) best_score = score, best = Crossing{at, (last - first) * kStep_px};
    }
    if (near && best && std::abs(best->at - *near) > 1.5) return {};
    return best;
  }

  const Lines& lines_;
  int line_;
  double min_contrast_;
  int middle_, from_ = 0, until_ = 0;
};

struct Refined {
  std::vector<EdgePoint> points;
  double width_px = 0;   // of the edges, median
  double radius_px = 0;  // mean
  int lines = 0;         // all round
};

// Edge points to a fraction of a pixel on lines across the predicted outline, reach_px to both sides.
Refined EdgesNear(const cv::Mat& image, const CameraModel& camera, const ColourModel& model,
                  const OutlineCone& cone, double rad_per_px, double reach_px,
                  const BalloonFitOptions& options) {
  Refined refined;
  refined.radius_px = cone.half_angle / rad_per_px;
  refined.lines = std::clamp(static_cast<int>(2 * M_PI * refined.radius_px), 24, 120);
  const int half = static_cast<int>(std::ceil(reach_px / kStep_px)), steps = 2 * half + 1;
  const Eigen::Matrix<double, 3, 2> E = Across(cone.axis);
  struct Line {
    Vector2d middle, outward;
  };
  std::vector<Line> across;
  std::vector<int> at;
  for (int k = 0; k < refined.lines; ++k) {
    const double phi = 2 * M_PI * k / refined.lines;
    const Vector3d side = E * Vector2d(std::cos(phi), std::sin(phi));
    const auto pixel = [&](double angle) {
      return Project(camera, std::cos(angle) * cone.axis + std::sin(angle) * side);
    };
    const auto middle = pixel(cone.half_angle), in = pixel(cone.half_angle - rad_per_px / 2),
               out = pixel(cone.half_angle + rad_per_px / 2);
    if (!middle || !in || !out || !((*out - *in).norm() > 0)) continue;
    across.push_back({*middle, (*out - *in).normalized()});
    at.push_back(k);
  }
  if (across.empty()) return refined;
  const int rows = static_cast<int>(across.size());
  Lines lines;
  lines.x.create(rows, steps, CV_32F), lines.y.create(rows, steps, CV_32F);
  for (int k = 0; k < rows; ++k) {
    const Line& line = across[static_cast<std::size_t>(k)];
    for (int i = 0; i < steps; ++i) {
      const Vector2d p = line.middle + (i - half) * kStep_px * line.outward;
      lines.x.at<float>(k, i) = static_cast<float>(p.x()),
                           lines.y.at<float>(k, i) = static_cast<float>(p.y());
    }
  }
  Sample(image, model, lines);
  std::vector<double> widths;
  for (int k = 0; k < rows; ++k) {
    const Profile profile(lines, k, image.size(), options.min_contrast);
    const auto crossing = profile.Find(0.8 * refined.radius_px);
    if (!crossing) continue;
    const Line& line = across[static_cast<std::size_t>(k)];
    const Vector2d p =
        line.middle + (crossing->at + kEdgeVariance_px2 / (2 * refined.radius_px)) * line.outward;
    Eigen::Matrix<double, 3, 2> d_pixel;
    const auto ray = Ray(camera, p, &d_pixel);
    if (!ray) continue;
    refined.points.push_back({p, *ray, (d_pixel * line.outward).norm(), at[static_cast<std::size_t>(k)]});
    widths.push_back(crossing->width);
  }
  if (!widths.empty()) {
    const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
    std::nth_element(widths.begin(), middle, widths.end());
    refined.width_px = *middle;
  }
  return refined;
}

// The cone by least squares of (angle to the axis - half-angle), in pixels, points far off weighted down
// (Tukey). The scale of what is far is that of the residuals themselves.
struct Adjusted {
  OutlineCone cone;
  NormalEquations<double, 3> normal;  // of two tangents and the half-angle, 1 px each point
  Eigen::Matrix<double, 3, 2> E;
  std::vector<bool> agrees;
  double rms_px = 0;
  bool sound = false;
};
Adjusted Adjust(const std::vector<EdgePoint>& points, OutlineCone cone, double sigma_px) {
  Adjusted a;
  a.agrees.assign(points.size(), false);
  if (points.size() < 6) return a;
  std::vector<double> sizes(points.size());
  double scale = 0;
  for (int iteration = 0; iteration < 15; ++iteration) {
    const auto residual = [&](const EdgePoint& p) {
      return (Angle(cone.axis, p.ray) - cone.half_angle) / p.rad_per_px;
    };
    for (std::size_t i = 0; i < points.size(); ++i) sizes[i] = std::abs(residual(points[i]));
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    scale = std::max(1.4826 * *middle, sigma_px);
    a.E = Across(cone.axis);
    a.normal = {};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const EdgePoint& p = points[i];
      const double r = residual(p), u = r / (kTukey * scale);
      a.agrees[i] = std::abs(r) < 3 * scale;
      const double w = TukeyWeight(u);
      if (w == 0) continue;
      const double s = std::max(1e-9, std::sin(Angle(cone.axis, p.ray)));
      Vector3d J;
      J << -(a.E.transpose() * p.ray) / s, -1;
      J /= p.rad_per_px;
      a.normal.Add(J, -r, w);
    }
    if (a.normal.weight < 5) return a;
    a.rms_px = std::sqrt(a.normal.squares / a.normal.weight);
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(a.normal.H);
    const Vector3d step = ldlt.solve(a.normal.g);
    if (ldlt.info() != Eigen::Success || !step.allFinite() || step.head<2>().norm() > 0.5) return a;
    cone.axis = (cone.axis + a.E * step.head<2>()).normalized();
    cone.half_angle += step.z();
    if (!(cone.half_angle > 1e-6 && cone.half_angle < M_PI / 2)) return a;
    if (iteration > 2 && step.norm() < 1e-9) break;
  }
  a.cone = cone;
  a.sound = true;
  return a;
}

// Of errors that points near each other share, as where shading or background changes on the way round: twice
// round, cos and sin of 2 phi. A whole outline averages them out; of half a one they make another ball.
Eigen::Matrix3d UnevenCovariance(const std::vector<EdgePoint>& points, const Adjusted& a, double uneven_px) {
  Eigen::Matrix<double, 3, 2> g = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!a.agrees[i]) continue;
    const Vector2d side = (a.E.transpose() * points[i].ray).normalized();
    const Vector3d J = Vector3d(-side.x(), -side.y(), -1) / points[i].rad_per_px;
    normal += J * J.transpose();
    g += uneven_px * J *
         Eigen::RowVector2d(side.x() * side.x() - side.y() * side.y(), 2 * side.x() * side.y());
  }
  const Eigen::Matrix<double, 3, 2> off = normal.ldlt().solve(g);
  return off * off.transpose() / 2;
}

std::optional<double> RadPerPx(const CameraModel& camera, const Vector3d& axis) {
  Eigen::Matrix<double, 3, 2> d_pixel;
  const auto pixel = Project(camera, axis);
  if (!pixel || !Ray(camera, *pixel, &d_pixel)) return {};
  return d_pixel.norm() / std::sqrt(2.0);
}

// From a rough cone to the fit: twice across the outline, the second time as far as the edges are wide.
BalloonFit Settle(const cv::Mat& image, const CameraModel& camera, const ColourModel& model,
                  const OutlineCone& rough, const BalloonFitOptions& options) {
  BalloonFit fit;
  fit.state = FitState::kTooLittleOutline;
  auto rad_per_px = RadPerPx(camera, rough.axis);
  if (!rad_per_px) {
    fit.state = FitState::kOffLens;
    return fit;
  }
  const double radius_px = rough.half_angle / *rad_per_px;
  Refined edges =
      EdgesNear(image, camera, model, rough, *rad_per_px, std::clamp(0.35 * radius_px, 5.0, 20.0), options);
  Adjusted a = Adjust(edges.points, rough, options.sigma_px);
  for (int pass = 0; pass < 2 && a.sound; ++pass) {
    rad_per_px = RadPerPx(camera, a.cone.axis);
    if (!rad_per_px) break;
    edges = EdgesNear(image, camera, model, a.cone, *rad_per_px,
                      std::clamp(1.5 * edges.width_px + 3, 5.0, 24.0), options);
    a = Adjust(edges.points, a.cone, options.sigma_px);
  }
  for (const EdgePoint& p : edges.points) fit.edge_points.push_back(p.pixel);
  if (!a.sound || !rad_per_px) return fit;
  int agreeing = 0;
  double square = 0;
  for (std::size_t i = 0; i < edges.points.size(); ++i) {
    if (!a.agrees[i]) continue;
    ++agreeing;
    fit.agreeing_points.push_back(edges.points[i].pixel);
    square += std::pow(
        (Angle(a.cone.axis, edges.points[i].ray) - a.cone.half_angle) / edges.points[i].rad_per_px, 2);
  }
  fit.cone = a.cone;
  fit.outline = static_cast<double>(agreeing) / edges.lines;
  fit.residual_px = std::sqrt(square / std::max(1, agreeing));
  const double found_px = a.cone.half_angle / *rad_per_px;
  if (found_px < options.min_radius_px) {
    fit.state = FitState::kTooSmall;
    return fit;
  }
  // Too uneven for the outline of a ball, or too much beside it that looks as good.
  if (fit.outline < options.min_outline ||
      agreeing < kMinAgreement * static_cast<double>(edges.points.size()) ||
      fit.residual_px > std::max({kMaxUneven_px, kMaxUneven * found_px, kBlurUneven * edges.width_px}))
    return fit;
  // A blurred edge is misplaced by shading and background in proportion to its width.
  const double sigma = std::max({options.sigma_px, fit.residual_px, kBlurSigma * edges.width_px});
  const double crowd = std::max(1.0, kApart_px * edges.lines / (2 * M_PI * found_px));
  Eigen::Matrix3d covariance = sigma * sigma * crowd * a.normal.H.inverse();
  covariance(2, 2) += std::pow(std::hypot(options.bias_px, kBlurBias * edges.width_px) * *rad_per_px, 2);
  covariance += UnevenCovariance(
      edges.points, a, std::max({kUneven_px, 2 * fit.residual_px, kBlurUneven / 2 * edges.width_px}));
  Eigen::Matrix<double, 4, 3> T = Eigen::Matrix<double, 4, 3>::Zero();
  T.topLeftCorner<3, 2>() = a.E;
  T(3, 2) = 1;
  fit.covariance = T * covariance * T.transpose();
  fit.half_angle_sigma = std::sqrt(covariance(2, 2));
  if (fit.covariance.allFinite()) fit.state = FitState::kFitted;
  return fit;
}

}  // namespace

const char* NameOf(FitState state) {
  switch (state) {
    case FitState::kFitted:
      return "fitted";
    case FitState::kTooSmall:
      return "too small";
    case FitState::kTooLittleOutline:
      return "too little outline";
    case FitState::kOffLens:
      return "off the lens";
    case FitState::kBadImage:
      return "bad image";
  }
  return "?";
}

BalloonFit FitBalloon(const cv::Mat& bgr, const CameraModel& camera, const ColourModel& model,
                      const Vector2d& centre_px, double diameter_px, const BalloonFitOptions& options) {
  BalloonFit fit;
  if (bgr.type() != CV_8UC3 || bgr.cols != WidthPx(camera) || bgr.rows != HeightPx(camera)) return fit;
  if (!(diameter_px >= 2 * options.min_radius_px)) {
    fit.state = FitState::kTooSmall;
    return fit;
  }
  const auto axis = Ray(camera, centre_px);
  const auto rad_per_px = axis ? RadPerPx(camera, *axis) : std::nullopt;
  if (!rad_per_px) {
    fit.state = FitState::kOffLens;
    return fit;
  }
  const std::vector<EdgePoint> points = LeavingPoints(bgr, camera, model, centre_px, diameter_px / 2);
  fit.state = FitState::kTooLittleOutline;
  if (const auto rough = Consensus(points, diameter_px / 2 * *rad_per_px))
    fit = Settle(bgr, camera, model, *rough, options);
  return fit;
}

BalloonFit FitBalloonNear(const cv::Mat& bgr, const CameraModel& camera, const ColourModel& model,
                          const OutlineCone& expected, const BalloonFitOptions& options) {
  if (bgr.type() != CV_8UC3 || bgr.cols != WidthPx(camera) || bgr.rows != HeightPx(camera)) return {};
  if (!expected.axis.allFinite() || !(expected.half_angle > 0 && expected.half_angle < M_PI / 2)) {
    BalloonFit fit;
    fit.state = FitState::kOffLens;
    return fit;
  }
  return Settle(bgr, camera, model, expected, options);
}

std::optional<SphereFeatures> FeaturesOf(const OutlineCone& cone, const Eigen::Matrix4d& covariance) {
  const Vector3d& u = cone.axis;
  if (!(u.z() > 0)) return {};
  const double z = u.z(), s = std::sin(cone.half_angle);
  // distance = radius / s, so that D / Z = 2 radius / (distance z) = 2 s / z.
  Eigen::Matrix<double, 3, 4> J;
  J << 1 / z, 0, -u.x() / (z * z), 0, 0, 1 / z, -u.y() / (z * z), 0, 0, 0, -2 * s / (z * z),
      2 * std::cos(cone.half_angle) / z;
  return SphereFeatures{{u.x() / z, u.y() / z, 2 * s / z}, J * covariance * J.transpose()};
}

std::optional<OutlineCone> ConeOfSphere(const Vector3d& p_CT, double radius) {
  const double distance = p_CT.norm();
  if (!(distance > radius) || !(radius > 0)) return {};
  return OutlineCone{p_CT / distance, std::asin(radius / distance)};
}

std::vector<Vector2d> DrawOutline(const CameraModel& camera, const OutlineCone& cone, int points) {
  const Eigen::Matrix<double, 3, 2> E = Across(cone.axis);
  std::vector<Vector2d> outline;
  for (int k = 0; k < points; ++k) {
    const double phi = 2 * M_PI * k / points;
    const Vector3d ray = std::cos(cone.half_angle) * cone.axis +
                         std::sin(cone.half_angle) * (E * Vector2d(std::cos(phi), std::sin(phi)));
    if (const auto pixel = Project(camera, ray)) outline.push_back(*pixel);
  }
  return outline;
}

std::optional<cv::Rect2d> OutlineBox(const CameraModel& camera, const OutlineCone& cone) {
  const std::vector<Vector2d> outline = DrawOutline(camera, cone);
  if (outline.empty()) return {};
  Vector2d low = outline.front(), high = low;
  for (const Vector2d& p : outline) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return cv::Rect2d(low.x() + 0.5, low.y() + 0.5, high.x() - low.x(), high.y() - low.y());
}

}  // namespace kestrel::vision
