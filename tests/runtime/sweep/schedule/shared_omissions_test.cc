#include "runtime/sweep/schedule/schedule.h"

#include <gtest/gtest.h>

#include "tests/runtime/sweep/schedule/plans.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

constexpr const char* kKept = "walls: kept: reached\n";
constexpr const char* kLeftOut = "walls: left out: far away\n";

plan::Run RunOf(plan::Scene scene, std::uint64_t rep = 0) {
  plan::Run run;
  run.id = plan::RunId(scene, rep);
  run.rep = rep;
  run.scene = std::move(scene);
  return run;
}

TEST(SharedOmissions, CompareWhatTheMeasurementIsAbout) {
  const plan::Run needy = RunOf(DefaultScene(10, 100));
  schedule::SharedOmissions shared;
  shared.Note(needy, "", kKept);
  plan::Scene detector = needy.scene, narrow = needy.scene, order = needy.scene,
              threads = needy.scene, seed = needy.scene;
  SetWorld(detector, "detector", Word("sap"));
  SetWorld(narrow, "narrow_phase", Word("bullet"));
  SetWorld(order, "pair_order", Word("sorted"));
  SetWorld(threads, "threads", std::uint64_t{2});
  SetWorld(seed, "seed", std::uint64_t{7});
  SeedStreams(seed, 7);
  for (const plan::Scene& scene : {detector, narrow, order, threads, seed})
    EXPECT_EQ(shared.KeptFor(RunOf(scene)), "walls");
  EXPECT_EQ(shared.KeptFor(RunOf(needy.scene, 1)), "walls");

  plan::Scene step = needy.scene, precision = needy.scene, list = needy.scene;
  SetWorld(step, "timestep", 0.01);
  SetWorld(precision, "precision", Word("double"));
  for (const plan::Scene& scene : {step, precision, DefaultScene(11, 100)})
    EXPECT_EQ(shared.KeptFor(RunOf(scene)), "");
}

TEST(SharedOmissions, OutdateWhatWasMeasuredWithout) {
  const plan::Run first = RunOf(DefaultScene(10, 100), 0), second = RunOf(first.scene, 1);
  schedule::SharedOmissions shared;
  shared.Note(first, "walls", kLeftOut);
  EXPECT_EQ(shared.MissingIn(first), "");
  shared.Note(second, "", kKept);
  EXPECT_EQ(shared.MissingIn(first), "walls");
  EXPECT_EQ(shared.MissingIn(second), "");
  shared.Note(first, "", kKept);
  EXPECT_EQ(shared.MissingIn(first), "");
}

TEST(SharedOmissions, LeaveAloneWhatIsInvisibleOrAskedForByName) {
  const plan::Run first = RunOf(DefaultScene(10, 100), 0), second = RunOf(first.scene, 1);
  schedule::SharedOmissions shared;
  shared.Note(first, "pools", "pools: left out: few\n");
  shared.Note(second, "", "pools: kept: many\n");
  EXPECT_EQ(shared.MissingIn(first), "");

  plan::Scene named = first.scene;
  SetWorld(named, "omit", schema::WordList{"walls"});
  shared.Note(RunOf(named), "walls", kLeftOut);
  EXPECT_EQ(shared.MissingIn(RunOf(named)), "");
}

}  // namespace
}  // namespace cdb::tests
