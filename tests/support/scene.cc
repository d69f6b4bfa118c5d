#include "tests/support/scene.h"

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::tests {

using schema::Value;

plan::Scene DefaultScene(std::uint64_t quantity, double side) {
  plan::Scene scene;
  scene.groups.push_back({"objects", {}});
  SetWorld(scene, "cycles", std::uint64_t{10});
  SetWorld(scene, "world.side", side);
  SetGroup(scene, "quantity", quantity);
  SeedStreams(scene);
  return scene;
}

Value AnyType() {
  return schema::Distribution{schema::DistributionKind::kAny,
                              {Word("sphere"), Word("cuboid"), Word("cylinder"), Word("cone")},
                              {1, 1, 1, 1}};
}

Value Layout(std::string_view name, const std::map<std::string_view, Value>& given) {
  schema::Call call{std::string(name), {}};
  for (const schema::Parameter& argument : schema::FindParametrisedWord(name)->arguments) {
    const auto at = given.find(argument.name);
    call.arguments.push_back(at == given.end() ? Word(argument.DefaultText()) : at->second);
  }
  return call;
}

void SeedStreams(plan::Scene& scene, std::uint64_t seed) {
  const auto add = [&](const std::string& name) {
    scene.seeds.insert_or_assign(name, plan::StreamSeed(seed, name));
  };
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (!parameter.grouped) {
      if (parameter.distribution) add(std::string(parameter.name));
      continue;
    }
    for (const plan::Group& group : scene.groups)
      if (parameter.NamedBlock().empty() &&
          (parameter.distribution || parameter.name == "location"))
        add(group.name + "." + std::string(parameter.name));
    for (const plan::Queries& queries : scene.queries)
      if (parameter.NamedBlock() == schema::kQueriesBlock && parameter.distribution)
        add(queries.name + "." + std::string(parameter.OwnName()));
  }
}

}  // namespace cdb::tests
