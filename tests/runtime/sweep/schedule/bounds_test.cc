#include "runtime/sweep/schedule/order.h"

#include <gtest/gtest.h>

#include <string>

#include "runtime/sweep/process/launcher.h"
#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

using schedule::WhyTooLarge;

plan::Plan PlanOf(std::uint64_t objects) {
  PlanShape shape;
  shape.quantities = {objects};
  return MakePlan(shape);
}

TEST(Bounds, GrowWithThePlan) {
  const schedule::Demand few = schedule::LeastDemand(PlanOf(10)),
                         many = schedule::LeastDemand(PlanOf(2'000'000'000));
  EXPECT_EQ(many.objects, 2e9);
  EXPECT_GT(many.scene, 1e12);
  EXPECT_GT(many.time, few.time);
  EXPECT_GT(few.recorded, 0);
  EXPECT_GT(few.disk, 0);
  EXPECT_LT(few.recorded + few.scene, 1e6) << "a lower bound";
  EXPECT_EQ(schedule::LeastDemand(std::vector<const plan::Run*>(), 1).time, 0) << "all is done";
  const schedule::Demand shared = schedule::LeastDemand(PlanOf(10), 2, 3);
  EXPECT_DOUBLE_EQ(shared.time, few.time / 6);
  EXPECT_DOUBLE_EQ(shared.disk, few.disk / 3);
}

TEST(Bounds, AreRefusedWithTheNumbers) {
  schedule::Demand demand = {.objects = 5e6, .recorded = 1e9, .scene = 5e9};
  EXPECT_EQ(WhyTooLarge(demand, {.memory = 7e9}), "");
  EXPECT_EQ(WhyTooLarge(demand, {.memory = 5e9}),
            "one run records up to 1 GB and its 5e+06 objects need 5 GB or more, but only 5 GB of "
            "memory are available; use fewer cycles or objects, or record less");
  demand.disk = 3e12;
  EXPECT_EQ(WhyTooLarge(demand, {.disk = 4e12}), "");
  EXPECT_EQ(WhyTooLarge(demand, {.disk = 1e12}),
            "its results need 3 TB of disk or more, but only 1 TB are available; record less, use "
            "fewer runs or cycles, or another disk (-o)");
  demand.time = 3.15576e9;
  EXPECT_EQ(WhyTooLarge(demand, {}),
            "its runs take 100 years or more, at 10 ns per object and cycle; use fewer runs, "
            "objects or cycles, or set a timeout");
}

TEST(Bounds, AreHeldAgainstThisMachine) {
  const schedule::Capacity now = schedule::FreeNow("/no/such/folder"),
                           whole = schedule::WholeMachine();
  EXPECT_GT(now.memory, 1e6);
  EXPECT_LE(now.memory, whole.memory);
  EXPECT_LT(whole.memory, 1e15);
  EXPECT_GT(now.disk, 0);
  EXPECT_LT(now.disk, 1e18);
  EXPECT_NO_THROW(schedule::CheckFits("b", schedule::LeastDemand(PlanOf(10)), "."));
  EXPECT_THROW(schedule::CheckFits("b", schedule::LeastDemand(PlanOf(2'000'000'000)), "."),
               process::ScheduleError);
}

}  // namespace
}  // namespace cdb::tests
