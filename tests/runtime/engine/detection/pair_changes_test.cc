#include "runtime/engine/detection/pair_changes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <set>
#include <stdexcept>
#include <vector>

namespace cdb::tests {
namespace {

/// Bodies; the last one may not collide with any.
class Bodies {
 public:
  explicit Bodies(std::size_t count) : boxes_(count), filters_(count) { filters_.back().mask = 0; }
  Scene View() const {
    return {.size = boxes_.size(),
            .boxes = boxes_,
            .filters = filters_,
            .poses = {},
            .shapes = {},
            .is_asleep = {}};
  }

 private:
  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
};

/// PairChanges, and the set of pairs that results from them.
class Kept {
 public:
  bool Update(const Scene& scene, std::vector<Pair> found) {
    if (!changes_.knows_list()) changes_.SetList({pairs_.begin(), pairs_.end()});
    return Apply(changes_.Update(scene, found, is_kept_));
  }
  void Take(const Scene& scene, std::vector<Pair> came, std::vector<Pair> went) {
    changes_.Take(scene, came, went, is_kept_);
    for (const Pair& pair : changes_.went()) pairs_.erase(pair);
    pairs_.insert(changes_.came().begin(), changes_.came().end());
  }
  const std::set<Pair>& pairs() const { return pairs_; }
  const detection::PairChanges& changes() const { return changes_; }

 private:
  bool Apply(bool has_changed) {
    for (const Pair& pair : changes_.went()) EXPECT_EQ(pairs_.erase(pair), 1u);
    for (const Pair& pair : changes_.came()) EXPECT_TRUE(pairs_.insert(pair).second);
    return has_changed;
  }

  detection::PairChanges changes_;
  std::set<Pair> pairs_;
  const std::function<bool(const Pair&)> is_kept_ = [this](const Pair& pair) {
    return pairs_.count(pair) > 0;
  };
};

TEST(PairChanges, ComeToTheListWhateverItsOrder) {
  constexpr std::size_t kBodies = 120;
  const Bodies bodies(kBodies);
  std::mt19937 random(3);
  const auto body = [&] { return static_cast<Id>(random() % kBodies); };
  for (const int churn : {0, 3, 400}) {
    Kept kept;
    std::vector<Pair> list;
    for (int cycle = 0; cycle < 300; ++cycle) {
      for (int i = 0; i < churn && !list.empty(); ++i) {
        // Like a hash table: the last pair takes the place of the removed one.
        const std::size_t at = random() % list.size();
        list[at] = list.back();
        list.pop_back();
      }
      for (int i = 0; i < churn; ++i) {
        const Pair pair = {body(), body()};
        if (pair.a != pair.b) list.push_back(pair);  // some twice, some reversed
      }
      if (cycle % 17 == 5) std::ranges::shuffle(list, random);
      if (cycle % 29 == 7) std::ranges::sort(list);
      if (cycle % 97 == 50) list.clear();
      std::set<Pair> expected;
      for (const Pair& pair : list) {
        const Pair shaped = {std::min(pair.a, pair.b), std::max(pair.a, pair.b)};
        if (shaped.b != kBodies - 1) expected.insert(shaped);
      }
      const bool same = expected == kept.pairs();
      EXPECT_EQ(kept.Update(bodies.View(), list), !same);
      ASSERT_EQ(kept.pairs(), expected) << "churn " << churn << ", cycle " << cycle;
    }
  }
}

TEST(PairChanges, AreFoundInAListThatKeepsItsOrder) {
  constexpr std::size_t kBodies = 400;
  const Bodies bodies(kBodies);
  std::mt19937 random(5);
  std::vector<Pair> candidates;
  for (Id a = 0; a < kBodies; ++a)
    for (Id b = a + 1; b < std::min<Id>(a + 12, kBodies); ++b) candidates.push_back({a, b});
  std::ranges::shuffle(candidates, random);
  std::vector<char> is_listed(candidates.size(), 0);
  Kept kept;
  for (int cycle = 0; cycle < 300; ++cycle) {
    // Few changes, many in one place, and many everywhere.
    const std::size_t flips = cycle % 50 == 49 ? 2000 : cycle % 7;
    for (std::size_t k = 0; k < flips; ++k) is_listed[random() % candidates.size()] ^= 1;
    if (cycle % 20 == 10)
      for (std::size_t k = 0; k < 40; ++k) is_listed[1000 + k] ^= 1;
    std::vector<Pair> list;
    std::set<Pair> expected;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!is_listed[i]) continue;
      list.push_back(candidates[i]);
      if (candidates[i].b != kBodies - 1) expected.insert(candidates[i]);
    }
    const bool same = expected == kept.pairs();
    EXPECT_EQ(kept.Update(bodies.View(), list), !same);
    ASSERT_EQ(kept.pairs(), expected) << "cycle " << cycle;
    EXPECT_TRUE(std::ranges::is_sorted(kept.changes().came()));
    EXPECT_TRUE(std::ranges::is_sorted(kept.changes().went()));
  }
}

TEST(PairChanges, TellWhatCameAndWhatWent) {
  const Bodies bodies(10);
  Kept kept;
  EXPECT_TRUE(kept.Update(bodies.View(), {{0, 1}, {3, 2}}));
  EXPECT_FALSE(kept.Update(bodies.View(), {{0, 1}, {3, 2}}));
  EXPECT_FALSE(kept.Update(bodies.View(), {{2, 3}, {1, 0}, {0, 1}}));
  EXPECT_TRUE(kept.Update(bodies.View(), {{4, 5}, {0, 1}, {8, 9}}));
  ASSERT_EQ(kept.changes().came().size(), 1u);
  EXPECT_EQ(kept.changes().came()[0], (Pair{4, 5}));
  ASSERT_EQ(kept.changes().went().size(), 1u);
  EXPECT_EQ(kept.changes().went()[0], (Pair{2, 3}));
}

TEST(PairChanges, OfADetectorThatListsThemAreInOrderAndEachOnce) {
  const Bodies bodies(10);
  Kept kept;
  kept.Update(bodies.View(), {{0, 1}, {2, 3}});
  // Of the new pairs one is kept, one is duplicated, and one may not collide; of the removed ones,
  // one was not kept.
  kept.Take(bodies.View(), {{1, 0}, {7, 6}, {6, 7}, {4, 5}, {8, 9}}, {{3, 2}, {5, 6}});
  EXPECT_TRUE(std::ranges::equal(kept.changes().came(), std::vector<Pair>{{0, 1}, {4, 5}, {6, 7}}));
  EXPECT_TRUE(std::ranges::equal(kept.changes().went(), std::vector<Pair>{{2, 3}, {5, 6}}));
  EXPECT_EQ(kept.pairs(), (std::set<Pair>{{0, 1}, {4, 5}, {6, 7}}));
  EXPECT_THROW(kept.Take(bodies.View(), {{2, 10}}, {}), std::invalid_argument);
  EXPECT_THROW(kept.Take(bodies.View(), {}, {{4, 4}}), std::invalid_argument);
  EXPECT_TRUE(kept.Update(bodies.View(), {{6, 7}, {1, 2}, {4, 5}}));
  EXPECT_EQ(kept.pairs(), (std::set<Pair>{{1, 2}, {4, 5}, {6, 7}}));
}

TEST(PairChanges, RefusePairsThatMakeNoSenseAndKeepWhatTheyHad) {
  const Bodies bodies(10);
  Kept kept;
  kept.Update(bodies.View(), {{0, 1}});
  EXPECT_THROW(kept.Update(bodies.View(), {{0, 1}, {2, 10}}), std::invalid_argument);
  EXPECT_THROW(kept.Update(bodies.View(), {{4, 4}}), std::invalid_argument);
  EXPECT_FALSE(kept.Update(bodies.View(), {{0, 1}}));
}

}  // namespace
}  // namespace cdb::tests
