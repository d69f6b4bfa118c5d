#include "runtime/engine/worker/come_to_rest.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

constexpr int kClearingTime = 10;
constexpr worker::Falling kFalling = {
    .objects = {}, .diameter = 1, .least_half_extent = 0.5, .gravity = 9.8};

/// Three cubes above a floor.
class ComeToRest : public testing::Test {
 protected:
  ComeToRest() {
    scene_ = EngineScene(3, 10);
    SetWorld(scene_, "timestep", kFalling.Timestep(1.02));
    SetWorld(scene_, "world.walls", Word("floor"));
    SetWorld(scene_, "sleeping", false);
    SetGroup(scene_, "type", Word("cuboid"));
    SetGroup(scene_, "size", 1.0);
    SeedStreams(scene_);
    engine_ = std::make_unique<world::Engine>(scene_, layouts::MakeInitialState(scene_),
                                              omissions::KeepEverything(scene_));
  }

  /// Lets them come to rest; they are clear when asked for the `clear_at`th time.
  bool Rest(int clear_at) {
    worker::Falling falling = kFalling;
    falling.objects = {0, 1, 2};
    return worker::ComeToRest(
        *engine_, falling, {3, {0.9, 1e-3}}, kClearingTime,
        [this](std::size_t at_rest) { at_rest_ = at_rest; },
        [&] {
          EXPECT_EQ(at_rest_, 3u);
          return ++asked_ == clear_at;
        });
  }

  plan::Scene scene_;
  std::unique_ptr<world::Engine> engine_;
  std::size_t at_rest_ = 0;
  int asked_ = 0;
};

TEST_F(ComeToRest, ClearObjectsAreAskedForOnce) {
  EXPECT_TRUE(Rest(1));
  EXPECT_EQ(asked_, 1);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(Position(*engine_, i).y(), -4.5, 0.01);
}

TEST_F(ComeToRest, GoesOnUntilTheyAreClear) {
  EXPECT_TRUE(Rest(5));
  EXPECT_EQ(asked_, 5);
}

TEST_F(ComeToRest, GivesUpIfTheyDoNotComeClear) {
  EXPECT_FALSE(Rest(0));
  EXPECT_EQ(asked_, kClearingTime + 1);
}

}  // namespace
}  // namespace cdb::tests
