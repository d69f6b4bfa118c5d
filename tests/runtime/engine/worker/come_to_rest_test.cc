#include "runtime/engine/worker/come_to_rest.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {
namespace {

constexpr worker::Falling kFalling = {
    .objects = {}, .diameter = 1, .least_half_extent = 0.5, .gravity = 9.8};

/// Three cubes above a floor.
class ComeToRest : public testing::Test {
 protected:
  ComeToRest() {
    scene_ = EngineScene(3, 10);
    SetWorld(scene_, "timestep", kFalling.Timestep());
    SetWorld(scene_, "world.walls", Word("floor"));
    SetWorld(scene_, "sleeping", false);
    SetGroup(scene_, "type", Word("cuboid"));
    SetGroup(scene_, "size", 1.0);
    SeedStreams(scene_);
    engine_ = std::make_unique<world::Engine>(scene_, layouts::MakeInitialState(scene_),
                                              omissions::KeepEverything(scene_));
    falling_.objects = {0, 1, 2};
  }

  plan::Scene scene_;
  std::unique_ptr<world::Engine> engine_;
  worker::Falling falling_ = kFalling;
};

TEST_F(ComeToRest, TheyFallAndLie) {
  std::size_t at_rest = 0;
  worker::FallDown(*engine_, falling_, {3, {0.9, 1e-3}},
                   [&](std::size_t count) { at_rest = count; });
  EXPECT_EQ(at_rest, 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(Position(*engine_, i).y(), -4.5, 0.01);
}

TEST_F(ComeToRest, TheRefereeCountsThoseThatMove) {
  EXPECT_EQ(worker::WatchUnrest(*engine_, falling_).moved.size(), 3u) << "they fall";
  Steps(*engine_, 300);
  const worker::Unrest unrest = worker::WatchUnrest(*engine_, falling_);
  EXPECT_EQ(unrest.moved.size(), 0u);
  EXPECT_LT(unrest.way, 0.01);
  EXPECT_NEAR(unrest.seconds, worker::kRestSpan, kFalling.Timestep());
  engine_->objects()[1]->setLinearVelocity({0, 0, 2});
  EXPECT_EQ(worker::WatchUnrest(*engine_, falling_).moved.size(), 1u) << "it slides";
}

TEST_F(ComeToRest, TheRefereeStopsOnceTooManyHaveMoved) {
  const worker::Unrest unrest = worker::WatchUnrest(*engine_, falling_, worker::kRestSpan, 0);
  EXPECT_EQ(unrest.moved.size(), 3u);
  EXPECT_LT(unrest.seconds, worker::kRestSpan / 2);
}

TEST_F(ComeToRest, OthersAreHeldWhileTheRestlessCalmDown) {
  falling_.objects = {};
  for (std::uint32_t i = 0; i < 12; ++i) falling_.objects.push_back(i);
  SetGroup(scene_, "quantity", std::uint64_t{12});
  SeedStreams(scene_);
  engine_ = std::make_unique<world::Engine>(scene_, layouts::MakeInitialState(scene_),
                                            omissions::KeepEverything(scene_));
  const btTransform before = engine_->objects()[5]->getWorldTransform();
  const double height = Position(*engine_, 7).y();
  worker::CalmDown(*engine_, falling_, {12, {0.9, 1e-3}}, 1, {7});
  EXPECT_LT(Position(*engine_, 7).y(), height - 0.1);
  EXPECT_EQ(engine_->objects()[5]->getWorldTransform(), before);
}

}  // namespace
}  // namespace cdb::tests
