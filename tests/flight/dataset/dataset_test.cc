// SPDX-License-Identifier: Apache-2.0
// Sets are made, and read back by what their formats' own readers go by.
#include "flight/dataset/dataset.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>
#include <tuple>

#include "base/yaml/config.h"
#include "flight/dataset/journal.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::StartsWith;

using Rows = std::vector<std::vector<std::string>>;

// The lines that are no comments, cut at separators.
Rows Read(const fs::path& file, char separator) {
  Rows rows;
  std::ifstream lines(file);
  EXPECT_TRUE(lines) << file;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, separator);) rows.back().push_back(cell);
  }
  return rows;
}

std::vector<std::string> Column(const Rows& rows, std::size_t column) {
  std::vector<std::string> cells;
  for (const auto& row : rows) cells.push_back(row.at(column));
  return cells;
}

std::vector<double> Numbers(const std::vector<std::string>& cells, std::size_t from, std::size_t count) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(std::stod(cells.at(from + i)));
  return numbers;
}

// Whole numbers of one length, rising.
void ExpectStamps(const std::vector<std::string>& stamps) {
  ASSERT_FALSE(stamps.empty());
  EXPECT_TRUE(std::is_sorted(stamps.begin(), stamps.end()));
  EXPECT_EQ(std::set(stamps.begin(), stamps.end()).size(), stamps.size());
  for (const std::string& stamp : stamps) {
    EXPECT_EQ(stamp.size(), stamps[0].size());
    EXPECT_EQ(stamp.find_first_not_of("0123456789."), std::string::npos);
  }
}

std::vector<double> List(const fs::path& file, const std::string& key) {
  Mistakes mistakes;
  const Config config = LoadConfig(file, {}, mistakes);
  std::vector<double> numbers;
  const auto gather = [&](const ConfigNode& node, const auto& self) -> void {
    if (node.kind == ConfigNode::Kind::kText) numbers.push_back(std::stod(node.text));
    for (const auto& each : node.members) self(each.node, self);
  };
  const auto find = [&](const ConfigNode& node, const auto& self) -> void {
    for (const auto& each : node.members) each.key == key ? gather(each.node, gather) : self(each.node, self);
  };
  find(config.root, find);
  EXPECT_TRUE(mistakes.empty());
  return numbers;
}

Pose PoseOfMatrix(const std::vector<double>& m) {
  Eigen::Matrix3d R;
  R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  return {Eigen::Quaterniond(R), {m[3], m[7], m[11]}};
}

class Dataset : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::ofstream(folder_ / "way.yaml")
        << "way:\n"
           "  - {t_s: 0, position_m: [-0.5, 0.2, 4], yaw_deg: 20}\n"
           "  - {t_s: 0.2, position_m: [0, 0.3, 4.4], yaw_deg: 50, roll_deg: 4}\n"
           "  - {t_s: 0.5, position_m: [0.5, 0, 4], yaw_deg: 70, pitch_deg: 3}\n";
    std::ofstream(folder_ / "camera.yaml")
        << "width_px: 64\nheight_px: 48\nfx_px: 40\nfy_px: 40\ncx_px: 31.5\ncy_px: 23.5\n";
  }

  DatasetArguments Arguments(const std::string& format) const {
    DatasetArguments a;
    a.source = folder_ / "way.yaml";
    a.format = format;
    a.out = folder_ / format;
    a.overrides = {"world=plain", "image.rate_hz=10", "camera=" + (folder_ / "camera.yaml").string()};
    a.imu_rate_hz = 100;
    a.extras = {.depth = true, .flow = true, .segmentation = true, .boxes = true};
    a.jobs = 2;
    return a;
  }
  static DatasetResult Make(const DatasetArguments& a) { return MakeDataset(LoadDatasetPlan(a)); }

  // Of what was written: X_WC of frame k, the first camera, its depth there. The middle of the pad, the origin of W, is
  // to be seen where that says.
  static void ExpectPad(const Pose& X_WC, const std::vector<double>& f, const cv::Mat& geom,
                        const fs::path& geoms, const std::function<double(int, int)>& depth_m,
                        bool of_plane) {
    const Eigen::Vector3d p_C = X_WC.Inverse() * Eigen::Vector3d(0, 0, 0.01);
    const int u = static_cast<int>(std::lround(f[0] * p_C.x() / p_C.z() + f[2]));
    const int v = static_cast<int>(std::lround(f[1] * p_C.y() / p_C.z() + f[3]));
    ASSERT_TRUE(u >= 0 && v >= 0 && u < geom.cols && v < geom.rows) << u << " " << v;
    std::map<std::string, std::string> bodies;
    for (const auto& row : Read(geoms, ',')) bodies[row[0]] = row.size() > 2 ? row[2] : "";
    EXPECT_EQ(bodies.at(std::to_string(geom.at<std::uint16_t>(v, u))), "pad");
    EXPECT_NEAR(depth_m(u, v), of_plane ? p_C.z() : p_C.norm(), 0.15);  // half a pixel off at 4 m
  }
};

TEST_F(Dataset, OfEurocIsAsItsReadersWantIt) {
  const DatasetResult result = Make(Arguments("euroc"));
  EXPECT_EQ(result.frames, 6u);
  const fs::path mav = folder_ / "euroc" / "mav0";
  const Rows images = Read(mav / "cam0/data.csv", ',');
  EXPECT_THAT(Content(mav / "cam0/data.csv"), StartsWith("#timestamp [ns],filename\n"));
  ExpectStamps(Column(images, 0));
  ASSERT_EQ(images.size(), 6u);
  for (const auto& row : images) {
    EXPECT_EQ(row.at(1), row[0] + ".png");
    EXPECT_EQ(cv::imread((mav / "cam0/data" / row[1]).string(), cv::IMREAD_UNCHANGED).type(), CV_8UC1);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(mav / "cam0/data"), {}), 6);
  EXPECT_EQ(std::distance(fs::directory_iterator(mav / "flow0/data"), {}), 5);  // none from the last

  const Rows imu = Read(mav / "imu0/data.csv", ','),
             truth = Read(mav / "state_groundtruth_estimate0/data.csv", ',');
  ExpectStamps(Column(imu, 0));
  ExpectStamps(Column(truth, 0));
  EXPECT_EQ(imu.size(), 51u);
  EXPECT_THAT(Column(imu, 0), IsSupersetOf(Column(images, 0)));
  EXPECT_EQ(Column(truth, 0), Column(imu, 0));
  for (const auto& row : imu) EXPECT_EQ(row.size(), 7u);
  for (const auto& row : truth) {
    ASSERT_EQ(row.size(), 17u);
    const auto q = Numbers(row, 4, 4);
    EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-9);
  }

  const auto T_BS = List(mav / "cam0/sensor.yaml", "data"), f = List(mav / "cam0/sensor.yaml", "intrinsics");
  EXPECT_EQ(List(mav / "cam0/sensor.yaml", "rate_hz"), std::vector<double>{10});
  EXPECT_EQ(List(mav / "cam0/sensor.yaml", "resolution"), (std::vector<double>{64, 48}));
  EXPECT_EQ(List(mav / "imu0/sensor.yaml", "rate_hz"), std::vector<double>{100});
  for (const std::size_t k : {0u, 3u, 5u}) {
    const auto row =
        std::find_if(truth.begin(), truth.end(), [&](const auto& r) { return r[0] == images[k][0]; });
    const auto n = Numbers(*row, 1, 7);
    const Pose X_WB{{n[3], n[4], n[5], n[6]}, {n[0], n[1], n[2]}};
    const cv::Mat depth =
        cv::imread((mav / "depth0/data" / (images[k][0] + ".tiff")).string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(depth.type(), CV_32FC1);
    ExpectPad(
        X_WB * PoseOfMatrix(T_BS), f,
        cv::imread((mav / "segmentation0/data" / images[k][1]).string(), cv::IMREAD_UNCHANGED),
        folder_ / "euroc/geoms.csv", [&](int u, int v) { return depth.at<float>(v, u); }, false);
  }
  // T_cam_imu of Kalibr is the inverse of T_BS, the IMU being the body.
  const Pose product = PoseOfMatrix(List(folder_ / "euroc/camchain.yaml", "T_cam_imu")) * PoseOfMatrix(T_BS);
  EXPECT_LT(product.p.norm() + product.R.angularDistance(Eigen::Quaterniond::Identity()), 1e-9);
}

// As evo reads TUM trajectories: eight columns, blanks between them, rising stamps, unit quaternions.
TEST_F(Dataset, OfTumIsAsItsReadersWantIt) {
  Make(Arguments("tum"));
  const fs::path set = folder_ / "tum";
  const Rows images = Read(set / "rgb.txt", ' '), depths = Read(set / "depth.txt", ' ');
  const Rows truth = Read(set / "groundtruth.txt", ' '), forces = Read(set / "accelerometer.txt", ' ');
  ExpectStamps(Column(images, 0));
  ExpectStamps(Column(truth, 0));
  EXPECT_EQ(Column(images, 0), Column(depths, 0));
  EXPECT_THAT(Column(truth, 0), IsSupersetOf(Column(images, 0)));
  EXPECT_EQ(Column(forces, 0), Column(truth, 0));
  const auto f = List(set / "camchain.yaml", "intrinsics");
  for (const std::size_t k : {0u, 4u}) {
    EXPECT_EQ(cv::imread((set / images[k].at(1)).string(), cv::IMREAD_UNCHANGED).type(), CV_8UC3);
    const cv::Mat depth = cv::imread((set / depths[k].at(1)).string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(depth.type(), CV_16UC1);
    const auto row =
        std::find_if(truth.begin(), truth.end(), [&](const auto& r) { return r[0] == images[k][0]; });
    ASSERT_EQ(row->size(), 8u);
    const auto n = Numbers(*row, 1, 7);
    EXPECT_NEAR(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6], 1, 1e-9);
    ExpectPad(
        {{n[6], n[3], n[4], n[5]}, {n[0], n[1], n[2]}}, f,
        cv::imread((set / "segmentation" / (images[k][0] + ".png")).string(), cv::IMREAD_UNCHANGED),
        set / "geoms.csv", [&](int u, int v) { return depth.at<std::uint16_t>(v, u) / 5000.0; }, true);
  }
}

// The odometry benchmark: a time and twelve numbers for each image, the first pose the identity; and its flow by what
// OpenCV and the devkit make of it, beside where the pad really goes.
TEST_F(Dataset, OfKittiIsAsItsReadersWantIt) {
  Make(Arguments("kitti"));
  const fs::path sequence = folder_ / "kitti/sequences/00";
  const Rows times = Read(sequence / "times.txt", ' '), poses = Read(folder_ / "kitti/poses/00.txt", ' ');
  ASSERT_EQ(times.size(), 6u);
  ASSERT_EQ(poses.size(), 6u);
  EXPECT_EQ(std::stod(times[0][0]), 0);
  EXPECT_EQ(std::stod(times[5][0]), 0.5);
  const Pose first = PoseOfMatrix(Numbers(poses[0], 0, 12));
  EXPECT_LT(first.p.norm() + first.R.angularDistance(Eigen::Quaterniond::Identity()), 1e-12);
  const Rows calibration = Read(sequence / "calib.txt", ' ');
  ASSERT_EQ(calibration.size(), 5u);
  EXPECT_EQ(calibration[0].at(0), "P0:");
  const auto P0 = Numbers(calibration[0], 1, 12);
  // Where the pad is in the first camera is not in the format: by depth and pixel, and from there on by the poses.
  const auto read = [&](const char* what, int k) {
    return cv::imread((sequence / what / fmt::format("{:06}.png", k)).string(), cv::IMREAD_UNCHANGED);
  };
  const cv::Mat depth = read("depth_0", 0), flow = read("flow_0", 0);
  ASSERT_EQ(depth.type(), CV_16UC1);
  ASSERT_EQ(flow.type(), CV_16UC3);
  EXPECT_EQ(read("image_0", 5).type(), CV_8UC1);
  const Pose X_01 = PoseOfMatrix(Numbers(poses[1], 0, 12));
  for (const auto& [u, v] : {std::pair(20, 20), {40, 30}}) {
    const double z = depth.at<std::uint16_t>(v, u) / 256.0;
    const Eigen::Vector3d p_0(z * (u - P0[2]) / P0[0], z * (v - P0[6]) / P0[5], z),
        p_1 = X_01.Inverse() * p_0;
    const cv::Vec3w coded = flow.at<cv::Vec3w>(v, u);
    ASSERT_EQ(coded[0], 1);
    EXPECT_NEAR((coded[2] - 32768.0) / 64, P0[0] * p_1.x() / p_1.z() + P0[2] - u, 0.03);
    EXPECT_NEAR((coded[1] - 32768.0) / 64, P0[5] * p_1.y() / p_1.z() + P0[6] - v, 0.03);
  }
}

TEST_F(Dataset, OfKittiHasAStereoPairWithItsBaseline) {
  DatasetArguments a = Arguments("kitti");
  a.overrides.push_back("cameras=[{name: right, camera: " + (folder_ / "camera.yaml").string() +
                        ", trigger: main, mount: {position_m: [0, 0.1, 0.05]}}]");
  EXPECT_EQ(Make(a).frames, 12u);
  const fs::path sequence = folder_ / "kitti/sequences/00";
  EXPECT_NEAR(Numbers(Read(sequence / "calib.txt", ' ')[1], 1, 12)[3], -40 * 0.1, 1e-12);
  EXPECT_EQ(std::distance(fs::directory_iterator(sequence / "image_1"), {}), 6);
  const auto read = [&](const char* image) {
    return cv::imread((sequence / image).string(), cv::IMREAD_GRAYSCALE);
  };
  EXPECT_GT(cv::norm(read("image_0/000002.png"), read("image_1/000002.png"), cv::NORM_L1), 0);
}

// The truth that a set holds, flown again, shows the same: what is read and what is written agree on all frames.
TEST_F(Dataset, FromItsOwnTruthHasTheSameImages) {
  for (const auto& [format, truth, images] :
       {std::tuple("euroc", "mav0/state_groundtruth_estimate0/data.csv", "mav0/cam0/data"),
        std::tuple("tum", "groundtruth.txt", "rgb")}) {
    DatasetArguments a = Arguments(format);
    Make(a);
    const fs::path before = a.out;
    a.source = before / truth;
    a.out = folder_ / (std::string(format) + "_again");
    EXPECT_EQ(Make(a).frames, 6u);
    for (const auto& image : fs::directory_iterator(before / images)) {
      const cv::Mat was = cv::imread(image.path().string(), cv::IMREAD_GRAYSCALE);
      const cv::Mat is =
          cv::imread((a.out / images / image.path().filename()).string(), cv::IMREAD_GRAYSCALE);
      ASSERT_EQ(was.size(), is.size()) << image.path();
      EXPECT_LE(cv::countNonZero(was != is), 3) << image.path();  // poses are as good as the last bit
    }
  }
}

TEST_F(Dataset, ManifestIsTheSameForAnyNumberOfJobs) {
  DatasetArguments a = Arguments("euroc");
  a.overrides.emplace_back("image.noise_grey=2");
  std::vector<std::string> manifests;
  for (const int jobs : {1, 3}) {
    a.jobs = jobs;
    a.out = folder_ / std::to_string(jobs);
    Make(a);
    manifests.push_back(Content(a.out / "manifest.json"));
  }
  EXPECT_EQ(manifests[0], manifests[1]);
  EXPECT_THAT(manifests[0], HasSubstr("\"mav0/boxes0/data.csv\""));
}

// What of a set fails while no file may be larger, as on a full disk.
std::string WithFilesUpTo(rlim_t bytes, const std::function<void()>& make) {
  signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = bytes;
  setrlimit(RLIMIT_FSIZE, &small);
  std::string error;
  try {
    make();
  } catch (const std::runtime_error& e) {
    error = e.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  return error;
}

TEST_F(Dataset, BrokenOffByAFullDiskItGoesOnToTheSameBytes) {
  DatasetArguments a = Arguments("euroc");
  Make(a);
  const std::string whole = Content(a.out / "manifest.json");
  a.out = folder_ / "broken";
  EXPECT_THAT(WithFilesUpTo(100, [&] { Make(a); }), HasSubstr("cannot write"));
  // Images fit, and their depth does not.
  EXPECT_THAT(WithFilesUpTo(12000, [&] { Make(a); }),
              AllOf(HasSubstr("cannot write"), HasSubstr("the same command goes on with it")));
  EXPECT_FALSE(fs::exists(a.out / "manifest.json"));
  EXPECT_EQ(Make(a).frames, 6u);
  EXPECT_EQ(Content(a.out / "manifest.json"), whole);
  EXPECT_FALSE(fs::exists(a.out / "journal.jsonl"));
}

TEST_F(Dataset, GoesOnFromWhatAJournalSays) {
  DatasetArguments a = Arguments("euroc");
  const DatasetPlan plan = LoadDatasetPlan(a);
  fs::create_directories(a.out);
  {
    Journal journal(a.out);
    journal.Write({0, 2, 0}, {{"mav0/cam0/data/1000200000000.png", "kept"}}, {});
    journal.Write({0, 3, 0}, {{"mav0/cam0/data/1000300000000.png", "lost"}}, {});
  }
  fs::remove(a.out / "mav0/cam0/data/1000300000000.png");
  std::ofstream(a.out / "journal.jsonl", std::ios::app) << "{\"sequence\":0,\"frame\":4,\"cam";  // cut off
  const DatasetResult result = MakeDataset(plan);
  EXPECT_EQ(result.found, 1u);
  EXPECT_EQ(Content(a.out / "mav0/cam0/data/1000200000000.png"), "kept");
  EXPECT_THAT(Content(a.out / "mav0/cam0/data/1000300000000.png"), StartsWith("\x89PNG"));
}

TEST_F(Dataset, ThatIsCompleteButForAFileIsMadeAnew) {
  DatasetArguments a = Arguments("euroc");
  Make(a);
  const std::string whole = Content(a.out / "manifest.json");
  const fs::path image = a.out / "mav0/cam0/data/1000200000000.png";
  const std::string bytes = Content(image);
  fs::remove(image);
  Make(a);
  EXPECT_EQ(Content(image), bytes);
  EXPECT_EQ(Content(a.out / "manifest.json"), whole);
}

TEST_F(Dataset, RefusesAllThatIsWrongAtOnce) {
  std::ofstream(folder_ / "way.yaml") << "way:\n"
                                         "  - {t_s: 0, position_m: [0, 0, 4]}\n"
                                         "  - {t_s: 1, position_m: [0, 0, -1]}\n"
                                         "  - {t_s: 2, position_m: [5000, 0, 4]}\n";
  DatasetArguments a = Arguments("kitti");
  a.overrides.back() = "camera=fisheye";
  a.overrides.emplace_back("image.auto_exposure.target_grey=100");
  try {
    LoadDatasetPlan(a);
    FAIL() << "it was taken";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("way.yaml:3: the aircraft, "));
    EXPECT_THAT(e.what(), HasSubstr("below the ground; valid: a height over 0 all along"));
    EXPECT_THAT(e.what(), HasSubstr("way.yaml:4: the aircraft, "));
    EXPECT_THAT(e.what(), HasSubstr("image.auto_exposure.target_grey"));
    EXPECT_THAT(e.what(), HasSubstr("cannot say a camera of the model kannala_brandt"));
  }
}

TEST_F(Dataset, OfOtherSettingsIsNotGoneOnWith) {
  DatasetArguments a = Arguments("euroc");
  Make(a);
  EXPECT_EQ(Make(a).found, 6u);  // complete
  a.frames = 3;
  try {
    LoadDatasetPlan(a);
    FAIL() << "it was taken";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("holds a data set of other settings"));
    EXPECT_THAT(e.what(), HasSubstr("'frames: 0' there, 'frames: 3' here"));
  }
}

// A flight with a stereo pair, written while it flies; its sequences are of the seeds.
TEST_F(Dataset, OfAMissionHasAllCamerasAndTheSameStamps) {
  DatasetArguments a = Arguments("euroc");
  a.source = "hover";
  a.overrides = {"world=plain",
                 "start.settle_s=0",
                 "start.height_m=4",
                 "criteria={}",
                 "image.rate_hz=10",
                 "cameras=[{name: right, camera: " + (folder_ / "camera.yaml").string() +
                     ", trigger: main, mount: {position_m: [0, 0.1, 0.05]}}]"};
  a.duration_s = 0.4;
  a.count = 2;
  std::vector<std::string> manifests;
  for (const int jobs : {1, 4}) {
    a.jobs = jobs;
    a.out = folder_ / std::to_string(jobs);
    Make(a);
    manifests.push_back(Content(a.out / "manifest.json"));
  }
  EXPECT_EQ(manifests[0], manifests[1]);
  for (const char* seed : {"1", "2"}) {
    const fs::path mav = a.out / seed / "mav0";
    const Rows left = Read(mav / "cam0/data.csv", ','), right = Read(mav / "cam1/data.csv", ',');
    EXPECT_GE(left.size(), 3u);
    EXPECT_EQ(Column(left, 0), Column(right, 0));
    EXPECT_THAT(Column(Read(mav / "imu0/data.csv", ','), 0), IsSupersetOf(Column(left, 0)));
    EXPECT_THAT(Column(Read(mav / "state_groundtruth_estimate0/data.csv", ','), 0),
                IsSupersetOf(Column(left, 0)));
    for (const auto& row : right)
      EXPECT_FALSE(cv::imread((mav / "cam1/data" / row[1]).string(), cv::IMREAD_UNCHANGED).empty());
  }
}

}  // namespace
}  // namespace kestrel::flight
