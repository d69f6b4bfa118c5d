// What the lints foretell is what runs come to.
#include "compiler/lints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "runtime/measure/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/random_scenes.h"

namespace cdb::test {
namespace {

TEST(Lints, Dump) {
  const std::uint64_t seed = std::getenv("SEED") ? std::stoull(std::getenv("SEED")) : 1;
  const std::size_t count = std::getenv("COUNT") ? std::stoull(std::getenv("COUNT")) : 300;
  for (const RandomScene& random : RandomScenes(count, seed)) {
    Recorded recorded = RunHere(random.scene);
    if (!recorded.done()) {
      std::printf("D|%s|failed|%s\n", std::string(random.theme).c_str(), recorded.message().c_str());
      continue;
    }
    const auto judged = runtime::Judge(random.scene, recorded.recording,
                                       recorded.header().cycles_done.load());
    std::printf("D|%s|%s|%ld|", std::string(random.theme).c_str(),
                std::string(runtime::VerdictName(judged.verdict)).c_str(), judged.first_bad_cycle);
    for (const auto& number : compiler::LintScene(random.scene))
      std::printf("%s=%.4g ", std::string(compiler::InfoOf(number.lint).kind.id).c_str(),
                  number.Severity());
    std::printf("|");
    for (const char* name : {"cycles", "timestep", "solver.iterations", "world.side", "acceleration", "world.wall_shape", "world.walls"})
      std::printf("%s=%s ", name, ToText(random.scene.world.Get(name)).c_str());
    for (const auto& group : random.scene.groups)
      for (const char* name : {"quantity", "type", "size", "aspect", "mass", "location", "linear_velocity", "angular_velocity", "restitution", "contact_stiffness", "contact_damping", "ccd"})
        std::printf("%s=%s ", name, ToText(group.settings.Get(name)).c_str());
    std::printf("\n");
    if (std::getenv("SERIES") && judged.verdict == runtime::Verdict::kStable && random.theme == std::getenv("SERIES")) {
      bool bad = false;
      for (const auto& number : compiler::LintScene(random.scene)) bad = bad || number.IsBad();
      if (!bad) continue;
      for (const char* name : {"motion_ratio", "fall_ratio", "displacement", "penetration_ratio", "max_speed", "energy"}) {
        const auto v = recorded.recording.Reals(name);
        std::printf("  %s", name);
        for (std::size_t i = 0; i < v.size(); i = i < 8 ? i + 1 : i * 2) std::printf(" %.3g", v[i]);
        std::printf("\n");
      }
      for (const char* name : {"contacts", "asleep", "escaped"}) {
        const auto v = recorded.recording.Ints(name);
        std::printf("  %s", name);
        for (std::size_t i = 0; i < v.size(); i = i < 8 ? i + 1 : i * 2) std::printf(" %d", v[i]);
        std::printf("\n");
      }
      std::printf("  scale %.3g speed %.3g\n", recorded.header().energy_scale, recorded.header().speed_scale);
    }
  }
}

}  // namespace
}  // namespace cdb::test
