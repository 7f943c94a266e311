// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/recorded_images.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/temporary_folder.h"
#include "vision/capture/recorded/recorded_gyro.h"

namespace kestrel::vision {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

namespace fs = std::filesystem;

const std::vector<std::int64_t> kStamps = {1403636579763555584, 1403636579813555456, 1403636579863555584};

class RecordedImagesTest : public InTemporaryFolder {
 protected:
  // An image of its own grey level.
  static void WriteImage(const fs::path& file, int grey) {
    fs::create_directories(file.parent_path());
    cv::imwrite(file, cv::Mat(24, 32, CV_8UC1, cv::Scalar::all(grey)));
  }
  static void Write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  void WriteEuroc(const std::string& camera, int grey) const {
    const fs::path in = folder_ / "mav0" / camera;
    std::string table = "#timestamp [ns],filename\r\n";
    for (const std::int64_t stamp : kStamps) {
      WriteImage(in / "data" / (std::to_string(stamp) + ".png"), grey++);
      table += std::to_string(stamp) + "," + std::to_string(stamp) + ".png\r\n";
    }
    Write(in / "data.csv", table);
  }

  static RecordedImages Opened(const fs::path& recording, const std::string& topic = "") {
    Mistakes mistakes;
    RecordedImages recorded = OpenRecordedImages(recording, topic, mistakes);
    EXPECT_TRUE(mistakes.empty()) << InputError(mistakes.all()).what();
    return recorded;
  }
  static std::string Refusal(const fs::path& recording, const std::string& topic = "") {
    Mistakes mistakes;
    EXPECT_EQ(OpenRecordedImages(recording, topic, mistakes).size(), 0u);
    return mistakes.empty() ? "accepted" : InputError(mistakes.all()).what();
  }
  static std::vector<int> Greys(const RecordedImages& recorded) {
    const RecordedImages::Reader read = recorded.reader();
    std::vector<int> greys;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      const ImageFile image = read(i, ImageColours::kGrey);
      greys.push_back(image.pixels.empty() ? -1 : image.pixels.at<std::uint8_t>(3, 3));
    }
    return greys;
  }
};

TEST_F(RecordedImagesTest, EurocIsReadByItsTableWithTheStampsOfEachCamera) {
  WriteEuroc("cam0", 10), WriteEuroc("cam1", 20);
  Write(folder_ / "mav0/cam1/sensor.yaml", "sensor_type: camera\n");
  Write(folder_ / "mav0/imu0/data.csv", "#timestamp [ns]\n");
  for (const auto& recording : {folder_, folder_ / "mav0"}) {
    const RecordedImages first = Opened(recording);
    EXPECT_EQ(first.topic, "cam0");
    EXPECT_EQ(first.stamps_ns, kStamps);
    EXPECT_THAT(Greys(first), ElementsAre(10, 11, 12));
    EXPECT_TRUE(first.calibration.empty());
    EXPECT_THAT(Greys(Opened(recording, "cam1")), ElementsAre(20, 21, 22));
  }
  const RecordedImages second = Opened(folder_ / "mav0/cam1/");
  EXPECT_THAT(Greys(second), ElementsAre(20, 21, 22));
  EXPECT_EQ(second.calibration.filename(), "sensor.yaml");
  EXPECT_EQ(second.gyro.filename(), "data.csv");
  EXPECT_DOUBLE_EQ(second.Time_s(1), 0.049999872);
  EXPECT_DOUBLE_EQ(second.Rate_hz(), 20);
  EXPECT_THAT(Refusal(folder_, "cam2"), AllOf(HasSubstr("cam2"), HasSubstr("valid: cam0, cam1")));
}

TEST_F(RecordedImagesTest, EveryMistakeOfATableIsToldWithItsLine) {
  WriteEuroc("cam0", 10);
  const std::string good = std::to_string(kStamps[0]) + "," + std::to_string(kStamps[0]) + ".png\n";
  Write(folder_ / "mav0/cam0/data.csv",
        "#timestamp [ns],filename\n" + good + good + "7," + std::to_string(kStamps[0]) + ".png\n1.5,a.png\n" +
            std::to_string(kStamps[1]) + "\n" + std::to_string(kStamps[2]) + ",lost.png\n");
  const std::string refused = Refusal(folder_);
  EXPECT_THAT(
      refused,
      AllOf(HasSubstr("data.csv:3: the stamp 1403636579763555584 comes twice"),
            HasSubstr("data.csv:4: the stamp 7 goes back"), HasSubstr("data.csv:5: '1.5' is no stamp"),
            HasSubstr("data.csv:6: "), HasSubstr("has 1 cell"), HasSubstr("data.csv:7: its image is missing"),
            HasSubstr("lost.png'; valid: an image that is there"), Not(HasSubstr("data.csv:2:"))));
}

TEST_F(RecordedImagesTest, ALongTableOfMistakesIsCounted) {
  std::string table;
  for (int i = 0; i < 50; ++i) table += "x,y\n";
  Write(folder_ / "cam0/data.csv", table);
  EXPECT_THAT(Refusal(folder_), AllOf(HasSubstr(":20:"), Not(HasSubstr(":21:")), HasSubstr("and 30 more")));
}

TEST_F(RecordedImagesTest, TumIsReadByRgbTxt) {
  WriteImage(folder_ / "rgb/a.png", 1), WriteImage(folder_ / "rgb/b.png", 2);
  Write(folder_ / "rgb.txt",
        "# color images\n# timestamp filename\n1305031102.175304 rgb/b.png\n"
        "1305031102.211214 rgb/a.png\n");
  const RecordedImages recorded = Opened(folder_);
  EXPECT_THAT(recorded.stamps_ns, ElementsAre(1305031102175304000, 1305031102211214000));
  EXPECT_THAT(Greys(recorded), ElementsAre(2, 1));
}

TEST_F(RecordedImagesTest, KittiIsReadByTimesTxtOfTheFolderOrBesideIt) {
  WriteImage(folder_ / "image_0/000000.png", 1), WriteImage(folder_ / "image_0/000001.png", 2);
  WriteImage(folder_ / "image_1/000000.png", 3), WriteImage(folder_ / "image_1/000001.png", 4);
  Write(folder_ / "times.txt", "0.000000e+00\n1.036224e-01\n");
  EXPECT_THAT(Greys(Opened(folder_, "image_1")), ElementsAre(3, 4));
  const RecordedImages recorded = Opened(folder_ / "image_0");
  EXPECT_THAT(Greys(recorded), ElementsAre(1, 2));
  EXPECT_THAT(recorded.stamps_ns, ElementsAre(0, 103622400));
  EXPECT_THAT(Refusal(folder_), AllOf(HasSubstr("several cameras"), HasSubstr("image_0, image_1")));
  Write(folder_ / "times.txt", "0.000000e+00\n");
  EXPECT_THAT(Refusal(folder_ / "image_0"), HasSubstr("1 stamps for 2 images"));
}

TEST_F(RecordedImagesTest, NamesThatAreStampsAreOnesAndNumbersAreNot) {
  WriteImage(folder_ / "ns/1403636579763555584.png", 1),
      WriteImage(folder_ / "ns/1403636579813555456.png", 2);
  WriteImage(folder_ / "s/9.500000.png", 1), WriteImage(folder_ / "s/10.250000.png", 2);
  WriteImage(folder_ / "numbers/2.png", 1), WriteImage(folder_ / "numbers/10.png", 2);
  EXPECT_THAT(Opened(folder_ / "ns").stamps_ns, ElementsAre(kStamps[0], kStamps[1]));
  EXPECT_THAT(Opened(folder_ / "s").stamps_ns, ElementsAre(9500000000, 10250000000));
  EXPECT_FALSE(Opened(folder_ / "numbers").stamped());
  for (const char* each : {"ns", "s", "numbers"})
    EXPECT_THAT(Greys(Opened(folder_ / each)), ElementsAre(1, 2));
  WriteImage(folder_ / "ns/view.png", 3);
  EXPECT_THAT(Refusal(folder_ / "ns"), HasSubstr("view.png"));
  WriteImage(folder_ / "s/9.5000.png", 3);
  EXPECT_THAT(Refusal(folder_ / "s"), HasSubstr("comes twice"));
}

TEST_F(RecordedImagesTest, AFolderWithoutImagesIsRefused) {
  EXPECT_THAT(Refusal(folder_), HasSubstr("no images"));
  EXPECT_THAT(Refusal(folder_ / "nowhere"), HasSubstr("no images"));
  WriteImage(folder_ / "one/1.png", 1);
  EXPECT_THAT(Refusal(folder_ / "one", "cam0"), HasSubstr("one camera only"));
}

// What is cut within an image is met when that is read, and the others are given.
TEST_F(RecordedImagesTest, ATruncatedImageIsAnImageThatCannotBeRead) {
  WriteEuroc("cam0", 10);
  const fs::path file = folder_ / "mav0/cam0/data" / (std::to_string(kStamps[1]) + ".png");
  fs::resize_file(file, fs::file_size(file) / 2);
  const RecordedImages recorded = Opened(folder_);
  EXPECT_THAT(Greys(recorded), ElementsAre(10, -1, 12));
  EXPECT_THAT(recorded.reader()(1, ImageColours::kGrey).error, HasSubstr("damaged"));
}

TEST_F(RecordedImagesTest, AnImuOfEurocIsReadToTheBit) {
  const fs::path file = folder_ / "data.csv";
  Write(file,
        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
        "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
        "1403636579758555392,-0.099134701513277898,0.14730578886832138,0.02722713633111154,8.1,-0.3,-2.4\n"
        "1403636579763555584,-0.1,0.2,0.3,8.1,-0.3,-2.4\n");
  ASSERT_TRUE(IsRecordedGyro(file));
  Mistakes mistakes;
  const std::vector<RecordedRate> rates = ReadRecordedGyro(file, "", mistakes);
  ASSERT_TRUE(mistakes.empty());
  ASSERT_EQ(rates.size(), 2u);
  EXPECT_EQ(rates[0].stamp_ns, 1403636579758555392);
  EXPECT_EQ(rates[0].w_I, Eigen::Vector3d(-0.099134701513277898, 0.14730578886832138, 0.02722713633111154));
  Write(file, "#timestamp [ns],w [rad s^-1]\n5,1,2,3\n5,1,2,3\n6,1,nan,3\n7,1\n");
  EXPECT_TRUE(ReadRecordedGyro(file, "", mistakes).empty());
  EXPECT_THAT(InputError(mistakes.all()).what(), AllOf(HasSubstr(":3: the stamp 5 comes twice"),
                                                       HasSubstr(":4: 'nan' is no rate"), HasSubstr(":5: ")));
}

}  // namespace
}  // namespace kestrel::vision
