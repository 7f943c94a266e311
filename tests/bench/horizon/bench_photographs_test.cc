// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/bench_photographs.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::bench {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class PhotographsTest : public InTemporaryFolder {
 protected:
  std::string Refusal(const std::filesystem::path& folder) const {
    Mistakes mistakes;
    ReadPhotographs(folder, mistakes);
    try {
      mistakes.ThrowIfAny();
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }
};

TEST_F(PhotographsTest, AreReadByTheirNamesWithTheLabelsThatTheyHave) {
  for (const char* name : {"b.2_10.jpg", "a_0.png", "other.txt"}) std::ofstream(folder_ / name) << "x";
  std::ofstream(folder_ / "label.csv") << "filename,slope,offset\r\nb.2_10.jpg,-0.5,0.25\r\n";
  Mistakes mistakes;
  const auto photographs = ReadPhotographs(folder_, mistakes);
  mistakes.ThrowIfAny();
  ASSERT_EQ(photographs.size(), 2u);
  EXPECT_EQ(photographs[0].flight, "a");
  EXPECT_FALSE(photographs[0].labelled);
  EXPECT_EQ(photographs[1].flight, "b.2");
  EXPECT_TRUE(photographs[1].labelled);
  EXPECT_EQ(photographs[1].slope, -0.5);
  EXPECT_EQ(photographs[1].offset, 0.25);
}

TEST_F(PhotographsTest, EveryMistakeIsToldAtOnce) {
  EXPECT_THAT(Refusal(folder_ / "none"), HasSubstr("no such folder"));
  std::ofstream(folder_ / "label.csv") << "filename,slope,offset\na.jpg,steep,0.1\nb.jpg\nc.jpg,0.1,0.2\n";
  EXPECT_THAT(Refusal(folder_), AllOf(HasSubstr("line 2"), HasSubstr("line 3"), HasSubstr("no photograph")));
}

TEST_F(PhotographsTest, LabelsOfNoPhotographAndSecondOnesAreRefused) {
  for (const char* name : {"a_0.png", "a_1.png"}) std::ofstream(folder_ / name) << "x";
  std::ofstream(folder_ / "label.csv")
      << "filename,slope,offset\na_0.png,0,0.5\na_9.png,0,0.5\na_0.png,none,none\n";
  EXPECT_THAT(Refusal(folder_), AllOf(HasSubstr("line 3: 'a_9.png' is not in the folder"),
                                      HasSubstr("line 4: 'a_0.png' has a label already")));
}

TEST_F(PhotographsTest, AnAnswerWhereNoHorizonIsInViewIsCounted) {
  cv::Mat level(300, 400, CV_8UC3, cv::Scalar(230, 200, 175)), noise(300, 400, CV_8UC3);
  level.rowRange(150, 300).setTo(cv::Scalar(60, 95, 80));
  cv::RNG(5).fill(noise, cv::RNG::NORMAL, 10, 3);
  for (const char* name : {"f_1.png", "f_2.png"}) cv::imwrite((folder_ / name).string(), level + noise);
  cv::imwrite((folder_ / "f_3.png").string(), cv::Mat::zeros(300, 400, CV_8UC3));
  std::ofstream(folder_ / "label.csv")
      << "filename,slope,offset\nf_1.png,0,0.4983\nf_2.png,none,none\nf_3.png,none,none\n";
  Mistakes mistakes;
  const auto photographs = ReadPhotographs(folder_, mistakes);
  mistakes.ThrowIfAny();
  EXPECT_FALSE(photographs[0].none);
  EXPECT_TRUE(photographs[1].labelled && photographs[1].none);
  std::vector<records::Figure> table;
  BenchPhotographs(photographs, 60, folder_ / "out", table);
  const auto figure = [&](const std::string& name) {
    for (const auto& row : table)
      if (row.name == "photographs, " + name) return row.value;
    return -1.0;
  };
  EXPECT_EQ(figure("answered"), 1);
  EXPECT_EQ(figure("answered though no horizon is in view"), 1);
  EXPECT_EQ(figure("answers off by more than 10 degrees"), 0);  // of those with a horizon
}

TEST_F(PhotographsTest, AreAnsweredOrCountedByTheirReasons) {
  // A label that lies 3 degrees below the level horizon that is painted.
  cv::Mat level(300, 400, CV_8UC3, cv::Scalar(230, 200, 175)), noise(300, 400, CV_8UC3);
  level.rowRange(150, 300).setTo(cv::Scalar(60, 95, 80));
  cv::RNG(5).fill(noise, cv::RNG::NORMAL, 10, 3);
  cv::imwrite((folder_ / "f_1.png").string(), level + noise);
  cv::imwrite((folder_ / "f_2.png").string(), cv::Mat::zeros(300, 400, CV_8UC3));
  const double f = 200 / std::tan(M_PI / 6);
  std::ofstream(folder_ / "label.csv")
      << "filename,slope,offset\nf_1.png,0," << (149.5 + f * std::tan(3 * M_PI / 180)) / 300 << "\n";
  Mistakes mistakes;
  std::vector<records::Figure> table;
  BenchPhotographs(ReadPhotographs(folder_, mistakes), 60, folder_ / "out", table);
  const auto figure = [&](const std::string& name) {
    for (const auto& row : table)
      if (row.name == "photographs, " + name) return row.value;
    return -1.0;
  };
  EXPECT_EQ(figure("answered"), 0.5);
  EXPECT_NEAR(figure("error, median"), 3, 0.3);
  EXPECT_EQ(figure("answers off by more than 5 degrees"), 0);
  std::ifstream csv(folder_ / "out" / "photographs.csv");
  const std::string text((std::istreambuf_iterator<char>(csv)), {});
  EXPECT_THAT(text, HasSubstr("too_dark"));
}

}  // namespace
}  // namespace kestrel::bench
