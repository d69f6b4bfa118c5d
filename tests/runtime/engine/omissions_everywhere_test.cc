// Every scenario shipped with cdb, scaled down, and random scenes: with and without omissions, the
// state of each object is the same after every cycle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/soft.h"
#include "compiler/compile.h"
#include "dsl/diagnostics.h"
#include "library/layouts/pose_table.h"
#include "library/objects/models.h"
#include "library/objects/solid_factory.h"
#include "library/robots/reader.h"
#include "library/scene_error.h"
#include "tests/runtime/engine/paired_run.h"
#include "tests/support/diagnostics.h"
#include "tests/support/folders.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::Component;
using schema::WordList;

/// The number of times that each component was kept and left out.
using Tally = std::map<Component, std::array<int, 2>>;

void Count(const PairedRun& paired, Tally& tally) {
  for (const analysis::PruningDecision& part : paired.omissions.decisions)
    ++tally[part.component][part.decision == analysis::Decision::kLeftOut ? 0 : 1];
}

std::vector<std::string> ShippedScenarios() {
  std::vector<std::string> files;
  for (const char* folder : {"examples", "library", "tests/bench"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(SourceFolder() / folder))
      if (entry.path().extension() == ".cdb" &&
          entry.path().string().find("/my_detector/") ==
              std::string::npos)  // its plug-ins are not built here
        files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

/// Decomposing a model takes seconds for each aspect.
bool HasModel(const plan::Group& group) {
  const std::string type = schema::ToText(group.settings.Get("type"));
  return std::ranges::any_of(objects::Models(), [&](const objects::Model& model) {
    return type.find(model.name) != std::string::npos;
  });
}

/// Versions of the scene with few objects and cycles: one as large as the original, with long
/// distances to the walls, and one as dense, with its contacts.
std::vector<plan::Scene> ScaledDown(plan::Scene scene) {
  constexpr double kMostObjects = 40;
  constexpr std::uint64_t kMostCycles = 100;
  const auto objects = static_cast<double>(scene.ObjectCount());
  const double part = std::min(1.0, kMostObjects / std::max(objects, 1.0));
  for (plan::Group& group : scene.groups) {
    const auto quantity = static_cast<double>(group.settings.Count("quantity"));
    group.settings.Set("quantity", static_cast<std::uint64_t>(std::ceil(part * quantity)));
    if (HasModel(group)) group.settings.Set("aspect", schema::Ratio{{1, 1, 1}});
  }
  SetWorld(scene, "cycles", std::min(kMostCycles, scene.world.Count("cycles")));
  SetWorld(scene, "warmup", std::min<std::uint64_t>(2, scene.world.Count("warmup")));
  SetWorld(scene, "precision", Word(world::EnginePrecision()));
  SetWorld(scene, "omit", WordList{"auto"});
  std::vector<plan::Scene> scenes = {scene};
  if (part < 1) {
    SetWorld(scene, "world.side", scene.world.Real("world.side") * std::cbrt(part));
    scenes.push_back(scene);
  }
  // Components that no recording needs may be omitted as well.
  SetWorld(scene, "record", WordList{"energy"});
  scenes.push_back(scene);
  return scenes;
}

/// The scene without pairs of planes that no box reaches, in Bullet's own broad phase; empty if it
/// needs them.
std::optional<plan::Scene> WithoutWallPairs(plan::Scene scene, const layouts::InitialState& state) {
  SetWorld(scene, "pair_order", Word("sorted"));
  SetWorld(scene, "detector", Word("dbvt"));
  SetWorld(scene, "narrow_phase", Word("bullet"));
  SetWorld(scene, "omit", WordList{"wall_pairs"});
  if (analysis::AnalysePruning(scene).back().decision == analysis::Decision::kKept)
    return std::nullopt;
  try {
    omissions::DecideOmissions(scene, state);
  } catch (const library::SceneError&) {
    return std::nullopt;
  }
  return scene;
}

TEST(OmitEverywhere, EveryShippedScenarioMovesAlike) {
  // Single and double precision alternate. The ordinary build compares the states; sanitizers check
  // the same code in fewer runs.
  constexpr std::size_t kMostRunsOfAPlan = kAddressSanitizer ? 1 : 10;
  Tally tally;
  std::size_t plans = 0, turn = 0;
  std::set<std::string> tried;  // scenarios share runs, and more of them are equal after scaling
  for (const std::string& file : ShippedScenarios()) {
    SCOPED_TRACE(file);
    const auto result = compiler::Compile(file, compiler::ReadFromDisk,
                                          {SourceFolder() / "library/scenarios",
                                           std::nullopt,
                                           {},
                                           {},
                                           {},
                                           layouts::ReadPoseFacts,
                                           objects::ModelReader({.decomposes = false}),
                                           robots::ReadRobot});
    if (LacksOnlyLibraries(result.diagnostics)) continue;
    ASSERT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
    for (const plan::Plan& plan : result.plans) {
      if (analysis::HasConfigurations(plan.runs[0].scene)) continue;  // nothing moves
      if (analysis::HasSoft(plan.runs[0].scene)) continue;            // nothing is omitted
      ++plans;
      bool is_cut = false;  // once for each plan
      const std::size_t stride = std::max<std::size_t>(1, plan.runs.size() / kMostRunsOfAPlan);
      for (std::size_t i = 0; i < plan.runs.size(); i += stride) {
        if ((turn++ % 2 == 0) != kIsSingle) continue;
        SCOPED_TRACE(plan::Describe(plan, plan.runs[i]));
        for (const plan::Scene& scene : ScaledDown(plan.runs[i].scene)) {
          if (!tried.insert(plan::RunId(scene, 0)).second) continue;
          layouts::InitialState state;
          try {
            state = layouts::MakeInitialState(scene);
          } catch (const library::SceneError&) {
            continue;  // too crowded at this scale
          }
          Count(RunPaired(scene, state), tally);
          if (std::exchange(is_cut, true)) continue;
          if (const auto cut = WithoutWallPairs(scene, state)) Count(RunPaired(*cut, state), tally);
        }
      }
    }
  }
  EXPECT_GT(plans, 10u);
  EXPECT_GT(tally[Component::kWalls][0], 0);
  EXPECT_GT(tally[Component::kWalls][1], 0);
  EXPECT_GT(tally[Component::kWallPairs][0], 10);
}

class SceneAtRandom {
 public:
  explicit SceneAtRandom(unsigned seed) : random_(seed) {}

  plan::Scene Make() {
    plan::Scene scene = EngineScene(1 + Below(25), 0);
    const double size = Log(1, 100);
    const auto quantity = static_cast<double>(scene.ObjectCount());
    SetWorld(scene, "world.side", size * std::cbrt(quantity) * Log(1.8, 400));
    SetWorld(scene, "cycles", std::uint64_t{20 + Below(150)});
    SetWorld(scene, "timestep", Chance(0.7) ? 1.0 / 60 : Log(1e-3, 0.1));
    SetWorld(scene, "acceleration",
             Chance(0.4) ? Vector3d(0, 0, 0) : Direction() * size * Log(0.01, 3));
    SetWorld(scene, "world.walls", Word(Pick({"all", "all", "floor", "none"})));
    SetWorld(scene, "world.wall_shape", Word(Pick({"plane", "plane", "box"})));
    SetWorld(scene, "detector", Word(Pick({"simple", "sap", "sap32", "dbvt"})));
    SetWorld(scene, "contact", Word(Pick({"bullet", "faithful"})));
    SetWorld(scene, "sleeping", Chance(0.7));
    SetWorld(scene, "record", Chance(0.5) ? WordList{"energy"} : WordList{"timing"});
    SetGroup(scene, "size", Chance(0.5) ? schema::Value(size) : Uniform(size / 2, size * 1.5));
    SetGroup(scene, "type",
             Chance(0.5) ? AnyType()
                         : Word(Pick({"sphere", "cuboid", "cone", "capsule", "tetrahedron"})));
    if (Chance(0.3)) SetGroup(scene, "orientation", Word("random"));
    if (Chance(0.6)) SetGroup(scene, "linear_velocity", Normal(0.0, size * Log(0.01, 3)));
    if (Chance(0.4)) SetGroup(scene, "angular_velocity", Normal(0.0, Log(0.1, 30)));
    if (Chance(0.3))
      SetGroup(scene, "mass",
               schema::Distribution{schema::DistributionKind::kLogUniform, {0.01, 100.0}, {}});
    SetGroup(scene, "restitution", Chance(0.5) ? 1.0 : 0.3);
    SetGroup(scene, "friction", Chance(0.5) ? 0.0 : 0.5);
    if (Chance(0.2)) SetGroup(scene, "linear_damping", 0.3);
    if (Chance(0.2)) SetGroup(scene, "angular_damping", 0.3);
    if (Chance(0.2)) {
      plan::Group fixed = scene.groups[0];
      fixed.name = "fixed";
      fixed.settings.Set("mass", Word("fixed"));
      fixed.settings.Set("quantity", std::uint64_t{1 + Below(4)});
      scene.groups.push_back(std::move(fixed));
    }
    if (Chance(0.05)) SetGroup(scene, "ccd", true);
    if (Chance(0.1)) SetGroup(scene, "contact_stiffness", 1e4);
    if (Chance(0.05)) {
      SetGroup(scene, "links.type", Word(Pick({"ball", "hinge", "fixed", "spring"})));
      SetGroup(scene, "links.stiffness", Log(1, 1e4));
      SetGroup(scene, "links.anchor",
               Chance(0.5) || scene.groups[0].settings.Count("quantity") == 1);
    }
    if (Chance(0.05)) {
      scene.joints.push_back({"joints", {}});
      plan::GroupSettings& joint = scene.joints[0].settings;
      joint.Set("joints.child", Word(scene.groups[0].name));
      joint.Set("joints.type", Word(Pick({"ball", "hinge", "fixed", "slider"})));
      joint.Set("joints.at", Vector3d(size * Unit(), size * Unit(), 0));
    }
    SeedStreams(scene, random_());
    return scene;
  }

 private:
  double Unit() { return static_cast<double>(random_()) / 4294967296.0; }
  std::uint64_t Below(std::uint64_t n) { return random_() % n; }
  bool Chance(double p) { return Unit() < p; }
  double Log(double a, double b) { return a * std::pow(b / a, Unit()); }
  const char* Pick(std::initializer_list<const char*> words) {
    return *(words.begin() + Below(words.size()));
  }
  Vector3d Direction() {
    switch (Below(3)) {
      case 0:
        return {0, -1, 0};
      case 1:
        return {Unit() - 0.5, Unit() - 0.5, Unit() - 0.5};
      default:
        return Vector3d::Unit(static_cast<int>(Below(3)));
    }
  }

  std::mt19937 random_;  // its numbers are the same everywhere
};

TEST(OmitEverywhere, ScenesAtRandomMoveAlike) {
  // For more scenes: CDB_RANDOM_SCENES=100000.
  const char* asked = std::getenv("CDB_RANDOM_SCENES");
  const int scenes = asked != nullptr ? std::atoi(asked) : kAddressSanitizer ? 150 : 400;
  Tally tally;
  int tripped = 0, ran = 0;
  for (int seed = 0; seed < scenes; ++seed) {
    SCOPED_TRACE(seed);
    const plan::Scene scene = SceneAtRandom(static_cast<unsigned>(seed)).Make();
    layouts::InitialState state;
    try {
      state = layouts::MakeInitialState(scene);
    } catch (const library::SceneError&) {
      continue;
    }
    const PairedRun paired = RunPaired(scene, state);
    ++ran;
    tripped += paired.tripped.has_value();
    if (paired.tripped && paired.tripped->find("proven not to reach") != std::string::npos)
      ADD_FAILURE() << *paired.tripped << " before step " << paired.tripped_in + 1;
    Count(paired, tally);
    if (HasFailure()) break;
  }
  // Both outcomes are common, so that the comparison is meaningful.
  EXPECT_GT(ran, scenes * 9 / 10);
  for (const auto& [component, counts] : tally) {
    // No scene needs motion states, and none of these small ones needs all of the pools; pairs with
    // walls are omitted only by name.
    if (component == Component::kMotionStates || component == Component::kPools ||
        component == Component::kWallPairs)
      continue;
    EXPECT_GT(counts[0], ran / 50) << schema::InfoOf(component).name << " is never left out";
    EXPECT_GT(counts[1], ran / 50) << schema::InfoOf(component).name << " is always left out";
  }
  EXPECT_LT(tripped, ran / 10);
  std::printf("%d scenes, %d tripped\n", ran, tripped);
  for (const auto& [component, counts] : tally)
    std::printf("  %-16s left out %4d, not %4d\n",
                std::string(schema::InfoOf(component).name).c_str(), counts[0], counts[1]);
}

}  // namespace
}  // namespace cdb::tests
