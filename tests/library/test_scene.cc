#include "tests/library/test_scene.h"

#include "compiler/calls.h"
#include "compiler/schema.h"
#include "dsl/check.h"

namespace cdb::test {
namespace {

using compiler::Value;
using Eigen::Vector3d;

/// The default of a parameter, as the compiler makes it of the schema's text.
Value DefaultValue(const compiler::Parameter& parameter) {
  const std::string text(parameter.default_text);
  if (parameter.type != compiler::ParameterType::kWords && parameter.HasWord(text))
    return Word(text);
  switch (parameter.type) {
    case compiler::ParameterType::kCount:
      return static_cast<std::uint64_t>(std::stoull(text, nullptr, 0));
    case compiler::ParameterType::kReal:
      if (const std::size_t slash = text.find('/'); slash != text.npos)
        return std::stod(text) / std::stod(text.substr(slash + 1));
      if (parameter.name == "world.side") return 500.0;
      return std::stod(text);
    case compiler::ParameterType::kSwitch:
      return text == "on";
    case compiler::ParameterType::kVector:
      if (text == "0") return Vector3d(Vector3d::Zero());
      CDB_CHECK(parameter.name == "acceleration");
      return Vector3d(0, -9.8, 0);
    case compiler::ParameterType::kRatio:
      return compiler::Ratio{Vector3d::Ones()};
    case compiler::ParameterType::kWords:
      if (parameter.HasWord(text)) return compiler::WordList{text};
      return compiler::WordList{"timing", "counts", "stability"};
    case compiler::ParameterType::kText:
    case compiler::ParameterType::kWord:
      break;
  }
  CDB_CHECK(false);
  return false;
}

}  // namespace

compiler::Scene DefaultScene(std::uint64_t quantity, double side) {
  compiler::Scene scene;
  scene.groups.push_back({"objects", {}});
  for (const compiler::Parameter& parameter : compiler::Schema()) {
    if (parameter.grouped) {
      SetGroup(scene, parameter.name, DefaultValue(parameter));
    } else {
      SetWorld(scene, parameter.name, DefaultValue(parameter));
    }
  }
  SetWorld(scene, "cycles", std::uint64_t{10});
  SetWorld(scene, "world.side", side);
  SetGroup(scene, "quantity", quantity);
  SeedStreams(scene);
  return scene;
}

Value AnyType() {
  return compiler::Distribution{compiler::DistributionKind::kAny,
                                {Word("sphere"), Word("cuboid"), Word("cylinder"), Word("cone")},
                                {1, 1, 1, 1}};
}

Value Layout(std::string_view name, const std::map<std::string_view, Value>& given) {
  compiler::Call call{std::string(name), {}};
  for (const compiler::Parameter& argument : compiler::FindCall(name)->arguments) {
    const auto at = given.find(argument.name);
    call.arguments.push_back(at == given.end() ? Word(argument.default_text) : at->second);
  }
  return call;
}

void SeedStreams(compiler::Scene& scene, std::uint64_t seed) {
  const auto add = [&](const std::string& name) {
    scene.seeds.insert_or_assign(name, compiler::StreamSeed(seed, name));
  };
  for (const compiler::Parameter& parameter : compiler::Schema()) {
    if (!parameter.grouped) {
      if (parameter.distribution) add(std::string(parameter.name));
      continue;
    }
    for (const compiler::Group& group : scene.groups)
      if (parameter.distribution || parameter.name == "location")
        add(group.name + "." + std::string(parameter.name));
  }
}

}  // namespace cdb::test
