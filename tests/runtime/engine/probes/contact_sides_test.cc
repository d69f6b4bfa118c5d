// Depths of contacts in sides of the piece that is touched.
#include "runtime/engine/probes/contact_sides.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// A cube of 1 m with a fin of 0.02 m on top, turned about z, falls on the floor, with `more`.
plan::Scene FinScene(const std::string& narrow_phase, const std::string& turn,
                     const std::string& more = "") {
  const compiler::Compilation compiled = CompileText(fmt::format(
      "benchmark b {{ precision {}; record stability; narrow_phase {}; cycles 20\n"
      "world {{ side 20; walls floor }}\n"
      "objects finned {{ quantity 1; size native; mass 1\n"
      "type compound(part(cuboid, (1, 1, 1)), part(cuboid, (0.02, 1, 0.5), at: (0, 0.99, 0)))\n"
      "location at(0, -8, 0); orientation {}; linear_velocity (0, -12, 0) }} {} }}",
      world::EnginePrecision(), narrow_phase, turn, more));
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  return compiled.plans.at(0).runs.at(0).scene;
}

/// m: the first depth divided by its ratio.
double SideOf(const plan::Scene& scene) {
  const Recorded run = RunHere(scene);
  const auto depths = run.recording.Reals("max_penetration");
  const auto first = std::ranges::find_if(depths, [](double depth) { return depth > 0; });
  EXPECT_NE(first, depths.end()) << run.message();
  if (first == depths.end()) return 0;
  return *first / *(run.recording.Reals("penetration_ratio").begin() + (first - depths.begin()));
}

TEST(ContactSides, AreThoseOfThePieceThatIsTouched) {
  for (const char* narrow_phase : {"bullet", "batch"}) {
    EXPECT_NEAR(SideOf(FinScene(narrow_phase, "(0, 0, 0)")), 1, 1e-6) << narrow_phase;
    EXPECT_NEAR(SideOf(FinScene(narrow_phase, "(0, 0, 0.3)")), 1, 1e-6) << narrow_phase;
    EXPECT_NEAR(SideOf(FinScene(narrow_phase, "(0, 0, pi)")), 0.02, 1e-6) << narrow_phase;
  }
}

TEST(ContactSides, OfTwoObjectsAreThoseOfTheSmaller) {
  const char* ball =
      "objects ball { quantity 1; type sphere; size 0.4; mass 1\n"
      "location at(0.3, -6.5, 0); linear_velocity (0, -22, 0) }";
  for (const char* narrow_phase : {"bullet", "batch"})
    EXPECT_NEAR(SideOf(FinScene(narrow_phase, "(0, 0, 0)", ball)), 0.4, 1e-6) << narrow_phase;
}

TEST(ContactSides, AreThoseOfThePieceAroundAPoint) {
  const plan::Scene scene = FinScene("bullet", "(0, 0, 0)");
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const objects::Compound& compound = *state.objects.at(0).solid.compound;
  const layouts::ObjectState& object = state.objects.at(0);
  const auto side_at = [&](const Vector3d& point) {
    const Vector3d place(0, -8, 0);
    return probes::TouchedSide(
        compound, object.pose.orientation.conjugate() * (place + point - object.pose.position));
  };
  EXPECT_NEAR(side_at({0.5, -0.5, 0.5}), 1, 1e-9) << "a corner of the cube";
  EXPECT_NEAR(side_at({0.52, 0, 0.1}), 1, 1e-9) << "a margin beside it";
  EXPECT_NEAR(side_at({0.01, 1.49, 0.25}), 0.02, 1e-9) << "a corner of the fin";
  EXPECT_NEAR(side_at({0, 0.5, 0}), 0.02, 1e-9) << "in both: the thinner one";
  EXPECT_NEAR(side_at({3, 3, 3}), 0.02, 1e-9) << "in none: the thinnest one";
}

}  // namespace
}  // namespace cdb::tests
