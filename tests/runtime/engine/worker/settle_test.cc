// Piles come to rest before the first cycle, and are the same for every run of a sweep.
#include "runtime/engine/worker/settle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "library/objects/distance.h"
#include "library/scene_error.h"
#include "runtime/engine/world/manifolds.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/cache.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::Call;

class Pile : public testing::Test {
 protected:
  TemporaryCache cache_;
};

plan::Scene PileScene(std::uint64_t quantity, double side = 40) {
  plan::Scene scene = EngineScene(quantity, side);
  SetWorld(scene, "cycles", std::uint64_t{60});
  SetGroup(scene, "type", AnyType());
  SetGroup(scene, "size", 1.0);
  SetGroup(scene, "orientation", Word("random"));
  SetGroup(scene, "location", Call{"pile", {Word("fit")}});
  SeedStreams(scene);
  return scene;
}

layouts::InitialState Settled(const plan::Scene& scene) {
  layouts::InitialState state = layouts::MakeInitialState(scene);
  worker::SettlePiles(scene, state);
  return state;
}

std::string RefusalOf(const plan::Scene& scene) {
  try {
    Settled(scene);
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "";
}

TEST_F(Pile, LiesOnTheFloorAndOverlapsHardly) {
  const plan::Scene scene = PileScene(60);
  const layouts::InitialState state = Settled(scene);
  double highest = -20;
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const auto& a = state.objects[i];
    const objects::Box box = objects::Bounds(a.solid, a.pose.orientation);
    EXPECT_GT(a.pose.position.y() + box.lower.y(), -20.02);
    highest = std::max(highest, a.pose.position.y() + box.upper.y());
    objects::Solid smaller = a.solid;
    smaller.sides *= 0.9;  // Bullet rounds edges by its margin
    for (std::size_t k = 0; k < i; ++k) {
      const auto& b = state.objects[k];
      EXPECT_FALSE(objects::Overlap(smaller, a.pose, b.solid, b.pose)) << i << " and " << k;
    }
  }
  // A heap, not the lattice of about 7 m from which they were dropped.
  EXPECT_GT(highest, -19);
  EXPECT_LT(highest, -15);
}

TEST_F(Pile, SettlesBesideWhatMovesLater) {
  plan::Scene scene = PileScene(20);
  const std::size_t group = AddGroup(scene, "stirrer", 1, Points({{0, -10, 0}}));
  SetGroup(scene, "mass", Word("fixed"), group);
  SeedStreams(scene);
  const layouts::InitialState still = Settled(scene);
  SetGroup(scene, "mass", Word("kinematic"), group);
  SetGroup(scene, "linear_velocity", Vector3d(0, -1, 0), group);
  const layouts::InitialState moving = Settled(scene);
  for (std::size_t i = 0; i < still.objects.size(); ++i)
    EXPECT_EQ(moving.objects[i].pose.position, still.objects[i].pose.position) << i;
}

struct PileType {
  const char* name;
  schema::Value type;
  Vector3d aspect = Vector3d::Ones();
};

std::vector<PileType> PileTypes() {
  return {{"mixed", AnyType()},
          {"sphere", Word("sphere")},
          {"cylinder", Word("cylinder")},
          {"cuboid", Word("cuboid")},
          {"flat", Word("cuboid"), {1, 0.3, 1}}};
}

plan::Scene PileScene(const PileType& type, std::uint64_t quantity) {
  plan::Scene scene = PileScene(quantity);
  SetGroup(scene, "type", type.type);
  SetGroup(scene, "aspect", schema::Ratio{type.aspect});
  return scene;
}

/// True if the object, moved down by `lower` m, overlaps another one or the floor.
bool IsHeldFromBelow(const layouts::InitialState& state, std::size_t i, double lower) {
  const auto& object = state.objects[i];
  objects::Pose pose = object.pose;
  pose.position.y() -= lower;
  const objects::Box box = objects::Bounds(object.solid, pose.orientation);
  if (pose.position.y() + box.lower.y() <= -20) return true;
  for (std::size_t k = 0; k < state.objects.size(); ++k)
    if (k != i &&
        objects::Overlap(object.solid, pose, state.objects[k].solid, state.objects[k].pose))
      return true;
  return false;
}

TEST_F(Pile, LeavesNothingInTheAir) {
  for (const PileType& type : PileTypes()) {
    const layouts::InitialState state = Settled(PileScene(type, 60));
    for (std::size_t i = 0; i < state.objects.size(); ++i)
      EXPECT_TRUE(IsHeldFromBelow(state, i, 0.05)) << type.name << " " << i;
  }
}

double DeepestContact(world::Engine& engine) {
  double deepest = 0;
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine.world()))
    for (int i = 0; i < manifold.getNumContacts(); ++i)
      deepest = std::max(deepest, -static_cast<double>(manifold.getContactPoint(i).getDistance()));
  return deepest;
}

/// Runs for a second, and returns the number of objects of which a point went farther than a tenth
/// of the least side.
int CountMoved(const plan::Scene& scene, const layouts::InitialState& state) {
  world::Engine engine = WholeEngine(scene, state);
  double deepest = 0;
  for (double time = 0; time < 1; time += scene.world.Real("timestep")) {
    engine.Step();
    deepest = std::max(deepest, DeepestContact(engine));
  }
  EXPECT_LT(deepest, 0.05 * scene.groups[0].settings.Real("size"));
  int moved = 0;
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const objects::Solid& solid = state.objects[i].solid;
    const Eigen::Quaterniond turn =
        Orientation(engine, i) * state.objects[i].pose.orientation.conjugate();
    const double way = (Position(engine, i) - state.objects[i].pose.position).norm() +
                       solid.OuterRadius() * 2 * turn.vec().norm();
    moved += way > 0.15 * 2 * solid.LeastHalfExtent();
  }
  return moved;
}

TEST_F(Pile, StaysWhereItIs) {
  for (const PileType& type : PileTypes()) {
    plan::Scene scene = PileScene(type, 60);
    SetWorld(scene, "sleeping", false);
    EXPECT_EQ(CountMoved(scene, Settled(scene)), 0) << type.name;
  }
}

TEST_F(Pile, StaysWhereItIsWithTheSettingsOfTheRun) {
  plan::Scene scene = PileScene(60);
  SetWorld(scene, "sleeping", false);
  SetWorld(scene, "timestep", 1.0 / 120);
  SetWorld(scene, "contact", Word("faithful"));
  SetWorld(scene, "solver.iterations", std::uint64_t{4});
  SetGroup(scene, "margin", 0.01);
  SetGroup(scene, "friction", 0.8);
  EXPECT_EQ(CountMoved(scene, Settled(scene)), 0);
}

TEST_F(Pile, StaysWhereItIsAtEveryScale) {
  for (const double scale : {0.05, 50.0}) {
    plan::Scene scene = PileScene(40, 40 * scale);
    SetWorld(scene, "sleeping", false);
    SetWorld(scene, "timestep", std::min(1.0 / 60, std::sqrt(scale) / 60));
    SetGroup(scene, "size", scale);
    SetGroup(scene, "margin", 0.02 * scale);
    EXPECT_EQ(CountMoved(scene, Settled(scene)), 0) << scale;
  }
}

TEST_F(Pile, OfOneCubeBeginsOnTheFloor) {
  plan::Scene scene = PileScene(1);
  SetGroup(scene, "type", Word("cuboid"));
  SetGroup(scene, "orientation", Vector3d(0, 0, 0));
  const layouts::InitialState state = Settled(scene);
  EXPECT_NEAR(state.objects[0].pose.position.y(), -19.5, 2e-4);
  // It does have speed: Bullet finds only one contact with the floor in the first cycle.
  world::Engine engine = WholeEngine(scene, state);
  for (int step = 0; step < 60; ++step) {
    engine.Step();
    EXPECT_NEAR(Position(engine).y(), -19.5, 3e-3) << step;
  }
}

TEST_F(Pile, ThatNeverRestsIsRefusedUnlessItMayMove) {
  plan::Scene scene = PileScene(20);
  SetGroup(scene, "aspect", schema::Ratio{{1, 0.02, 1}});
  SetWorld(scene, "timestep", 1.0 / 15);
  const std::string refusal = RefusalOf(scene);
  EXPECT_NE(refusal.find("of 20 objects still move"), std::string::npos) << refusal;
  SetWorld(scene, "expect", Word("anything"));
  EXPECT_EQ(RefusalOf(scene), "");
}

void ExpectSamePoses(const layouts::InitialState& first, const layouts::InitialState& second) {
  for (std::size_t i = 0; i < first.objects.size(); ++i) {
    EXPECT_EQ(first.objects[i].pose.position, second.objects[i].pose.position) << i;
    EXPECT_EQ(first.objects[i].pose.orientation.coeffs(),
              second.objects[i].pose.orientation.coeffs())
        << i;
  }
}

TEST_F(Pile, IsTheSameForEveryDetector) {
  plan::Scene scene = PileScene(20);
  const layouts::InitialState first = Settled(scene);
  SetWorld(scene, "detector", Word("sap32"));
  SetWorld(scene, "omit", schema::WordList{"none"});
  // Settles again, not from the cache.
  for (const auto& entry : cache_.Entries()) std::filesystem::remove(entry);
  ExpectSamePoses(first, Settled(scene));
}

TEST_F(Pile, IsTheSameForRunsThatAreComparedWithAReference) {
  plan::Scene scene = PileScene(20);
  SetWorld(scene, "accuracy.metrics", schema::WordList{"position"});
  const layouts::InitialState first = Settled(scene);
  SetWorld(scene, "precision", Word(kIsSingle ? "double" : "single"));
  SetWorld(scene, "timestep", 1e-3);
  SetWorld(scene, "solver.iterations", std::uint64_t{50});
  for (const auto& entry : cache_.Entries()) std::filesystem::remove(entry);
  ExpectSamePoses(first, Settled(scene));
  EXPECT_EQ(cache_.Entries().size(), 2u);
  scene.role = plan::Role::kReference;
  ExpectSamePoses(first, Settled(scene));
  EXPECT_EQ(cache_.Entries().size(), 2u);
}

TEST_F(Pile, IsSettledOnceAndThenFound) {
  plan::Scene scene = PileScene(5);
  const auto files = [&] { return cache_.Entries().size(); };
  const layouts::InitialState first = Settled(scene);
  EXPECT_EQ(files(), 2u) << "the drop and the pile";
  SetWorld(scene, "cycles", std::uint64_t{7});
  const layouts::InitialState found = Settled(scene);
  EXPECT_EQ(files(), 2u);
  EXPECT_EQ(first.objects[4].pose.position, found.objects[4].pose.position);
  SetGroup(scene, "friction", 0.9);
  Settled(scene);
  EXPECT_EQ(files(), 4u) << "another pile";
}

TEST_F(Pile, IsSharedByScenesThatDifferInWhatDoesNotDecideIt) {
  plan::Scene scene = PileScene(5);
  Settled(scene);
  SetGroup(scene, "linear_velocity", Normal(Vector3d(0, 0, 0), Vector3d(1, 1, 1)));
  SetWorld(scene, "sleeping", false);
  SeedStreams(scene);
  Settled(scene);
  EXPECT_EQ(cache_.Entries().size(), 2u);
  // Comes to rest with other settings, after the same drop.
  SetGroup(scene, "restitution", 0.5);
  SetWorld(scene, "solver.iterations", std::uint64_t{50});
  SetWorld(scene, "timestep", 5e-3);
  Settled(scene);
  EXPECT_EQ(cache_.Entries().size(), 3u);
}

TEST_F(Pile, ADamagedEntryOfTheCacheIsSettledAgain) {
  const plan::Scene scene = PileScene(5);
  const layouts::InitialState first = Settled(scene);
  for (const std::filesystem::path& file : cache_.Entries())
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(200).put('\x5a');
  const layouts::InitialState second = Settled(scene);
  EXPECT_EQ(first.objects[4].pose.position, second.objects[4].pose.position);
}

TEST_F(Pile, TellsHowFarItIs) {
  const plan::Scene scene = PileScene(5);
  std::vector<worker::SettlingProgress> told;
  const auto listen = [&](const worker::SettlingProgress& progress) { told.push_back(progress); };
  layouts::InitialState state = layouts::MakeInitialState(scene);
  worker::SettlePiles(scene, state, listen);
  ASSERT_GE(told.size(), 2u);
  EXPECT_EQ(told.front().phase, protocol::SettlingPhase::kSettling);
  EXPECT_EQ(told.front().at_rest, 0u);
  EXPECT_EQ(told.back().at_rest, 5u);
  EXPECT_EQ(told.back().objects, 5u);
  told.clear();
  state = layouts::MakeInitialState(scene);
  worker::SettlePiles(scene, state, listen);
  EXPECT_TRUE(told.empty()) << "it was found";
}

TEST_F(Pile, RunsFromTheStart) {
  plan::Scene scene = PileScene(20);
  const Recorded pruned = RunHere(scene);
  ASSERT_TRUE(pruned.done()) << pruned.message();
  EXPECT_NE(pruned.header().decisions.str().find("objects settle before the first cycle"),
            std::string::npos);
  SetWorld(scene, "omit", schema::WordList{"none"});
  EXPECT_EQ(RunHere(scene).hash(), pruned.hash());
}

TEST_F(Pile, WantsAFloorGravityAndThatItsObjectsMove) {
  plan::Scene scene = PileScene(5);
  SetWorld(scene, "world.walls", Word("none"));
  EXPECT_EQ(RefusalOf(scene), "a pile needs a floor: set world.walls to floor or all");
  scene = PileScene(5);
  SetWorld(scene, "acceleration", Vector3d(0, 1, 0));
  EXPECT_EQ(RefusalOf(scene),
            "a pile needs an acceleration that points down to the floor, such as (0, -9.8, 0)");
  scene = PileScene(5);
  SetGroup(scene, "mass", Word("fixed"));
  EXPECT_EQ(RefusalOf(scene),
            "the objects of group `objects` are fixed and cannot settle into a pile; give them a "
            "mass, or another layout");
}

}  // namespace
}  // namespace cdb::tests
