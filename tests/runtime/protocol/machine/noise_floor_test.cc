#include "runtime/protocol/machine/noise.h"

#include <gtest/gtest.h>

namespace cdb::tests {
namespace {

TEST(NoiseFloor, IsOfLoopsThatTookTime) {
  const machine::NoiseFloor floor = machine::MeasureNoiseFloor(0.02);
  EXPECT_GE(floor.loops, 1u);
  EXPECT_GT(floor.median, 0);
  EXPECT_LE(floor.half_low, floor.median);
  EXPECT_GE(floor.half_high, floor.median);
  EXPECT_GE(floor.p99, floor.half_high);
  EXPECT_GE(floor.worst, floor.p99);
  EXPECT_GT(floor.clock_ns, 0);
}

TEST(NoiseFloor, IsQuietWithinItsLimitsAlone) {
  const machine::NoiseFloor quiet = {100, 1000, 995, 1005, 1050, 3000, 0.01, 0, 0.02, 20};
  EXPECT_TRUE(quiet.IsQuiet());
  for (const auto& [member, value] : {std::pair(&machine::NoiseFloor::half_high, 1020.0),
                                      {&machine::NoiseFloor::p99, 1200.0},
                                      {&machine::NoiseFloor::off_processor, 0.05},
                                      {&machine::NoiseFloor::stolen, 0.02},
                                      {&machine::NoiseFloor::others, 0.9}}) {
    machine::NoiseFloor disturbed = quiet;
    disturbed.*member = value;
    EXPECT_FALSE(disturbed.IsQuiet()) << value;
  }
}

}  // namespace
}  // namespace cdb::tests
