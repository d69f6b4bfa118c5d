#include "tests/support/scene.h"

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "dsl/text/check.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using schema::Value;

/// The default of a parameter, made from the schema's text as the compiler does.
Value DefaultValue(const schema::Parameter& parameter) {
  const std::string text(parameter.default_text);
  if (parameter.type != schema::ParameterType::kWords && parameter.HasWord(text)) return Word(text);
  switch (parameter.type) {
    case schema::ParameterType::kCount:
      return static_cast<std::uint64_t>(std::stoull(text, nullptr, 0));
    case schema::ParameterType::kReal:
      if (const std::size_t slash = text.find('/'); slash != text.npos)
        return std::stod(text) / std::stod(text.substr(slash + 1));
      if (parameter.name == "world.side") return 500.0;
      return std::stod(text);
    case schema::ParameterType::kSwitch:
      return text == "on";
    case schema::ParameterType::kVector:
      if (text == "0") return Vector3d(Vector3d::Zero());
      CDB_CHECK(parameter.name == "acceleration");
      return Vector3d(0, -9.8, 0);
    case schema::ParameterType::kRatio:
      return schema::Ratio{Vector3d::Ones()};
    case schema::ParameterType::kWords:
      if (parameter.HasWord(text)) return schema::WordList{text};
      return schema::WordList{"timing", "counts", "stability"};
    case schema::ParameterType::kText:
    case schema::ParameterType::kWord:
      break;
  }
  CDB_CHECK(false);
  return false;
}

}  // namespace

plan::Scene DefaultScene(std::uint64_t quantity, double side) {
  plan::Scene scene;
  scene.groups.push_back({"objects", {}});
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (parameter.grouped) {
      scene.groups[0].settings.SetValue(parameter, DefaultValue(parameter));
    } else {
      scene.world.SetValue(parameter, DefaultValue(parameter));
    }
  }
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
    call.arguments.push_back(at == given.end() ? Word(argument.default_text) : at->second);
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
      if (parameter.distribution || parameter.name == "location")
        add(group.name + "." + std::string(parameter.name));
  }
}

}  // namespace cdb::tests
