#include "library/detectors/bullet/bullet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <vector>

#include "library/detectors/exact_pairs.h"
#include "tests/library/detectors/box_scenes.h"

namespace cdb::tests {
namespace {

TEST(BulletDetectors, MissNoPairOfMovingBoxes) {
  for (const DetectorEntry& entry : bullet::BulletDetectors()) {
    if (!HasAny(entry.phases, kBroad)) continue;
    for (const std::string_view name : kBoxScenes) {
      for (const bool walls : {false, true}) {
        SCOPED_TRACE(std::string(entry.name) + " on " + std::string(name));
        BoxScene moving(name, 400, walls);
        const std::unique_ptr<Detector> detector(entry.make({}));
        detector->Prepare(moving.View());
        for (int cycle = 0; cycle < 20; ++cycle, moving.Move()) {
          std::vector<Pair> found;
          detector->FindPairs(moving.View(), found);
          const detectors::PairFaults faults = detectors::ComparePairs(moving.View(), found);
          ASSERT_EQ(faults.missed, 0u) << "cycle " << cycle;
          ASSERT_EQ(faults.duplicate, 0u) << "cycle " << cycle;
          for (const Pair& pair : found) ASSERT_LT(pair.a, pair.b);
        }
      }
    }
  }
}

TEST(BulletDetectors, ListChangesThatComeToTheirPairs) {
  for (const DetectorEntry& entry : bullet::BulletDetectors()) {
    if (!HasAny(entry.phases, kBroad)) continue;
    for (const std::string_view name : kBoxScenes) {
      SCOPED_TRACE(std::string(entry.name) + " on " + std::string(name));
      BoxScene moving(name, 400, true);
      const std::unique_ptr<Detector> listing(entry.make({})), changing(entry.make({}));
      listing->Prepare(moving.View());
      changing->Prepare(moving.View());
      std::set<Pair> kept;
      for (int cycle = 0; cycle < 20; ++cycle, moving.Move()) {
        std::vector<Pair> came, went, listed = Listed(*listing, moving.View());
        EXPECT_EQ(changing->FindChanges(moving.View(), came, went), cycle > 0);
        for (const Pair& pair : went) kept.erase(pair);
        kept.insert(came.begin(), came.end());
        std::ranges::sort(listed);
        ASSERT_TRUE(std::ranges::equal(kept, listed)) << "cycle " << cycle;
      }
    }
  }
}

}  // namespace
}  // namespace cdb::tests
