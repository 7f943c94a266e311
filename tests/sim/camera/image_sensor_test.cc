// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/image_sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

namespace kestrel::sim {
namespace {

const cv::Size kSize(320, 240);
const vision::Pinhole kCamera{320, 240, 300, 300, 159.5, 119.5};

cv::Mat Grey(int level) { return cv::Mat(kSize, CV_8UC3, cv::Scalar::all(level)); }

// Noise of a frame: what the sensor made of an even grey of 128, less that.
cv::Mat Noise(const ImageSensor& sensor, std::int64_t sequence) {
  cv::Mat noise;
  sensor.Expose(Grey(128), sequence).convertTo(noise, CV_64F);
  return noise - cv::Scalar::all(128);
}

double Correlation(const cv::Mat& a, const cv::Mat& b) { return a.dot(b) / std::sqrt(a.dot(a) * b.dot(b)); }

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(ImageSensor, WithoutNoiseItPassesTheImageOn) {
  ImageParameters p;
  p.noise_grey = 0;
  cv::Mat bgr(kSize, CV_8UC3);
  cv::randu(bgr, 0, 256);
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  EXPECT_TRUE(Same(ImageSensor(p, kCamera, 1).Expose(bgr, 7), grey));
  p.colour = true;
  EXPECT_TRUE(Same(ImageSensor(p, kCamera, 1).Expose(bgr, 7), bgr));
}

TEST(ImageSensor, NoiseHasItsDeviationAndNoMean) {
  for (const double sigma : {1.0, 2.0, 8.0}) {
    ImageParameters p;
    p.noise_grey = sigma;
    const ImageSensor sensor(p, kCamera, 3);
    double sum = 0, squares = 0;
    constexpr int kFrames = 8;
    for (int i = 0; i < kFrames; ++i) {
      const cv::Mat noise = Noise(sensor, i);
      sum += cv::sum(noise)[0];
      squares += noise.dot(noise);
    }
    const double n = kFrames * static_cast<double>(kSize.area());
    EXPECT_NEAR(sum / n, 0, 0.02 * sigma);
    EXPECT_NEAR(squares / n, sigma * sigma + 1.0 / 12, 0.03 * sigma * sigma);  // rounding adds a twelfth
  }
}

TEST(ImageSensor, NoiseIsWhiteInTheImageAndInTime) {
  const ImageSensor sensor({}, kCamera, 4);
  const cv::Mat first = Noise(sensor, 0);
  constexpr double kBound = 0.02;  // five deviations for 76800 pixels
  EXPECT_LT(std::abs(Correlation(first, Noise(sensor, 1))), kBound);
  EXPECT_LT(std::abs(Correlation(first, Noise(sensor, 1000))), kBound);
  const int w = kSize.width, h = kSize.height;
  for (const cv::Point shift : {cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1), cv::Point(7, 2)}) {
    const cv::Rect here(0, 0, w - shift.x, h - shift.y);
    EXPECT_LT(std::abs(Correlation(first(here).clone(), first(here + shift).clone())), kBound) << shift;
  }
}

TEST(ImageSensor, SeedAndSequenceAloneDecide) {
  const ImageSensor a({}, kCamera, 5), again({}, kCamera, 5), other({}, kCamera, 6);
  const cv::Mat bgr = Grey(90);
  // in another order, and by another sensor of the same seed
  const cv::Mat third = a.Expose(bgr, 3), first = a.Expose(bgr, 1);
  EXPECT_TRUE(Same(first, again.Expose(bgr, 1)));
  EXPECT_TRUE(Same(third, again.Expose(bgr, 3)));
  EXPECT_TRUE(Same(third, a.Expose(bgr, 3)));
  EXPECT_FALSE(Same(first, third));
  EXPECT_FALSE(Same(first, other.Expose(bgr, 1)));
}

TEST(ImageSensor, BlackAndWhiteAreTheEndsOfTheScale) {
  ImageParameters p;
  p.noise_grey = 20;
  const ImageSensor sensor(p, kCamera, 7);
  for (const int level : {0, 255}) {
    const cv::Mat image = sensor.Expose(Grey(level), 0);
    const double clipped = cv::countNonZero(image == level) / static_cast<double>(kSize.area());
    EXPECT_NEAR(clipped, 0.5,
                0.03);  // half the noise would go beyond, and must not come round at the other end
    EXPECT_EQ(cv::countNonZero(cv::abs(image - level) > 120), 0);
  }
}

TEST(ImageSensor, EachChannelOfColourHasNoiseOfItsOwn) {
  ImageParameters p;
  p.colour = true;
  const cv::Mat noise = Noise(ImageSensor(p, kCamera, 8), 2);
  ASSERT_EQ(noise.channels(), 3);
  cv::Mat channels[3];
  cv::split(noise, channels);
  for (const cv::Mat& c : channels)
    EXPECT_NEAR(std::sqrt(c.dot(c) / kSize.area()), std::sqrt(4 + 1.0 / 12), 0.06);
  EXPECT_LT(std::abs(Correlation(channels[0], channels[1])), 0.02);
  EXPECT_LT(std::abs(Correlation(channels[1], channels[2])), 0.02);
}

TEST(ImageSensor, TheRenderedImageIsLeftAsItWas) {
  const cv::Mat bgr = Grey(50);
  ImageParameters p;
  p.colour = true;
  ImageSensor(p, kCamera, 9).Expose(bgr, 0);
  EXPECT_TRUE(Same(bgr, Grey(50)));
}

// Photon transfer (EMVA 1288): the variance at a pixel, from the difference of two frames, against its mean.
TEST(ImageSensor, TheVarianceGrowsWithTheSignalByGainAndFullWell) {
  for (const double gain : {1.0, 2.5}) {
    ImageParameters p;
    p.full_well_e = 9000, p.noise_grey = 1.5, p.gain = gain;
    const ImageSensor sensor(p, kCamera, 11);
    // a straight line through the variances by least squares
    double n = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
    for (int level = 15; level * gain < 220; level += 12) {
      cv::Mat a, b;
      sensor.Expose(Grey(level), 2 * level).convertTo(a, CV_64F);
      sensor.Expose(Grey(level), 2 * level + 1).convertTo(b, CV_64F);
      const double mean = (cv::mean(a)[0] + cv::mean(b)[0]) / 2;
      cv::Scalar unused, deviation;
      cv::meanStdDev(a - b, unused, deviation);
      const double variance = deviation[0] * deviation[0] / 2;
      EXPECT_NEAR(mean, gain * level, 0.05);
      const double line = gain * 255 / 9000 * mean + std::pow(1.5 * gain, 2) + 1.0 / 12;
      EXPECT_NEAR(variance, line, 0.025 * line) << level;  // five deviations for 76800 pixels
      n += 1, sum_x += mean, sum_y += variance, sum_xx += mean * mean, sum_xy += mean * variance;
    }
    ASSERT_GT(n, 5);
    const double slope = (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
    EXPECT_NEAR(slope, gain * 255 / 9000, 0.06 * gain * 255 / 9000);
    EXPECT_NEAR((sum_y - slope * sum_x) / n, std::pow(1.5 * gain, 2) + 1.0 / 12, 0.12 * gain * gain);
  }
}

TEST(ImageSensor, GainAndExposureBrightenAlikeButOnlyGainBrightensTheReadNoise) {
  ImageParameters p;
  p.noise_grey = 2, p.gamma = 1, p.bits = 8, p.lens.cos_power = 1e-9;  // so that light is reckoned
  const ImageSensor sensor(p, kCamera, 12);
  const auto moments = [&](const ExposureSetting& setting) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(sensor.Expose(Grey(40), 3, setting), mean, deviation);
    return std::pair(mean[0], deviation[0]);
  };
  const auto longer = moments({0, 3, 1}), amplified = moments({0, 1, 3});
  EXPECT_NEAR(longer.first, 120, 0.05);
  EXPECT_NEAR(amplified.first, 120, 0.1);
  EXPECT_NEAR(longer.second, 2, 0.05);
  EXPECT_NEAR(amplified.second, 6, 0.1);
}

// The distribution of the difference of two Poisson counts, which is what the discrete Gaussian is.
cv::Mat Skellam(double variance) {
  constexpr int kReach = 14, kCounts = 60;
  const auto poisson = [&](int k) {
    return std::exp(k * std::log(variance / 2) - variance / 2 - std::lgamma(k + 1));
  };
  cv::Mat kernel(2 * kReach + 1, 1, CV_64F, cv::Scalar(0));
  for (int n = -kReach; n <= kReach; ++n) {
    for (int k = std::max(0, -n); k < kCounts; ++k)
      kernel.at<double>(kReach + n) += poisson(k) * poisson(k + n);
  }
  return kernel;
}

// The chain as a physicist writes it down, pixel by pixel and in double precision; random numbers are those
// of the sensor's own table. Its defocus is heat that spreads for a while, which is the discrete Gaussian.
cv::Mat SlowExpose(const ImageParameters& p, const vision::Pinhole& camera, const NoiseTable<float>& table,
                   const cv::Mat& bytes, std::int64_t sequence, const ExposureSetting& setting) {
  const int channels = bytes.channels(), border = 30;
  cv::Mat result(bytes.size(), bytes.type());
  for (int c = 0; c < channels; ++c) {
    cv::Mat byte, light(bytes.rows + 2 * border, bytes.cols + 2 * border, CV_64F);
    cv::extractChannel(bytes, byte, c);
    for (int y = 0; y < light.rows; ++y) {
      for (int x = 0; x < light.cols; ++x) {
        const int b = byte.at<std::uint8_t>(std::clamp(y - border, 0, bytes.rows - 1),
                                            std::clamp(x - border, 0, bytes.cols - 1));
        light.at<double>(y, x) = std::pow(b / 255.0, p.gamma);
      }
    }
    if (p.lens.defocus_px > 0) {
      const cv::Mat spread = Skellam(p.lens.defocus_px * p.lens.defocus_px);
      cv::sepFilter2D(light, light, CV_64F, spread, spread);
    }
    for (int y = 0; y < bytes.rows; ++y) {
      for (int x = 0; x < bytes.cols; ++x) {
        double signal = light.at<double>(y + border, x + border);
        const double angle = std::atan(std::hypot((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy));
        const double r = std::hypot(x - camera.cx, y - camera.cy);
        const double rho = r / (std::hypot(camera.width_px, camera.height_px) / 2);
        signal *= std::pow(std::cos(angle), p.lens.cos_power) * (1 + p.lens.vignetting[0] * rho * rho);
        if (p.lens.rim_px > 0 && r > p.lens.rim_px) signal = 0;
        if (angle * 57.29577951308232 < p.lens.reflection_deg) signal = 0;
        signal *= setting.light;
        const double electrons = p.full_well_e * signal;
        const double shot = p.full_well_e > 0 ? std::sqrt(electrons) / p.full_well_e : 0;
        const double read = p.noise_grey / 255;
        const double normal = table.Row(sequence, y, bytes.cols * channels)[x * channels + c];
        signal = setting.gain * (signal + std::hypot(shot, read) * normal);
        const double coded = std::pow(std::clamp(signal, 0.0, 1.0), 1 / p.gamma);
        const int top = (1 << p.bits) - 1;
        result.ptr(y)[x * channels + c] =
            static_cast<std::uint8_t>(std::lround(std::floor(coded * top + 0.5) * 255 / top));
      }
    }
  }
  return result;
}

// Where an edge of rim or reflection crosses a pixel, the sensor takes a share and the slow chain all or
// none.
cv::Mat AwayFromEdges(const ImageParameters& p, const vision::Pinhole& camera) {
  cv::Mat mask(camera.height_px, camera.width_px, CV_8U);
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      const double r = std::hypot(x - camera.cx, y - camera.cy);
      const double reflection = camera.fx * std::tan(p.lens.reflection_deg / 57.29577951308232);
      mask.at<std::uint8_t>(y, x) = std::abs(r - p.lens.rim_px) > 1 && std::abs(r - reflection) > 1 ? 255 : 0;
    }
  }
  return mask;
}

TEST(ImageSensor, AgreesWithTheSlowChain) {
  const vision::Pinhole camera{96, 64, 80, 80, 50.3, 30.8};
  cv::Mat scene(camera.height_px, camera.width_px, CV_8UC3);
  cv::theRNG().state = 5;
  cv::randu(scene, 0, 256);
  cv::rectangle(scene, {20, 10, 30, 40}, {250, 240, 255}, cv::FILLED);
  ImageParameters none, lens, noise, tone, all;
  none.noise_grey = lens.noise_grey = tone.noise_grey = 0;
  none.gain = 1.2;
  lens.lens.cos_power = 4, lens.lens.vignetting[0] = -0.3, lens.lens.rim_px = 45,
  lens.lens.reflection_deg = 7;
  lens.lens.defocus_px = 1.3;
  noise.full_well_e = 4000, noise.noise_grey = 3, noise.gain = 1.7;
  tone.gamma = 2.2, tone.bits = 5;
  all = lens;
  all.full_well_e = 4000, all.noise_grey = 3, all.gain = 1.7, all.gamma = 2.2, all.bits = 6;
  const NoiseTable<float> table(9, [](double n) { return static_cast<float>(n); });
  for (ImageParameters p : {none, lens, noise, tone, all}) {
    for (const bool colour : {false, true}) {
      p.colour = colour;
      cv::Mat bytes = scene;
      if (!colour) cv::cvtColor(scene, bytes, cv::COLOR_BGR2GRAY);
      const ExposureSetting setting{0, 0.8, p.gain};
      const cv::Mat fast = ImageSensor(p, camera, 9).Expose(scene, 4, setting);
      const cv::Mat slow = SlowExpose(p, camera, table, bytes, 4, setting);
      ASSERT_EQ(fast.type(), slow.type());
      cv::Mat difference, mask = AwayFromEdges(p, camera);
      cv::absdiff(fast, slow, difference);
      if (colour) cv::merge(std::vector<cv::Mat>(3, mask), mask);
      difference &= mask;
      // single precision may round to the neighbouring level
      const double level = 255.0 / ((1 << p.bits) - 1);
      EXPECT_LE(cv::norm(difference, cv::NORM_INF), std::ceil(level)) << colour;
      EXPECT_LT(cv::countNonZero(difference.reshape(1)), 0.002 * difference.total() * difference.channels());
      EXPECT_GT(cv::norm(fast, bytes, cv::NORM_INF), 5);  // something was done
    }
  }
}

TEST(ImageSensor, GlareSpreadsItsShareOfTheLightOverAllOfTheImage) {
  ImageParameters p;
  p.noise_grey = 0;
  p.lens.glare = 0.1;
  cv::Mat half(100, 200, CV_8UC3, cv::Scalar::all(0));
  half.colRange(0, 100).setTo(cv::Scalar::all(200));
  const cv::Mat image = ImageSensor(p, vision::Pinhole{200, 100, 100, 100, 99.5, 49.5}, 1).Expose(half, 0);
  EXPECT_EQ(image.at<uchar>(50, 20), 190);  // 0.9 * 200 + 0.1 * 100
  EXPECT_EQ(image.at<uchar>(50, 180), 10);
}

TEST(ImageSensor, FewBitsAreFewLevels) {
  ImageParameters p;
  p.noise_grey = 0, p.bits = 3;
  cv::Mat ramp(kSize, CV_8UC3);
  for (int x = 0; x < ramp.cols; ++x) ramp.col(x) = cv::Scalar::all(x * 255 / (ramp.cols - 1));
  const cv::Mat image = ImageSensor(p, kCamera, 1).Expose(ramp, 0);
  for (int x = 0; x < ramp.cols; ++x) {
    const int level = std::lround(ramp.at<cv::Vec3b>(0, x)[0] * 7 / 255.0);
    EXPECT_EQ(image.at<std::uint8_t>(17, x), std::lround(level * 255 / 7.0));
  }
}

TEST(ImageSensor, WithGammaAnImageWithoutNoiseIsAsItWas) {
  ImageParameters p;
  p.noise_grey = 0, p.gamma = 2.2;
  cv::Mat bgr(kSize, CV_8UC3), grey;
  cv::randu(bgr, 0, 256);
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  EXPECT_TRUE(Same(ImageSensor(p, kCamera, 1).Expose(bgr, 0), grey));
  // twice the light is less than twice the level
  const cv::Mat twice = ImageSensor(p, kCamera, 1).Expose(Grey(60), 0, {0, 2, 1});
  EXPECT_EQ(twice.at<std::uint8_t>(5, 5), std::lround(60 * std::pow(2, 1 / 2.2)));
}

TEST(ImageSensor, CompressionComesLastAndTouchesOnlyTheBlockItIsIn) {
  ImageParameters p;
  p.noise_grey = 3;
  const ImageSensor plain(p, kCamera, 2);
  p.jpeg_quality = 60;
  const ImageSensor compressing(p, kCamera, 2);
  cv::Mat scene(kSize, CV_8UC3);
  cv::randu(scene, 0, 256);
  cv::GaussianBlur(scene, scene, {0, 0}, 4);
  // What is compressed is what there would be without.
  std::vector<std::uint8_t> file;
  cv::imencode(".jpg", plain.Expose(scene, 5), file, {cv::IMWRITE_JPEG_QUALITY, 60});
  const cv::Mat once = compressing.Expose(scene, 5);
  EXPECT_TRUE(Same(once, cv::imdecode(file, cv::IMREAD_GRAYSCALE)));
  EXPECT_FALSE(Same(once, plain.Expose(scene, 5)));
  EXPECT_EQ(once.type(), CV_8UC1);

  // A block of 8 x 8 pixels is coded by itself.
  scene(cv::Rect(50, 100, 3, 2)).setTo(cv::Scalar::all(255));
  cv::Mat changed;
  cv::absdiff(once, compressing.Expose(scene, 5), changed);
  EXPECT_GT(cv::countNonZero(changed), 0);
  changed(cv::Rect(48, 96, 8, 8)).setTo(0);
  EXPECT_EQ(cv::countNonZero(changed), 0);

  p.noise_grey = 0;
  double least, most;  // an even image stays even, though its level may be rounded
  cv::minMaxLoc(ImageSensor(p, kCamera, 1).Expose(Grey(93), 0), &least, &most);
  EXPECT_EQ(least, most);
  EXPECT_NEAR(least, 93, 1);
  p.colour = true;
  EXPECT_EQ(ImageSensor(p, kCamera, 1).Expose(scene, 0).type(), CV_8UC3);
}

TEST(ImageSensor, TheWorseTheQualityTheSmallerItsFidelity) {
  ImageParameters p;
  cv::Mat scene(kSize, CV_8UC3), grey;
  cv::randu(scene, 0, 256);
  cv::GaussianBlur(scene, scene, {0, 0}, 2);
  cv::cvtColor(scene, grey, cv::COLOR_BGR2GRAY);
  p.noise_grey = 0;
  double last = 0;
  for (const int quality : {100, 90, 60, 20, 5}) {
    p.jpeg_quality = quality;
    const double error =
        cv::norm(ImageSensor(p, kCamera, 1).Expose(scene, 0), grey) / std::sqrt(grey.total());
    EXPECT_GT(error, last) << quality;
    last = error;
  }
  EXPECT_LT(last, 20);
}

// Every part at once.
ImageParameters Everything() {
  ImageParameters p;
  p.full_well_e = 5000, p.gain = 1.3, p.gamma = 2, p.bits = 7, p.jpeg_quality = 70;
  p.lens.cos_power = 3, p.lens.defocus_px = 0.8, p.lens.rim_px = 110, p.lens.reflection_deg = 4;
  return p;
}

TEST(ImageSensor, OrderAndThreadsOfAllPartsChangeNothing) {
  cv::Mat scene(kSize, CV_8UC3);
  cv::randu(scene, 0, 256);
  const ImageSensor sensor(Everything(), kCamera, 5), again(Everything(), kCamera, 5);
  constexpr int kFrames = 6;
  std::vector<cv::Mat> forward, threaded(kFrames);
  for (int i = 0; i < kFrames; ++i) forward.push_back(sensor.Expose(scene, i));
  std::vector<std::thread> threads;
  for (int i = 0; i < kFrames; ++i)
    threads.emplace_back([&, i] { threaded[kFrames - 1 - i] = again.Expose(scene, kFrames - 1 - i); });
  for (std::thread& t : threads) t.join();
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  for (int i = kFrames - 1; i >= 0; --i) {
    EXPECT_TRUE(Same(forward[i], threaded[i]));
    EXPECT_TRUE(Same(forward[i], again.Expose(scene, i)));
  }
  cv::setNumThreads(before);
  EXPECT_FALSE(Same(forward[0], forward[1]));
  EXPECT_FALSE(Same(forward[0], ImageSensor(Everything(), kCamera, 6).Expose(scene, 0)));
}

TEST(ImageSensor, GarbageIsEvenAndOfItsFrame) {
  const ImageSensor sensor({}, kCamera, 5), other({}, kCamera, 6);
  const cv::Mat a = sensor.Garbage(kSize, 1), b = sensor.Garbage(kSize, 2);
  EXPECT_EQ(a.type(), CV_8UC1);
  EXPECT_TRUE(Same(a, sensor.Garbage(kSize, 1)));
  EXPECT_FALSE(Same(a, other.Garbage(kSize, 1)));
  cv::Mat x, y;
  a.convertTo(x, CV_64F), b.convertTo(y, CV_64F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(x, mean, deviation);
  EXPECT_NEAR(mean[0], 127.5, 1);
  EXPECT_NEAR(deviation[0], 256 / std::sqrt(12), 1);
  EXPECT_LT(std::abs(Correlation(x - mean[0], y - mean[0])), 0.02);
  EXPECT_LT(std::abs(Correlation(x.colRange(1, 320).clone() - mean[0], x.colRange(0, 319).clone() - mean[0])),
            0.02);
}

TEST(ImageSensor, MetersWhatTheLensLights) {
  ImageParameters p;
  p.noise_grey = 0, p.lens.rim_px = 80, p.lens.reflection_deg = 5;
  p.auto_exposure.target_grey = 100;
  const ImageSensor sensor(p, kCamera, 1);
  // The pixels that the edges cross are lit in part, and count as lit.
  EXPECT_NEAR(sensor.MeanGrey(sensor.Expose(Grey(150), 0, {0, 1, 1})), 150, 3);
  p.lens = {};
  EXPECT_EQ(ImageSensor(p, kCamera, 1).MeanGrey(Grey(150)), 150);
}

TEST(ImageScatter, IsDrawnOnceARunWithinItsBoundsAndRange) {
  ImageParameters p;
  p.gain = 2, p.jpeg_quality = 50;
  p.scatter.gain = 0.5, p.scatter.defocus_px = 1, p.scatter.jpeg_quality = 30, p.scatter.time_s = 0.01;
  p.exposure.time_s = 0.02;
  double least_gain = 9, most_gain = 0, least_time = 9, most_time = 0;
  int sharp = 0, least_quality = 100, most_quality = 0;
  constexpr int kRuns = 300;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const ImageParameters drawn = DrawScatter(p, seed);
    least_gain = std::min(least_gain, drawn.gain), most_gain = std::max(most_gain, drawn.gain);
    least_time = std::min(least_time, drawn.exposure.time_s);
    most_time = std::max(most_time, drawn.exposure.time_s);
    least_quality = std::min(least_quality, drawn.jpeg_quality);
    most_quality = std::max(most_quality, drawn.jpeg_quality);
    sharp += drawn.lens.defocus_px == 0;
    EXPECT_GE(drawn.lens.defocus_px, 0);
    EXPECT_EQ(drawn.noise_grey, p.noise_grey);
    EXPECT_EQ(drawn.scatter.gain, 0);
    EXPECT_EQ(DrawScatter(drawn, seed + 1).gain, drawn.gain);  // nothing is left to draw
    ImageParameters more = p;
    more.scatter.noise_grey = 1;
    EXPECT_EQ(DrawScatter(more, seed).gain, drawn.gain);  // one more shifts no other
  }
  EXPECT_GE(least_gain, 1.5);
  EXPECT_LT(least_gain, 1.52);
  EXPECT_LE(most_gain, 2.5);
  EXPECT_GT(most_gain, 2.48);
  EXPECT_GE(least_time, 0.01);
  EXPECT_LE(most_time, LongestExposure_s(p));
  EXPECT_GT(most_time, 0.0295);
  EXPECT_GE(least_quality, 20);
  EXPECT_LE(most_quality, 80);
  EXPECT_GT(most_quality - least_quality, 55);
  EXPECT_NEAR(sharp, kRuns / 2.0, 30);  // off in half of the runs
}

}  // namespace
}  // namespace kestrel::sim
