// Compiled by named_parameters_test.py, which defines at most one of the macros: without one it
// compiles, with any of them it does not.
#include "compiler/plan/plan.h"

namespace cdb::tests {

double Read(const plan::Scene& scene) {
  const plan::WorldSettings& world = scene.world;
  const plan::GroupSettings& objects = scene.groups[0].settings;
#if defined(MISSPELT_PARAMETER)
  return world.Real("timestop");
#elif defined(MISSPELT_GET)
  return world.Get("Timestep").index();
#elif defined(WORLD_FROM_GROUP)
  return objects.Real("timestep");
#elif defined(GROUP_FROM_WORLD)
  return world.Real("size");
#elif defined(REAL_OF_WORD)
  return world.Real("detector");
#elif defined(COUNT_OF_SWITCH)
  return world.Count("sleeping");
#elif defined(COUNT_OF_REAL)
  return world.Count("timestep");
#elif defined(SWITCH_OF_COUNT)
  return world.On("cycles");
#elif defined(WORD_OF_REAL)
  return world.WordOr("timestep").size();
#elif defined(WORD_OF_LIST)
  return world.WordOr("record").size();
#elif defined(VECTOR_OF_REAL)
  return objects.Vector("size").x();
#elif defined(LIST_OF_WORD)
  return world.Lists("detector", "dbvt");
#elif defined(MISSPELT_SET)
  plan::Scene changed = scene;
  changed.world.Set("cycle", std::uint64_t{1});
  return 0;
#elif defined(RUN_TIME_NAME)
  const std::string name = "timestep";
  return world.Real(name.c_str());
#else
  return world.Real("timestep") + world.Real("cycles") + objects.Real("size") +
         static_cast<double>(world.Count("cycles")) + (world.On("sleeping") ? 1 : 0) +
         static_cast<double>(world.WordOr("timeout").size() + objects.WordOr("mass").size()) +
         world.Vector("acceleration").x() + (world.Lists("record", "timing") ? 1 : 0);
#endif
}

}  // namespace cdb::tests
