// SPDX-License-Identifier: Apache-2.0
#include "sim/contact_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "sim/world/mjcf.h"
#include "sim/world/scene.h"

namespace kestrel::sim {
namespace {

constexpr char kVehicle[] = R"(<body name="vehicle" pos="0 0 9"><freejoint name="vehicle"/>
  <geom type="box" size="0.3 0.2 0.1" mass="1"/>
  <body pos="0.4 0 -0.3"><geom type="sphere" size="0.05" mass="0.1" margin="0.02"/></body></body>)";
constexpr char kWorld[] = R"(<geom name="ground" type="plane" size="5 5 1"/>
  <geom type="box" pos="1 1 1" euler="10 20 30" size="0.6 0.8 0.4"/>
  <geom type="plane" pos="-4 0 0" euler="0 60 0" size="1 1 1" margin="0.1"/>
  <geom type="capsule" fromto="2 -2 0 2 -2 3" size="0.1"/>)";

class ContactSearchTest : public ::testing::Test {
 protected:
  void Make(const std::string& more = "") {
    model_ = CompileMjcf(
                 std::string("<mujoco><worldbody>") + kWorld + kVehicle + more + "</worldbody></mujoco>", {})
                 .model;
    ASSERT_TRUE(model_);
    data_ = MakeData(model_.get());
    mj_forward(model_.get(), data_.get());
  }
  bool Searches() const { return (model_->opt.disableflags & mjDSBL_CONTACT) == 0; }

  ModelPtr model_;
  DataPtr data_;
};

TEST_F(ContactSearchTest, NoContactIsMissedAnywhere) {
  Make();
  const ContactSearch search(model_.get(), data_.get());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-4, 4), turn(-1, 1);
  int touching = 0, searched = 0;
  for (int k = 0; k < 20'000; ++k) {
    for (int i = 0; i < 3; ++i) data_->qpos[i] = place(random) + (i == 2 ? 4 : 0);
    for (int i = 3; i < 7; ++i) data_->qpos[i] = turn(random);
    mju_normalize4(data_->qpos + 3);
    model_->opt.disableflags = 0;
    mj_fwdPosition(model_.get(), data_.get());
    search.Set(model_.get(), data_.get());
    touching += data_->ncon > 0;
    searched += Searches();
    ASSERT_TRUE(data_->ncon == 0 || Searches())
        << data_->qpos[0] << ' ' << data_->qpos[1] << ' ' << data_->qpos[2];
  }
  EXPECT_GT(touching, 1000);
  EXPECT_LT(searched, 15'000);
}

// From 9 m through the air onto the ground, past all that stands there.
TEST_F(ContactSearchTest, AFallAndItsBounceAreTheSameToTheLastBit) {
  const auto fall = [&](bool everywhere) {
    Make();
    const ContactSearch search(model_.get(), data_.get());
    data_->qvel[0] = 0.8;
    data_->qvel[4] = 3;
    std::vector<mjtNum> states;
    int without = 0, touched = 0;
    for (int k = 0; k < 1500; ++k) {
      if (!everywhere) search.Set(model_.get(), data_.get());
      without += !Searches();
      mj_step(model_.get(), data_.get());
      touched += data_->ncon > 0;
      states.insert(states.end(), data_->qpos, data_->qpos + model_->nq);
      states.insert(states.end(), data_->qvel, data_->qvel + model_->nv);
    }
    EXPECT_GT(touched, 50);
    EXPECT_EQ(without > 300, !everywhere) << without;
    return states;
  };
  EXPECT_EQ(fall(true), fall(false));
}

TEST_F(ContactSearchTest, WhereAnythingElseMovesItIsAlwaysOn) {
  for (const std::string other :
       {R"(<body pos="0 3 1"><freejoint/><geom size="0.1"/></body>)",
        R"(<body mocap="true"><geom size="0.1"/></body>)",
        R"(<body mocap="true"><body pos="0 0 1"><geom size="0.1"/></body></body>)"}) {
    Make(other);
    ContactSearch(model_.get(), data_.get()).Set(model_.get(), data_.get());
    EXPECT_TRUE(Searches()) << other;
  }
  Make(
      R"(<body mocap="true"><geom size="0.1" contype="0" conaffinity="0"/></body>)");  // which nothing touches
  ContactSearch(model_.get(), data_.get()).Set(model_.get(), data_.get());
  EXPECT_FALSE(Searches());
}

TEST_F(ContactSearchTest, AWorldWithoutContactsStaysOne) {
  Make();
  model_->opt.disableflags |= mjDSBL_CONTACT;
  const ContactSearch search(model_.get(), data_.get());
  data_->qpos[2] = 0.1;
  search.Set(model_.get(), data_.get());
  EXPECT_FALSE(Searches());
}

}  // namespace
}  // namespace kestrel::sim
