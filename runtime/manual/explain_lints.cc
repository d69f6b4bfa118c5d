// Explanations of the lints of compiler/lints/lints.h. `cdb doc lints` prints their limits.
#include <fmt/format.h>

#include <deque>
#include <string>

#include "compiler/lints/lints.h"
#include "runtime/manual/explanation.h"

namespace cdb::manual {
namespace {

using lints::Lint;

struct LintExample {
  Lint lint;
  std::string_view wrong, right;
};

constexpr LintExample kExamples[] = {
    {Lint::kTallStack,
     "benchmark b { objects { quantity 20; type cuboid; size 1; location stack } }\n",
     "benchmark b {\n  timestep 1 / 500\n  cycles 5000\n"
     "  objects { quantity 20; type cuboid; size 1; location stack }\n}\n"},
    {Lint::kMassRatio,
     "benchmark b { objects { quantity 2; size 20; location stack; mass log_uniform(1, 1e4) } }\n",
     "benchmark b { objects { quantity 2; size 20; location stack; mass uniform(1, 2) } }\n"},
    {Lint::kHeavyEnd,
     "benchmark b {\n  objects { quantity 5; size 40; location line; links { type ball; end_mass "
     "1e4 "
     "} }\n}\n",
     "benchmark b {\n  objects { quantity 5; size 40; location line; links { type ball; end_mass "
     "10 "
     "} }\n}\n"},
    {Lint::kNarrowFoot,
     "benchmark b {\n  expect rest\n"
     "  objects small { quantity 1; type cuboid; size 1; location at(0, 0, 0) }\n"
     "  objects large { quantity 1; type cuboid; size 40; location at(0, 21, 0) }\n}\n",
     "benchmark b {\n  expect rest\n"
     "  objects small { quantity 1; type cuboid; size 20; location at(0, -30, 0) }\n"
     "  objects large { quantity 1; type cuboid; size 40; location at(0, 0, 0) }\n}\n"},
    {Lint::kOverlap,
     "benchmark b { objects { quantity 2; size 1; overlap on; location line(gap: -0.5) } }\n",
     "benchmark b { objects { quantity 2; size 1; overlap on; location line(gap: -0.05) } }\n"},
    {Lint::kLongStep, "benchmark b { objects { size 0.2 } }\n",
     "benchmark b { timestep 1 / 240; objects { size 0.2 } }\n"},
    {Lint::kThinWall,
     "benchmark b {\n  acceleration 0\n  world { walls none; side 50 }\n"
     "  objects ball { quantity 1; size 0.2; location at(-5, 0, 0); linear_velocity (100, 0, 0) }\n"
     "  objects slab {\n    quantity 1; type cuboid; size 0.1; aspect 1 : 40 : 40; mass fixed\n"
     "    location at(0, 0, 0)\n  }\n}\n",
     "benchmark b {\n  acceleration 0\n  world { walls none; side 50 }\n"
     "  objects ball { quantity 1; size 0.2; location at(-5, 0, 0); linear_velocity (5, 0, 0) }\n"
     "  objects slab {\n    quantity 1; type cuboid; size 0.1; aspect 1 : 40 : 40; mass fixed\n"
     "    location at(0, 0, 0)\n  }\n}\n"},
    {Lint::kFastHit, "benchmark b { objects { size 1; linear_velocity (200, 0, 0) } }\n",
     "benchmark b { timestep 1 / 1000; objects { size 1; linear_velocity (200, 0, 0) } }\n"},
    {Lint::kSoftContact,
     "benchmark b {\n  objects { size 40; quantity 2; location stack; contact_stiffness 10 }\n}\n",
     "benchmark b {\n  objects { size 40; quantity 2; location stack; contact_stiffness 1e4 "
     "}\n}\n"},
    {Lint::kStiffSpring,
     "benchmark b {\n  objects { quantity 3; size 40; location line; links { type spring; "
     "stiffness "
     "1e5 } }\n}\n",
     "benchmark b {\n  objects { quantity 3; size 40; location line; links { type spring; "
     "stiffness "
     "100 } }\n}\n"},
    {Lint::kThinShape, "benchmark b { objects { type cylinder; size 5; aspect 1 : 40 : 1 } }\n",
     "benchmark b { objects { type cylinder; size 5; aspect 1 : 4 : 1 } }\n"},
    {Lint::kFastSpin,
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type sphere; angular_velocity (100, 0, 0) }\n}\n",
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type sphere; angular_velocity (10, 0, 0) }\n}\n"},
    {Lint::kSpinDrift,
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type cuboid; aspect 1 : 2 : 3; angular_velocity (10, 5, 0) }\n}\n",
     "benchmark b {\n  world.walls none\n  acceleration 0\n"
     "  objects { type cuboid; aspect 1 : 2 : 3; angular_velocity (10, 0, 0) }\n}\n"},
    {Lint::kHugeBox, "benchmark b { world { side 1e8; walls none }; objects.size 1e6 }\n",
     "benchmark b { world { side 1e6; walls none }; objects.size 1e4 }\n"},
    {Lint::kCoarsePlace,
     "benchmark b { world.side 1e6; objects { size 1; linear_velocity (10, 0, 0) } }\n",
     "benchmark b {\n  precision double\n  world.side 1e6\n"
     "  objects { size 1; linear_velocity (10, 0, 0) }\n}\n"},
    {Lint::kLostMotion,
     "benchmark b {\n  world { side 1e7; walls none }\n  acceleration 0\n"
     "  objects { quantity 1; size 1; location at(2e6, 0, 0); linear_velocity (1, 0, 0) }\n}\n",
     "benchmark b {\n  world { side 1e4; walls none }\n  acceleration 0\n"
     "  objects { quantity 1; size 1; location at(0, 0, 0); linear_velocity (1, 0, 0) }\n}\n"},
    {Lint::kLostFall, "benchmark b { world.side 4e6 }\n", "benchmark b { world.side 1e4 }\n"},
    {Lint::kHeavyMass, "benchmark b { objects.mass 1e8 }\n", "benchmark b { objects.mass 1e6 }\n"},
    {Lint::kEarlySleep,
     "benchmark b {\n  world.walls none\n  acceleration 0\n  objects.linear_velocity (0.1, 0, "
     "0)\n}\n",
     "benchmark b {\n  world.walls none\n  acceleration 0\n  sleeping off\n"
     "  objects.linear_velocity (0.1, 0, 0)\n}\n"},
    {Lint::kShortRun, "benchmark b { cycles 3; objects { size 40; quantity 2; location stack } }\n",
     "benchmark b { cycles 300; objects { size 40; quantity 2; location stack } }\n"},
};

/// The text of a lint in the table, and its limit.
std::string LintText(const lints::LintInfo& info) {
  return fmt::format(
      "{} if a number of the scene is beyond its limit. The number: {}. The limit: {}.",
      fmt::format(fmt::runtime(info.predicts), "may"), info.number, info.threshold);
}

std::vector<Explanation> MakeRows() {
  static std::deque<std::string> texts;  // owns the texts to which the rows refer
  std::vector<Explanation> rows;
  for (const LintExample& example : kExamples) {
    const lints::LintInfo& info = lints::InfoOf(example.lint);
    rows.push_back({&info.kind, texts.emplace_back(LintText(info)), example.wrong, example.right});
  }
  return rows;
}

}  // namespace

std::span<const Explanation> LintExplanations() {
  static const std::vector<Explanation> rows = MakeRows();
  return rows;
}

}  // namespace cdb::manual
