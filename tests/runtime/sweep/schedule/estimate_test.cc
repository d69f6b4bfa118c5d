#include "runtime/sweep/schedule/progress.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

TEST(EstimateTest, KnowsNothingBeforeTheFirstRun) {
  const auto plan = MakePlan();
  schedule::TimeEstimate estimate(Pointers(plan));
  EXPECT_FALSE(estimate.Left().has_value());
  EXPECT_FALSE(estimate.Predict(plan.runs[0]).has_value());
}

TEST(EstimateTest, FindsAPowerLaw) {
  const auto plan = MakePlan({.quantities = {10, 100, 1000}, .detectors = {"dbvt"}});
  schedule::TimeEstimate estimate(Pointers(plan));
  const auto seconds = [](double objects) { return 10 * 1e-6 * std::pow(objects, 1.5); };
  estimate.Ended(plan.runs[0], seconds(10));
  // One size does not determine a slope: the estimate is proportional to the number of objects.
  EXPECT_NEAR(estimate.Predict(plan.runs[2]).value(), seconds(10) * 100, 1e-9);
  estimate.Ended(plan.runs[1], seconds(100));
  EXPECT_NEAR(estimate.Predict(plan.runs[2]).value(), seconds(1000), 1e-9);
  EXPECT_NEAR(estimate.Left().value(), seconds(1000), 1e-9);
  estimate.Ended(plan.runs[2], seconds(1000));
  EXPECT_EQ(estimate.Left().value(), 0);
}

TEST(EstimateTest, ARepeatIsTheMeanOfItsLike) {
  const auto plan = MakePlan({.quantities = {10}, .detectors = {"dbvt", "sap"}, .repeats = 4});
  schedule::TimeEstimate estimate(Pointers(plan));
  estimate.Ended(plan.runs[0], 2);
  estimate.Ended(plan.runs[1], 4);
  EXPECT_EQ(estimate.Predict(plan.runs[2]).value(), 3);
  // No run of `sap` has ended: the geometric mean of the other detector is used.
  EXPECT_NEAR(estimate.Predict(plan.runs[4]).value(), std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(estimate.Left().value(), 2 * 3 + 4 * std::sqrt(8.0), 1e-12);
}

TEST(EstimateTest, DetectorsHaveScalesOfTheirOwn) {
  const auto plan = MakePlan({.quantities = {10, 100}, .detectors = {"dbvt", "simple"}});
  schedule::TimeEstimate estimate(Pointers(plan));
  estimate.Ended(plan.runs[0], 1);
  estimate.Ended(plan.runs[1], 5);
  EXPECT_NEAR(estimate.Predict(plan.runs[2]).value(), 10, 1e-9);
  EXPECT_NEAR(estimate.Predict(plan.runs[3]).value(), 50, 1e-9);
}

TEST(EstimateTest, RunsThatEndedBadlyTeachNothing) {
  const auto plan = MakePlan({.quantities = {10, 100}, .detectors = {"dbvt"}});
  schedule::TimeEstimate estimate(Pointers(plan));
  estimate.Ended(plan.runs[0], std::nullopt);
  EXPECT_FALSE(estimate.Left().has_value());
  estimate.Ended(plan.runs[1], std::nullopt);
  EXPECT_EQ(estimate.Left().value(), 0);
}

TEST(EstimateTest, NoRunTakesLongerThanItsTimeout) {
  const auto plan = MakePlan({.quantities = {10, 100000}, .detectors = {"dbvt"}, .timeout_s = 30});
  schedule::TimeEstimate estimate(Pointers(plan));
  estimate.Ended(plan.runs[0], 10);
  EXPECT_EQ(estimate.Predict(plan.runs[1]).value(), 30);
}

TEST(EstimateTest, EmptyWorldsAndTimesOfZeroAreFinite) {
  const auto plan = MakePlan({.quantities = {0, 50}, .detectors = {"dbvt"}});
  schedule::TimeEstimate estimate(Pointers(plan));
  estimate.Ended(plan.runs[0], 0);
  EXPECT_TRUE(std::isfinite(estimate.Left().value()));
}

}  // namespace
}  // namespace cdb::tests
