// Broad phases of other libraries compared with the exact pairs. The catalogue lists which of them
// may report false positives or miss a pair.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "library/detectors/exact_pairs.h"
#include "tests/library/detectors/box_scenes.h"
#include "tests/library/detectors/third_party/third_party.h"

namespace cdb::tests {
namespace {

class ThirdPartyPairs : public testing::TestWithParam<schema::DetectorInfo> {
 protected:
  void SetUp() override {
    detector_ = MakeThirdParty(GetParam());
    if (!detector_)
      GTEST_SKIP() << "the part '" << GetParam().part << "' is not built (./setup --third-party)";
  }

  /// `is_strict`: it must not miss a pair, even if the catalogue permits that.
  void ExpectGood(const Scene& scene, const std::string& what, bool is_strict = true) {
    std::vector<Pair> pairs;
    detector_->FindPairs(scene, pairs);
    for (const Pair& pair : pairs) {
      ASSERT_LT(pair.a, pair.b) << what;
      ASSERT_LT(pair.b, scene.size) << what;
    }
    const detectors::PairFaults faults = detectors::ComparePairs(scene, pairs);
    if (is_strict || !GetParam().Makes(schema::KnownErrors::kMissesPairs)) {
      EXPECT_EQ(faults.missed, 0u) << what;
    }
    if (!GetParam().Makes(schema::KnownErrors::kFalsePositives)) {
      EXPECT_EQ(faults.false_positives, 0u) << what;
    }
    EXPECT_EQ(faults.duplicate, 0u) << what;
  }

  std::unique_ptr<Detector> detector_;
};

TEST_P(ThirdPartyPairs, AreExactInEveryScene) {
  for (const std::string_view name : kBoxScenes) {
    for (const bool walls : {false, true}) {
      BoxScene scene(name, 400, walls);
      detector_ = MakeThirdParty(GetParam());
      detector_->Prepare(scene.View());
      for (int cycle = 0; cycle < 30; ++cycle, scene.Move())
        ExpectGood(scene.View(), std::string(name) + (walls ? " with walls" : ""));
    }
  }
}

TEST_P(ThirdPartyPairs, OfBoxesThatTouchOrHaveNoExtent) {
  std::vector<Box> boxes;
  for (int i = 0; i < 512; ++i)  // a lattice without gaps, and its corners as points
    boxes.push_back(Cube(i % 8, i / 8 % 8, i / 64, i % 3 == 0 ? 0.5 : i % 3 == 1 ? 0.25 : 0));
  Boxes scene(boxes);
  detector_->Prepare(scene.View());
  for (int cycle = 0; cycle < 3; ++cycle) ExpectGood(scene.View(), "lattice", false);
}

TEST_P(ThirdPartyPairs, OfBoxesAllInOnePlace) {
  Boxes scene(std::vector<Box>(200, Cube(1, 2, 3, 1)));
  detector_->Prepare(scene.View());
  for (int cycle = 0; cycle < 3; ++cycle) ExpectGood(scene.View(), "one place");
}

TEST_P(ThirdPartyPairs, OfASceneWithoutBodiesAndOneWithOne) {
  for (const std::size_t size : {0, 1}) {
    Boxes scene(std::vector<Box>(size, Cube(0, 0, 0, 1)));
    detector_ = MakeThirdParty(GetParam());
    detector_->Prepare(scene.View());
    ExpectGood(scene.View(), std::to_string(size));
  }
}

TEST_P(ThirdPartyPairs, OfBoxesInOrderAlongALine) {
  std::vector<Box> boxes;
  for (int i = 0; i < 2000; ++i) boxes.push_back(Cube(i * 0.9, 0, 0, 0.5));
  Boxes scene(boxes);
  detector_->Prepare(scene.View());
  for (int cycle = 0; cycle < 3; ++cycle) ExpectGood(scene.View(), "line");
}

// A grain of dust among continents: a grid must not choose its cells by either.
TEST_P(ThirdPartyPairs, OfBoxesOfEverySize) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-3, 4), at(-1000, 1000);
  std::vector<Box> boxes;
  for (int i = 0; i < 500; ++i)
    boxes.push_back(Cube(at(random), at(random), at(random), std::pow(10.0, exponent(random)) / 2));
  Boxes scene(boxes);
  detector_->Prepare(scene.View());
  for (int cycle = 0; cycle < 3; ++cycle) ExpectGood(scene.View(), "sizes");
}

TEST_P(ThirdPartyPairs, OfBodiesThatLeaveTheWorld) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> at(-5, 5);
  std::vector<Vec3> from;
  for (int i = 0; i < 300; ++i) from.push_back({at(random), at(random), at(random)});
  Boxes scene(std::vector<Box>(from.size()));
  const auto spread = [&](double factor) {
    for (std::size_t i = 0; i < from.size(); ++i)
      scene.boxes[i] =
          Cube(from[i].x * factor, from[i].y * factor, from[i].z * factor, factor < 1e30 ? 1 : 0);
  };
  spread(1);
  detector_->Prepare(scene.View());
  for (const double factor : {1.0, 1e3, 1e6, 1e9, 1e15, 1e25, 1e60, 1e200, 1.0}) {
    spread(factor);
    ExpectGood(scene.View(), std::to_string(factor));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  scene.boxes[7].lower.y = nan;
  scene.boxes[8] = {{nan, nan, nan}, {nan, nan, nan}};
  scene.boxes[9].upper.x = infinite;
  ExpectGood(scene.View(), "not numbers");
  for (Box& box : scene.boxes) box = {{nan, nan, nan}, {nan, nan, nan}};
  ExpectGood(scene.View(), "no numbers at all");
  spread(1);
  ExpectGood(scene.View(), "back again");
}

INSTANTIATE_TEST_SUITE_P(, ThirdPartyPairs, testing::ValuesIn(ThirdPartyDetectors("broad")),
                         DetectorName());

}  // namespace
}  // namespace cdb::tests
