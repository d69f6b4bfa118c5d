#include "runtime/sweep/schedule/order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "runtime/sweep/process/launcher.h"
#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

std::vector<std::string> Ids(const std::vector<const plan::Run*>& runs) {
  std::vector<std::string> ids;
  for (const plan::Run* run : runs) ids.push_back(run->id);
  return ids;
}

TEST(OrderTest, EveryRunStandsInItOnce) {
  const plan::Plan plan = MakePlan({.repeats = 4});
  auto ids = Ids(schedule::OrderRuns(plan));
  std::ranges::sort(ids);
  std::vector<std::string> all;
  for (const plan::Run& run : plan.runs) all.push_back(run.id);
  std::ranges::sort(all);
  EXPECT_EQ(ids, all);
  EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), 3u * 3 * 4);
}

TEST(OrderTest, RepeatsGoRoundTheWholeGridAndDetectorsAreNeighbours) {
  const plan::Plan plan = MakePlan({.quantities = {5, 6, 7, 8}, .repeats = 3});
  const auto order = schedule::OrderRuns(plan);
  ASSERT_EQ(order.size(), 4u * 3 * 3);
  for (std::size_t i = 0; i < order.size(); ++i) {
    EXPECT_EQ(order[i]->rep, i / 12);
    EXPECT_EQ(order[i]->at[0], i % 12 / 3) << "points in the order of the grid";
  }
  for (std::size_t i = 0; i < order.size(); i += 3) {
    const std::set<std::size_t> detectors = {order[i]->at[1], order[i + 1]->at[1],
                                             order[i + 2]->at[1]};
    EXPECT_EQ(detectors.size(), 3u);
  }
}

TEST(OrderTest, NoDetectorAlwaysGoesFirst) {
  const plan::Plan plan = MakePlan({.quantities = {1, 2, 3, 4, 5, 6, 7, 8}, .repeats = 8});
  const auto order = schedule::OrderRuns(plan);
  std::map<std::size_t, int> first;
  for (std::size_t i = 0; i < order.size(); i += 3) ++first[order[i]->at[1]];
  // 64 shuffles of three: each is first 21 times on average, with a standard deviation of 3.8. The
  // seeds are fixed, so this always or never holds; four deviations leave room for any hash.
  for (const std::size_t detector : {0, 1, 2}) {
    EXPECT_GE(first[detector], 6) << detector;
    EXPECT_LE(first[detector], 37) << detector;
  }
}

TEST(OrderTest, ASearchIsInOneShard) {
  plan::Plan plan = MakePlan({.quantities = {1, 2, 3, 4, 5, 6, 7, 8}, .repeats = 2});
  EXPECT_GT(schedule::ListShards(plan, 100).size(), 8u);
  plan.axes[0].search = plan::Search{};
  EXPECT_EQ(schedule::ListShards(plan, 100).size(), 1u) << "detectors of a point stay together";
  EXPECT_EQ(schedule::OrderRuns(plan, {1, 3}).size(), plan.runs.size());
  EXPECT_TRUE(schedule::OrderRuns(plan, {2, 3}).empty());
}

TEST(OrderTest, ThePlanAloneDecidesIt) {
  plan::Plan plan = MakePlan({.repeats = 5});
  const auto ids = Ids(schedule::OrderRuns(plan));
  plan.title = "another title";
  plan.source = "elsewhere.cdb";
  EXPECT_EQ(Ids(schedule::OrderRuns(plan)), ids);
  const plan::Plan copy = plan;
  EXPECT_EQ(Ids(schedule::OrderRuns(copy)), ids);
}

TEST(OrderTest, RunsOfOneIdRunOnce) {
  plan::Plan plan = MakePlan({.quantities = {4, 4}});
  ASSERT_EQ(plan.runs.size(), 6u);
  ASSERT_EQ(plan.runs[0].id, plan.runs[3].id);
  const auto order = schedule::OrderRuns(plan);
  EXPECT_EQ(order.size(), 3u);
  for (const plan::Run* run : order) EXPECT_EQ(run->at[0], 0u);
}

TEST(OrderTest, APlanWithoutAxesHasOneRun) {
  plan::Plan plan = MakePlan({.quantities = {4}, .detectors = {"dbvt"}});
  plan.axes.clear();
  plan.runs[0].at.clear();
  EXPECT_EQ(Ids(schedule::OrderRuns(plan)), std::vector<std::string>{plan.runs[0].id});
}

TEST(OrderTest, ShardsAreThePlanInParts) {
  const plan::Plan plan = MakePlan({.quantities = {1, 2, 3, 4, 5}, .repeats = 3});
  for (const std::uint64_t count : {1, 2, 3, 7, 15, 16, 100}) {
    std::vector<std::string> ids;
    for (std::uint64_t index = 1; index <= count; ++index) {
      const auto part = schedule::OrderRuns(plan, {index, count});
      EXPECT_EQ(part.size() % 3, 0u) << "the detectors of a point stay together";
      EXPECT_TRUE(count > 15 || !part.empty()) << index << "/" << count;
      for (std::size_t i = 0; i < part.size(); i += 3)
        for (std::size_t k = 1; k < 3; ++k) {
          EXPECT_EQ(part[i + k]->at[0], part[i]->at[0]);
          EXPECT_EQ(part[i + k]->rep, part[i]->rep);
        }
      for (const std::string& id : Ids(part)) ids.push_back(id);
    }
    EXPECT_EQ(ids.size(), plan.runs.size()) << count;
    EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), ids.size()) << count;
  }
}

TEST(OrderTest, ListedShardsAreThoseThatAreOrdered) {
  const plan::Plan plan = MakePlan({.quantities = {5, 6, 7, 8}, .repeats = 3});
  const auto listed = schedule::ListShards(plan, 5);
  ASSERT_EQ(listed.size(), 5u);
  for (std::uint64_t i = 0; i < 5; ++i) {
    auto all = Ids(listed[i]), ordered = Ids(schedule::OrderRuns(plan, {i + 1, 5}));
    std::ranges::sort(all);
    std::ranges::sort(ordered);
    EXPECT_EQ(all, ordered);
  }
  EXPECT_EQ(schedule::ListShards(plan, 1000).size(), 12u) << "no shard is empty";
}

TEST(OrderTest, AShardKeepsTheOrderOfTheWhole) {
  const plan::Plan plan = MakePlan({.quantities = {1, 2, 3, 4, 5}, .repeats = 3});
  const auto whole = Ids(schedule::OrderRuns(plan));
  for (std::uint64_t index = 1; index <= 4; ++index) {
    auto rest = whole.begin();
    for (const std::string& id : Ids(schedule::OrderRuns(plan, {index, 4}))) {
      rest = std::find(rest, whole.end(), id);
      ASSERT_NE(rest, whole.end()) << id << " out of order";
      ++rest;
    }
  }
}

TEST(OrderTest, ShardsAreEvenByWork) {
  const plan::Plan plan =
      MakePlan({.quantities = {10, 20000, 100, 5000, 1000, 2000, 3000, 7000}, .repeats = 2});
  for (const std::uint64_t count : {2, 3, 5}) {
    double least = 1e300;
    double most = 0;
    for (std::uint64_t index = 1; index <= count; ++index) {
      double work = 0;
      for (const plan::Run* run : schedule::OrderRuns(plan, {index, count}))
        work += schedule::EstimatedWork(*run);
      least = std::min(least, work);
      most = std::max(most, work);
    }
    // Heaviest first: the fullest shard got its last unit when it was the emptiest.
    double unit = 0;
    for (const plan::Run& run : plan.runs) unit = std::max(unit, 3 * schedule::EstimatedWork(run));
    EXPECT_LE(most - least, unit) << count;
  }
}

TEST(OrderTest, AShardThatThereIsNotIsRefused) {
  const plan::Plan plan = MakePlan();
  EXPECT_THROW(schedule::OrderRuns(plan, {0, 3}), process::ScheduleError);
  EXPECT_THROW(schedule::OrderRuns(plan, {4, 3}), process::ScheduleError);
  EXPECT_THROW(schedule::OrderRuns(plan, {1, 0}), process::ScheduleError);
  EXPECT_TRUE(schedule::OrderRuns(plan, {1000000000, 1000000000}).empty());
}

}  // namespace
}  // namespace cdb::tests
