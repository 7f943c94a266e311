// SPDX-License-Identifier: Apache-2.0
#include "bench/alignment/alignment_draws.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/file/model_files.h"
#include "base/random.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::bench {
namespace {

const cv::Size kImage(640, 480), kFine(1280, 960);
constexpr double kReferenceNoise_grey = 1;

cv::Mat Text() {
  cv::Mat page(kFine, CV_8UC1, cv::Scalar(225));
  RandomStream random(1, "alignment text");
  for (int y = 18; y < kFine.height + 20; y += 26) {
    std::string line;
    for (int k = 0; k < 90; ++k)
      line +=
          random.Uniform(0, 6) < 1 ? ' ' : static_cast<char>('a' + static_cast<int>(random.Uniform(0, 26)));
    cv::putText(page, line, {-5 - static_cast<int>(random.Uniform(0, 30)), y}, cv::FONT_HERSHEY_SIMPLEX, 0.75,
                cv::Scalar(30), 2, cv::LINE_AA);
  }
  return page;
}

// Noise smoothed at several scales, with so much of each.
cv::Mat Blotches(const std::vector<std::pair<int, double>>& scales, std::string_view name) {
  cv::Mat sum(kFine, CV_32FC1, cv::Scalar(125));
  RandomStream random(1, name);
  for (const auto& [scale, sigma] : scales) {
    cv::Mat coarse(kFine.height / scale + 3, kFine.width / scale + 3, CV_32FC1), large;
    for (int y = 0; y < coarse.rows; ++y) {
      for (int x = 0; x < coarse.cols; ++x)
        coarse.at<float>(y, x) = static_cast<float>(sigma * random.Normal());
    }
    cv::resize(coarse, large, {}, scale, scale, cv::INTER_CUBIC);
    sum += large(cv::Rect({0, 0}, kFine));
  }
  return sum;
}

// Tiles that differ but little from each other.
cv::Mat Repeated() {
  cv::Mat tiles = Blotches({{6, 6}, {60, 8}}, "alignment repeated");
  constexpr int kTile_px = 48;
  for (int y = 0; y < kFine.height; y += kTile_px) {
    for (int x = 0; x < kFine.width; x += kTile_px) {
      const cv::Rect tile(x + 8, y + 8, kTile_px - 16, kTile_px - 16);
      cv::Mat inside = tiles(tile & cv::Rect({0, 0}, kFine));
      inside += ((x + y) / kTile_px % 2 == 0) ? 50 : -50;
    }
  }
  return tiles;
}

cv::Mat Helipad() {
  const auto file = Root() / "models" / "pads" / "helipad" / "helipad.png";
  cv::Mat pad = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  cv::Mat ground = Blotches({{4, 10}, {16, 10}}, "alignment ground");
  constexpr int kWidth = 240, kHeight = 314;
  cv::resize(pad, pad, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
  pad.convertTo(ground(cv::Rect(640 - kWidth / 2, 480 - kHeight / 2, kWidth, kHeight)), CV_32F);
  return ground;
}

// The picture under W, each pixel the mean of four samples.
cv::Mat Shown(const AlignmentPicture& picture, const Eigen::Matrix3d& W) {
  Eigen::Matrix3d fine;
  fine << 2, 0, 0.5, 0, 2, 0.5, 0, 0, 1;
  cv::Mat map, warped, image;
  cv::eigen2cv(Eigen::Matrix3d(fine * W * fine.inverse()), map);
  cv::warpPerspective(picture.fine, warped, map, kFine, cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  cv::resize(warped, image, kImage, 0, 0, cv::INTER_AREA);
  return image;
}

void AddNoise(cv::Mat& image, double sigma, std::uint64_t seed) {
  cv::Mat noise(image.size(), CV_32FC1);
  cv::RNG(seed + 1).fill(noise, cv::RNG::NORMAL, 0, sigma);
  image += noise;
  image.convertTo(image, CV_8U);
}

std::array<Eigen::Vector2d, 4> Corners() {
  const cv::Rect r = kTemplateRegion;
  const double left = r.x, top = r.y, right = r.x + r.width - 1, bottom = r.y + r.height - 1;
  return {Eigen::Vector2d(left, top), {right, top}, {right, bottom}, {left, bottom}};
}

}  // namespace

std::vector<AlignmentPicture> AlignmentPictures() {
  std::vector<AlignmentPicture> pictures{
      {"text", Text()},
      {"texture", Blotches({{4, 16}, {12, 16}, {40, 16}, {120, 16}}, "alignment texture")},
      {"helipad", Helipad()},
      {"repeated", Repeated()},
      {"poor", Blotches({{3, 1.5}, {48, 8}}, "alignment poor")}};
  for (AlignmentPicture& picture : pictures) picture.fine.convertTo(picture.fine, CV_32F);
  return pictures;
}

std::vector<AlignmentNuisance> AlignmentNuisances() {
  return {{.name = "noise"},
          {.name = "light, blur", .noise_grey = 4, .max_gain = 1.4, .max_offset = 20, .max_blur_px = 1}};
}

cv::Mat DrawReference(const AlignmentPicture& picture) {
  cv::Mat image = Shown(picture, Eigen::Matrix3d::Identity());
  AddNoise(image, kReferenceNoise_grey, 0);
  return image;
}

AlignmentDraw DrawDisplaced(const AlignmentPicture& picture, double sigma_px,
                            const AlignmentNuisance& nuisance, std::uint64_t seed) {
  RandomStream random(seed, "alignment " + picture.name + fmt::format(" {:g}", sigma_px));
  std::vector<vision::PointPair> pairs;
  for (const Eigen::Vector2d& corner : Corners()) {
    const double du = sigma_px * random.Normal(), dv = sigma_px * random.Normal();
    pairs.push_back({corner, corner + Eigen::Vector2d(du, dv)});
  }
  AlignmentDraw draw;
  draw.W_truth = *vision::FitHomography(pairs);
  draw.W_truth /= draw.W_truth(2, 2);
  draw.image = Shown(picture, draw.W_truth);
  const double blur_px = random.Uniform(0, nuisance.max_blur_px);
  if (blur_px > 0.2) cv::GaussianBlur(draw.image, draw.image, {}, blur_px);
  const double gain = std::exp(random.Uniform(-1, 1) * std::log(nuisance.max_gain));
  draw.image.convertTo(draw.image, CV_32F, gain, random.Uniform(-1, 1) * nuisance.max_offset);
  AddNoise(draw.image, nuisance.noise_grey, random.Bits());
  return draw;
}

double CornerError_px(const Eigen::Matrix3d& W, const Eigen::Matrix3d& W_truth) {
  double squares = 0;
  for (const Eigen::Vector2d& corner : Corners())
    squares += (vision::Transfer(W, corner) - vision::Transfer(W_truth, corner)).squaredNorm() / 4;
  return std::sqrt(squares);
}

}  // namespace kestrel::bench
