// SPDX-License-Identifier: Apache-2.0
#include "records/page/flight_page.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/html/html.h"
#include "records/page/flight_data.h"
#include "records/page/flight_json.h"
#include "records/page/page_media.h"
#include "records/summary.h"
#include "tests/support/temporary_folder.h"
#include "vision/camera/camera_model.h"

namespace kestrel::records {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kMarkup = "</script><img src=x onerror=alert(1)>&\"'";

void Write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

FlightSubject Subject() {
  FlightSubject s;
  s.scenario = s.title = "landing";
  s.mode = "SIMULATOR";
  s.mission = "landing";
  s.wanted = "It lands.";
  s.again = "kestrel run landing";
  s.version = "0.1.0 abc";
  s.seed = 18446744073709551615u;
  s.rate_hz = 20;
  s.camera = FlightSubject::Camera{"thesis_6mm", "pinhole", 640, 480, 43.1, 33, {}};
  s.camera->X.R = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
  s.camera->X.p = {0, 0, 0.05};
  s.ground_camera = FlightSubject::Camera{"ground_6mm", "pinhole", 1280, 960, 55, 43, {}};
  s.ground_camera->X.p = {-15, 0, -2};
  s.pad = FlightSubject::Pad{{1.19, 0.91}, Pose{}, "data:image/png;base64,AAAA"};
  return s;
}

// Of ISO/IEC 14496-12, and glTF 2.0 without chunks.
std::string Box(const std::string& type, const std::string& content) {
  return std::string{0, 0, 0, static_cast<char>(8 + content.size())} + type + content;
}
const std::string kMp4 = Box("ftyp", "isom") + Box("moov", "") + Box("mdat", "pictures");
const std::string kGlb = std::string("glTF\2\0\0\0\x10\0\0\0", 12) + "four";

class FlightPageTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    WriteSubject(folder_, Subject());
    Write(folder_ / "telemetry.csv", "t_s,phase,x_m\n0.05,up,1\n0.1,down,2\n");
    Write(folder_ / "events.log", "    0.050 s  phase: up\n    0.100 s  end: landed: well\n");
    Summary summary;
    summary.scenario = "landing";
    summary.complete = summary.passed = true;
    summary.outcome = "landed";
    summary.criteria = {{"rest_error_m", 0.1 + 0.2, 0.5, false, true},
                        {"touchdown_s", std::numeric_limits<double>::quiet_NaN(), 9, false, false}};
    summary.metrics = {{"rest_error_m", 0.1 + 0.2}};
    summary.sim_s = 16;
    WriteFile(folder_ / "summary.json", ToJson(summary));
  }
  Json Data() const { return Json::parse(FlightData(folder_)); }
  std::string Refusal() const {
    try {
      FlightData(folder_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "none";
  }
};

TEST_F(FlightPageTest, HasOfAFlightWhatItsFolderHolds) {
  const Json data = Data();
  EXPECT_EQ(data["seed"], 18446744073709551615u);
  EXPECT_EQ(data["wanted"], "It lands.");
  EXPECT_EQ(data["again"], "kestrel run landing");
  EXPECT_EQ(data["criteria"][0]["value"].get<double>(), 0.1 + 0.2);
  EXPECT_TRUE(data["criteria"][1]["value"].is_null());
  EXPECT_EQ(data["sim_s"], 16);
  EXPECT_EQ(data["events"][1], (Json{{"t_s", 0.1}, {"what", "end"}, {"is", "landed: well"}}));
  EXPECT_EQ(data["columns"]["x_m"], Json::array({1, 2}));
  EXPECT_EQ(data["columns"]["phase"]["words"], Json::array({"up", "down"}));
  EXPECT_EQ(data["camera"]["fov_deg"], Json::array({43.1, 33.0}));
  EXPECT_EQ(data["ground_camera"]["X_TC"]["p"], Json::array({-15, 0, -2}));
  EXPECT_EQ(data["pad"]["X_NT"]["q"], Json::array({1, 0, 0, 0}));
  EXPECT_EQ(data["live"], false);
  EXPECT_EQ(data["changeable"], Json::array());
}

// As a crash or a cut of power leaves it.
TEST_F(FlightPageTest, OfAFlightThatWasBrokenOffThereIsWhatWasWritten) {
  fs::remove(folder_ / "summary.json");
  fs::rename(folder_ / "telemetry.csv", folder_ / "telemetry.csv.part");
  fs::rename(folder_ / "events.log", folder_ / "events.log.part");
  std::ofstream(folder_ / "telemetry.csv.part", std::ios::app) << "0.15,do";
  std::ofstream(folder_ / "events.log.part", std::ios::app) << "    0.1";
  const Json data = Data();
  EXPECT_EQ(data["complete"], false);
  EXPECT_EQ(data["passed"], false);
  EXPECT_THAT(data["error"].get<std::string>(), HasSubstr("summary.json"));
  EXPECT_EQ(data["scenario"], "landing");
  EXPECT_EQ(data["columns"]["t_s"].size(), 2u);
  EXPECT_EQ(data["events"].size(), 2u);
  EXPECT_THAT(FlightPage(folder_), HasSubstr("</html>"));
}

TEST_F(FlightPageTest, OfAFolderOfAnOlderVersionThereIsWhatItHas) {
  fs::remove(folder_ / "page.json");
  fs::remove(folder_ / "events.log");
  const Json data = Data();
  EXPECT_EQ(data["title"], "landing");
  EXPECT_TRUE(data["camera"].is_null());
  EXPECT_TRUE(data["pad"].is_null());
  EXPECT_EQ(data["again"], "");
  EXPECT_NEAR(data["rate_hz"].get<double>(), 20, 1e-9);
  EXPECT_EQ(data["events"], Json::array());
}

TEST_F(FlightPageTest, WhatIsNoFlightOrDamagedIsRefusedWithItsFile) {
  Write(folder_ / "telemetry.csv", "t_s,x_m\n1\n");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("telemetry.csv"), HasSubstr("row 2 has 1 cells")));
  Write(folder_ / "summary.json", R"({"scenario": "lan)");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("summary.json"), HasSubstr("not a summary")));
  Write(folder_ / "page.json", "[]");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("page.json"), HasSubstr("not of a flight")));
  fs::remove(folder_ / "page.json");
  fs::remove(folder_ / "summary.json");
  EXPECT_THAT(Refusal(), HasSubstr("no folder of a flight"));
}

// The folder may come from anybody: its picture is a picture, and nothing that is fetched.
TEST_F(FlightPageTest, APictureThatIsNoneIsRefused) {
  FlightSubject subject = Subject();
  subject.pad->picture = "https://example.org/spy.png";
  WriteSubject(folder_, subject);
  EXPECT_THAT(Refusal(), HasSubstr("no data:image/"));
}

TEST_F(FlightPageTest, NamesWithMarkupAreText) {
  FlightSubject subject = Subject();
  subject.title = subject.scenario = subject.wanted = subject.again = kMarkup;
  WriteSubject(folder_, subject);
  Write(folder_ / "telemetry.csv", "t_s,phase\n0,</script><b>\n");
  Write(folder_ / "events.log", std::string("    0.000 s  phase: ") + kMarkup + "\n");
  const std::string page = FlightPage(folder_);
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<img src=x")), Not(HasSubstr("</script><b>"))));
  EXPECT_THAT(page, HasSubstr("<title>&lt;/script&gt;&lt;img"));
  const std::string begin = "<script type=\"application/json\" id=\"data\">";
  const std::size_t at = page.find(begin) + begin.size();
  const Json flight = Json::parse(page.substr(at, page.find("</script>", at) - at))["flights"][0];
  EXPECT_EQ(flight["wanted"], kMarkup);
  EXPECT_EQ(flight["events"][0]["is"], kMarkup);
  EXPECT_EQ(flight["columns"]["phase"]["words"][0], "</script><b>");
}

TEST_F(FlightPageTest, HoldsItsMediaAndThoseOfASecondFlight) {
  Write(folder_ / "video.mp4", kMp4);
  Write(folder_ / "scene.glb", kGlb);
  const fs::path other = folder_ / "other";
  fs::create_directory(other);
  WriteSubject(other, Subject());
  Write(other / "view.mp4", kMp4);
  const std::string one = FlightPage(folder_), both = FlightPage(folder_, other);
  const auto element = [](const std::string& id, const std::string& bytes) {
    return "<script type=\"text/plain\" id=\"" + id + "\">" + Base64(bytes) + "</script>";
  };
  EXPECT_THAT(one, AllOf(HasSubstr(element("video", kMp4)), HasSubstr(element("scene", kGlb))));
  EXPECT_THAT(one, AllOf(Not(HasSubstr("<script type=\"text/plain\" id=\"view\">")),
                         Not(HasSubstr("<script type=\"text/plain\" id=\"view-b\">"))));
  EXPECT_THAT(both, AllOf(HasSubstr(element("video", kMp4)), HasSubstr(element("view-b", kMp4))));
  EXPECT_EQ(one, FlightPage(folder_));
}

TEST_F(FlightPageTest, LeavesOutWhatCannotBeShownAndSaysSo) {
  Write(folder_ / "video.mp4", "");
  fs::resize_file(folder_ / "video.mp4", (std::uintmax_t{64} << 20) + 1);
  EXPECT_THAT(LeftOutOfPage(folder_), ElementsAre("video.mp4 is too large for a page"));
  EXPECT_EQ(Data()["left_out"], Json::array({"video.mp4 is too large for a page"}));
  EXPECT_THAT(FlightPage(folder_), Not(HasSubstr("<script type=\"text/plain\" id=\"video\">")));

  Write(folder_ / "video.mp4", "a text");
  Write(folder_ / "view.mp4", kMp4.substr(0, kMp4.size() - 1));
  Write(folder_ / "scene.glb", kGlb.substr(0, kGlb.size() - 1));
  fs::remove(folder_ / "telemetry.csv");
  EXPECT_THAT(LeftOutOfPage(folder_),
              ElementsAre("video.mp4 is no MP4", "view.mp4 is cut off", "scene.glb is cut off",
                          "telemetry.csv is missing, and so are all plots and paths"));
  for (const char* id : {"video", "view", "scene"})
    EXPECT_THAT(FlightPage(folder_),
                Not(HasSubstr("<script type=\"text/plain\" id=\"" + std::string(id) + "\">")));
}

TEST_F(FlightPageTest, AVideoIsShownWhereItsIndexIsThereAndAllBoxesAreWhole) {
  const std::string last = {0, 0, 0, 0};
  for (const auto& [bytes, wrong] : std::vector<std::pair<std::string, std::string>>{
           {kMp4, ""},
           {Box("ftyp", "") + Box("moov", "") + last + "mdat and all that follows", ""},
           {Box("ftyp", "") + Box("moov", "") + std::string{0, 0, 0, 1} + "mdat" +
                std::string{0, 0, 0, 0, 0, 0, 0, 17} + "x",
            ""},
           {Box("ftyp", "isom") + Box("mdat", "pictures"), "is cut off"},
           {kMp4 + "half", "is cut off"},
           {Box("ftyp", "") + std::string{0, 0, 0, 1} + "mdat" + std::string(8, '\xff'), "is cut off"},
           {Box("ftyp", "") + std::string{0, 0, 0, 7} + "moov", "is damaged"}}) {
    Write(folder_ / "video.mp4", bytes);
    const auto left_out = LeftOutOfPage(folder_);
    EXPECT_EQ(left_out.empty() ? "" : left_out[0], wrong.empty() ? "" : "video.mp4 " + wrong) << bytes;
  }
}

TEST_F(FlightPageTest, OfAFlightThatGoesOnThereIsNoOutcomeYet) {
  FlightSubject subject = Subject();
  subject.changeable = {{"wind.mean_m_s", "mean wind", "3.5", 0, 12, {}},
                        {"light", "", "\"dusk\"", {}, {}, {"\"dusk\""}}};
  const Json live = Json::parse(LiveJson(subject).dump());
  EXPECT_EQ(live["live"], true);
  EXPECT_EQ(live["columns"], Json::object());
  EXPECT_EQ(live["changeable"][0]["value"], 3.5);
  EXPECT_TRUE(live["changeable"][1]["min"].is_null());
  EXPECT_EQ(live["changeable"][1]["choices"][0], "dusk");
  EXPECT_THAT(LiveFlightPage(subject, "a scene"), HasSubstr("id=\"scene\">" + Base64("a scene")));
}

TEST_F(FlightPageTest, WhatAFlightIsComesBackFromItsFile) {
  EXPECT_EQ(SubjectJson(ReadSubject(folder_)), SubjectJson(Subject()));
  FlightSubject bare;
  bare.pad = FlightSubject::Pad{{1, 2}, {}, ""};
  WriteSubject(folder_, bare);
  EXPECT_EQ(SubjectJson(ReadSubject(folder_)), SubjectJson(bare));
}

// By what a pinhole is: half of the image's width over the focal length is the tangent of half the angle.
TEST(FlightSubject, AngleOfViewIsThatBetweenTheRimsOfTheImage) {
  vision::Pinhole pinhole;
  pinhole.width_px = 640, pinhole.height_px = 480;
  pinhole.fx = 500, pinhole.fy = 400;
  pinhole.cx = 319.5, pinhole.cy = 239.5;
  const FlightSubject::Camera camera = CameraOf("mine", pinhole, {});
  EXPECT_NEAR(camera.h_deg, 2 * std::atan(320.0 / 500) * 180 / std::numbers::pi, 1e-9);
  EXPECT_NEAR(camera.v_deg, 2 * std::atan(240.0 / 400) * 180 / std::numbers::pi, 1e-9);
  EXPECT_EQ(camera.projection, "pinhole");
}

}  // namespace
}  // namespace kestrel::records
