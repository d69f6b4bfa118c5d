// The check by lanes against all pairs in double, and against the referee.
#include "library/robots/lanes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "library/distributions/stream.h"
#include "library/scene_error.h"
#include "tests/library/robots/arm_scene.h"

namespace cdb::tests {
namespace {

std::vector<const robots::LaneKernel*> Kernels() {
  std::vector<const robots::LaneKernel*> kernels = {&robots::PlainLaneKernel()};
  if (robots::Avx2LaneKernel() != nullptr) kernels.push_back(robots::Avx2LaneKernel());
  return kernels;
}

TEST(Lanes, AnswerAsAllPairsInDouble) {
  for (const int variant : {0, 1, 2}) {
    const plan::Scene scene = SceneOfText(
        BallArm(variant < 2 ? "cycles 4001; seed 7"
                            : "cycles 4001; seed 7; joint3.gear.with joint1; joint3.gear.ratio -0.7"
                              "\nslide.gear.with joint5; slide.gear.ratio 0.06",
                variant > 0));
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    const std::vector<double> positions = robots::PositionsOf(scene);
    for (const robots::LaneKernel* kernel : Kernels()) {
      robots::LaneChecker checker(scene, state, kernel);
      std::vector<std::uint8_t> hits(4001);
      checker.Check(positions, hits);
      std::size_t count = 0, disagree = 0;
      std::vector<objects::Pose> poses;
      const std::size_t freedoms = checker.tree().freedoms();
      for (std::size_t i = 0; i < hits.size(); ++i) {
        checker.tree().PosesAt(std::span(positions).subspan(i * freedoms, freedoms), poses);
        disagree += robots::HitsInDouble(checker.balls(), state.objects, poses) != (hits[i] != 0);
        count += hits[i];
      }
      EXPECT_EQ(disagree, 0u);
      EXPECT_GT(count, 400u);  // both answers occur often
      EXPECT_LT(count, 3600u);
      EXPECT_LT(checker.rechecked(), 40u);  // within the error of single precision
    }
  }
}

TEST(Lanes, AnswerAsTheReferee) {
  const plan::Scene scene = SceneOfText(BallArm("cycles 400; seed 11", true));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const std::vector<double> positions = robots::PositionsOf(scene);
  robots::LaneChecker checker(scene, state);
  std::vector<std::uint8_t> hits(400);
  checker.Check(positions, hits);
  std::vector<objects::Pose> poses;
  const std::size_t freedoms = checker.tree().freedoms();
  for (std::size_t i = 0; i < hits.size(); ++i) {
    checker.tree().PosesAt(std::span(positions).subspan(i * freedoms, freedoms), poses);
    const std::optional<bool> exact = robots::HitsExactly(checker.balls(), state.objects, poses);
    ASSERT_TRUE(exact);
    EXPECT_EQ(*exact, hits[i] != 0) << i;
  }
}

// A ball one metre from the axis of a hinge, which turns it onto an obstacle or just past it.
TEST(Lanes, AreRightHoweverNearlyBallsTouch) {
  distributions::Stream stream(5);
  std::size_t rechecked = 0;
  for (int i = 0; i < 300; ++i) {
    const double angle = stream.Uniform(-3, 3);
    const double gap = (i % 2 == 0 ? 1 : -1) * std::pow(10, stream.Uniform(-12, -2));
    const Eigen::Vector3d at(std::cos(angle), std::sin(angle), 0);
    const Eigen::Vector3d place = at + (0.3 + gap) * Eigen::Vector3d(0, 0, 1);
    const plan::Scene scene = SceneOfText(
        fmt::format("benchmark b {{ configurations {{ positions path; ask hit }} cycles 8\n"
                    "objects arm {{ type sphere; size 0.2; location at(1, 0, 0); overlap on }}\n"
                    "joints hinge {{ child arm; axis (0, 0, 1); goal {:.17g} }}\n"
                    "objects ball {{ type sphere; size 0.4; mass fixed\n"
                    "  location at({:.17g}, {:.17g}, {:.17g}); overlap on }} }}",
                    angle, place.x(), place.y(), place.z()));
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    const std::vector<double> positions = robots::PositionsOf(scene);
    for (const robots::LaneKernel* kernel : Kernels()) {
      robots::LaneChecker checker(scene, state, kernel);
      std::vector<std::uint8_t> hits(8);
      checker.Check(positions, hits);
      EXPECT_EQ(hits[7] != 0, gap < 0) << gap;
      rechecked += checker.rechecked();
    }
  }
  EXPECT_GT(rechecked, 100u);
}

TEST(Lanes, RefuseOtherShapes) {
  const auto said = [](const std::string& objects) {
    const plan::Scene scene = SceneOfText(
        "benchmark b { configurations { positions uniform; ask hit }\n"
        "joints hinge { child arm; axis (0, 0, 1) }\n" +
        objects + "}");
    try {
      robots::LaneChecker checker(scene, layouts::MakeInitialState(scene));
    } catch (const library::SceneError& error) {
      return error.cause();
    }
    return std::string("nothing");
  };
  EXPECT_NE(said("objects arm { type cuboid; size 1; location at(2, 0, 0) }").find("arm"),
            std::string::npos);
  EXPECT_NE(said("objects arm { type sphere; size 1; location at(2, 0, 0) }\n"
                 "objects cone { type cone; size 1; mass fixed; location at(9, 0, 0) }")
                .find("cone"),
            std::string::npos);
  EXPECT_EQ(said("objects arm { type sphere; size 1; location at(2, 0, 0) }"), "nothing");
}

}  // namespace
}  // namespace cdb::tests
