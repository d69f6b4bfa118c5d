// Scenes for tests: the schema's defaults, and what a test changes.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "compiler/plan.h"

namespace cdb::test {

/// Every parameter at its default, `quantity` objects in a cube of `side` m, 10 cycles; streams for
/// everything that may be drawn.
compiler::Scene DefaultScene(std::uint64_t quantity, double side);

inline compiler::Value Uniform(compiler::Value a, compiler::Value b) {
  return compiler::Distribution{compiler::DistributionKind::kUniform, {a, b}, {}};
}
inline compiler::Value Normal(compiler::Value mean, compiler::Value deviation) {
  return compiler::Distribution{compiler::DistributionKind::kNormal, {mean, deviation}, {}};
}
/// One of sphere, cuboid, cylinder and cone.
compiler::Value AnyType();

inline void SetWorld(compiler::Scene& scene, std::string_view name, compiler::Value value) {
  scene.world.values.insert_or_assign(std::string(name), std::move(value));
}
inline void SetGroup(compiler::Scene& scene, std::string_view name, compiler::Value value,
                     std::size_t group = 0) {
  scene.groups[group].settings.values.insert_or_assign(std::string(name), std::move(value));
}
inline compiler::Value Word(std::string_view text) { return compiler::Word{std::string(text)}; }
/// A layout with arguments as the plan holds it; those that are not given have their defaults.
compiler::Value Layout(std::string_view name,
                       const std::map<std::string_view, compiler::Value>& given = {});

/// Gives each stream the seed that it has under the benchmark's `seed`.
void SeedStreams(compiler::Scene& scene, std::uint64_t seed = 0xAAAAAAAAAA);

}  // namespace cdb::test
