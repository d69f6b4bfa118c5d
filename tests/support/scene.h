// Scenes for tests: the schema's defaults, and functions that change them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::tests {

/// Every parameter has its default; `quantity` objects in a cube of `side` m, 10 cycles; streams
/// for all parameters that may be drawn.
plan::Scene DefaultScene(std::uint64_t quantity, double side);

inline schema::Value Uniform(schema::Value a, schema::Value b) {
  return schema::Distribution{schema::DistributionKind::kUniform, {a, b}, {}};
}
inline schema::Value Normal(schema::Value mean, schema::Value deviation) {
  return schema::Distribution{schema::DistributionKind::kNormal, {mean, deviation}, {}};
}
/// One of sphere, cuboid, cylinder and cone.
schema::Value AnyType();

inline void SetWorld(plan::Scene& scene, schema::WorldParameter parameter, schema::Value value) {
  scene.world.Set(parameter, std::move(value));
}
inline void SetGroup(plan::Scene& scene, schema::GroupParameter parameter, schema::Value value,
                     std::size_t group = 0) {
  scene.groups[group].settings.Set(parameter, std::move(value));
}
inline schema::Value Word(std::string_view text) { return schema::Word{std::string(text)}; }
/// A layout with arguments, as in a plan; arguments that are not given have their defaults.
schema::Value Layout(std::string_view name,
                     const std::map<std::string_view, schema::Value>& given = {});

/// Gives each stream the seed that it has with the benchmark's `seed`.
void SeedStreams(plan::Scene& scene, std::uint64_t seed = 0xAAAAAAAAAA);

}  // namespace cdb::tests
