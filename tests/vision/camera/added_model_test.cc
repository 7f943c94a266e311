// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/added_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A pinhole by another name, so that there is something to compare with.
struct Camera : Pinhole {
  static constexpr const char* kName = "of_a_user";
};

class AddedModelTest : public InTemporaryFolder {
 protected:
  static void SetUpTestSuite() { AddCameraModel<Camera>(); }
  std::filesystem::path Write(const std::string& text) const {
    std::ofstream(folder_ / "camera.yaml") << text;
    return folder_ / "camera.yaml";
  }
};

constexpr const char* kNumbers =
    "width_px: 640\nheight_px: 480\nfx_px: 500\nfy_px: 510\ncx_px: 320\ncy_px: 240\n";

TEST_F(AddedModelTest, IsReadByItsNameAndSeesAsItself) {
  Mistakes mistakes;
  const CameraModel added = LoadCamera(Write(std::string("model: of_a_user\n") + kNumbers), mistakes);
  const CameraModel pinhole = LoadCamera(Write(kNumbers), mistakes);
  ASSERT_THAT(mistakes.Texts(), IsEmpty());
  EXPECT_STREQ(NameOf(added), "of_a_user");
  EXPECT_EQ(WidthPx(added), 640);
  EXPECT_EQ(HeightPx(added), 480);
  EXPECT_EQ(MaxAngle(added), MaxAngle(pinhole));
  EXPECT_EQ(ParameterNames(added), ParameterNames(pinhole));
  const Eigen::Vector3d p_CQ(0.3, -0.2, 2);
  Eigen::Matrix<double, 2, 3> d_added, d_pinhole;
  EXPECT_EQ(Project(added, p_CQ, &d_added), Project(pinhole, p_CQ, &d_pinhole));
  EXPECT_EQ(d_added, d_pinhole);
  EXPECT_EQ(Ray(added, {10, 20}), Ray(pinhole, {10, 20}));
}

TEST_F(AddedModelTest, IsAValue) {
  Mistakes mistakes;
  const CameraModel before = LoadCamera(Write(std::string("model: of_a_user\n") + kNumbers), mistakes);
  CameraModel after = before;
  SetParameters(after, Eigen::Vector4d(600, 610, 300, 200));
  EXPECT_EQ(Parameters(before), Eigen::Vector4d(500, 510, 320, 240));
  EXPECT_EQ(Parameters(after), Eigen::Vector4d(600, 610, 300, 200));
  EXPECT_EQ(std::get<AddedModel>(after).cx, 300);
}

TEST_F(AddedModelTest, IsWrittenAndReadBack) {
  Mistakes mistakes;
  const CameraModel camera = LoadCamera(Write(std::string("model: of_a_user\n") + kNumbers), mistakes);
  const std::string text = ToCameraYaml(camera);
  EXPECT_THAT(text, HasSubstr("model: of_a_user\n"));
  EXPECT_EQ(Parameters(LoadCamera(Write(text), mistakes)), Parameters(camera));
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  EXPECT_THROW(ToKalibr(camera), InputError);
}

TEST_F(AddedModelTest, TwoOfOneNameAreRefused) {
  EXPECT_THROW(AddCameraModel<Camera>(), std::logic_error);
  EXPECT_THROW(AddCameraModel<Pinhole>(), std::logic_error);
}

TEST_F(AddedModelTest, AModelThatIsNoneIsAnsweredWithAllNames) {
  Mistakes mistakes;
  LoadCamera(Write(std::string("model: of_another\n") + kNumbers), mistakes);
  EXPECT_THAT(mistakes.Texts(), ElementsAre(HasSubstr("of_a_user")));
}

}  // namespace
}  // namespace kestrel::vision
