// Objects that slide over ground made of several fixed solids, whose faces continue one another.
#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "dsl/diagnostics.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

constexpr std::uint64_t kSlideCycles = 120;
constexpr const char* kSlidingTypes[] = {"cylinder", "sphere", "cuboid", "capsule"};

struct Slid {
  Eigen::Vector3d velocity;  ///< at the end
  int false_normals;
  double false_impulse;  ///< kg m/s
  int deflected;         ///< at the end
  protocol::Verdict verdict;
};

/// An object without friction at 7 m/s along x, on `floor`, whose upper side is level at y = 0.
Slid SlideOver(const std::string& floor, const std::string& slider, double from = -7) {
  const compiler::Compilation compiled = CompileText(
      fmt::format("benchmark b {{ cycles {}; precision {}; world.side 60; world.walls none\n"
                  "objects slider {{ type {}; friction 0; size 1; location at({}, 0.6, 0.37)\n"
                  "  quantity 1; linear_velocity (7, 0, 0) }}\n"
                  "objects floor {{ mass fixed; friction 0; {} }} }}",
                  kSlideCycles, world::EnginePrecision(), slider, from, floor));
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  const plan::Scene& scene = compiled.plans.at(0).runs.at(0).scene;
  const Recorded run = RunHere(scene);
  EXPECT_TRUE(run.done()) << run.message();
  const auto normals = run.recording.Ints("false_normals");
  const auto impulses = run.recording.Reals("false_impulse");
  return {Velocity(*run.engine), std::accumulate(normals.begin(), normals.end(), 0),
          std::accumulate(impulses.begin(), impulses.end(), 0.0),
          run.recording.Ints("deflected").back(),
          protocol::Judge(scene, run.recording, kSlideCycles).verdict};
}

/// Boxes of 2 x 1 x 2 m, the next one lower by `step`.
std::string Tiles(double step) {
  std::string places;
  for (int z = -1; z <= 1; z += 2)
    for (int x = -7; x <= 7; x += 2)
      places += fmt::format("{}({}, {}, {})", places.empty() ? "" : ", ", x,
                            -0.5 - step * (x + 7) / 2, z);
  return fmt::format("quantity 16; type cuboid; size 2; aspect 1 : 0.5 : 1; location at({})",
                     places);
}

TEST(TiledGround, DeflectsWhatSlidesOverItAndTheVerdictSaysSo) {
  int deflected = 0;
  for (const char* slider : kSlidingTypes)
    for (double from = -7; from < -6; from += 0.125) {
      SCOPED_TRACE(fmt::format("{} from {}", slider, from));
      const Slid slid = SlideOver(Tiles(0), slider, from);
      const double lost = 7 - slid.velocity.x();
      EXPECT_GT(slid.false_impulse, 0.75 * lost - 0.01) << "1 kg";
      // Impulses upward count as well, so that a small loss may be called either way.
      if (lost > 0.4) {
        EXPECT_EQ(slid.verdict, protocol::Verdict::kDrifting);
        EXPECT_EQ(slid.deflected, 1);
        ++deflected;
      } else if (lost < 0.05) {
        EXPECT_EQ(slid.deflected, 0);
      }
    }
  EXPECT_GT(deflected, 16) << "Bullet has become better";
}

TEST(TiledGround, OfOnePieceDeflectsNothing) {
  for (const char* slider : kSlidingTypes) {
    SCOPED_TRACE(slider);
    const Slid slid = SlideOver(
        "quantity 1; type cuboid; size 20; aspect 1 : 0.05 : 1; location at(0, -0.5, 0)", slider);
    EXPECT_NEAR(slid.velocity.x(), 7, 1e-3);
    EXPECT_EQ(slid.false_normals, 0);
    EXPECT_EQ(slid.verdict, protocol::Verdict::kStable);
  }
}

TEST(TiledGround, DownStepsHasTheNormalsOfTheirEdges) {
  for (const char* slider : kSlidingTypes) {
    SCOPED_TRACE(slider);
    const Slid slid = SlideOver(Tiles(0.3), slider);
    EXPECT_EQ(slid.deflected, 0);
  }
}

}  // namespace
}  // namespace cdb::tests
