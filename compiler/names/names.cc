#include "compiler/names/names.h"

#include <algorithm>

#include "dsl/diagnostics.h"

namespace cdb::names {
namespace {

/// The lets of a file come before the statements of any benchmark.
constexpr int kFileLets = -1'000'000;
constexpr std::string_view kObjectCount = "objects";

}  // namespace

Referent Names::Resolve(const std::string& path, const scenario::Scope& scope) const {
  // A default of the schema: every other word stands for itself.
  if (scope.file == nullptr) return {std::nullopt, std::nullopt, path == kObjectCount};
  if (scope.parameter != nullptr &&
      (scope.parameter->HasWord(path, scenario_.plugins()) || scope.parameter->TakesCall(path)))
    return {};
  if (auto let = FindLet(path, scope)) return {std::move(let), std::nullopt};
  return {std::nullopt, FindParameter(path, scope)};
}

std::string_view Names::NearestLet(const std::string& word, const scenario::Scope& scope) const {
  std::vector<std::string_view> names;
  if (scope.file != nullptr) names = scenario_.LetNames(*scope.file);
  for (const auto& [key, let] : layers_.lets) names.push_back(key.second);
  return dsl::DidYouMean(word, names);
}

std::optional<scenario::Placed<dsl::Let>> Names::FindLet(const std::string& path,
                                                         const scenario::Scope& scope) const {
  for (std::string block = scenario::Joined(scope.group, scope.block);;
       block = scenario::Outside(block)) {
    const auto let = layers_.lets.find({block, path});
    if (let != layers_.lets.end()) return let->second;
    if (block.empty()) break;
  }
  const auto let = scenario_.FindLet(*scope.file, path);
  if (!let) return std::nullopt;
  scenario::Placed<dsl::Let> placed;
  placed.node = let->let;
  placed.scope.file = let->file;
  placed.order = kFileLets + scenario_.LetOrder(*let->let);
  return placed;
}

std::optional<scenario::ParameterKey> Names::FindParameter(const std::string& path,
                                                           const scenario::Scope& scope) const {
  for (std::string block = scope.block;; block = scenario::Outside(block)) {
    if (const schema::Parameter* parameter =
            schema::FindParameter(scenario::Joined(block, path), !scope.group.empty()))
      return scenario::ParameterKey{scope.group, parameter};
    if (block.empty()) break;
  }
  if (const schema::Parameter* parameter = schema::FindParameter(path, false))
    return scenario::ParameterKey{"", parameter};
  // Outside the blocks, `quantity` means that of `objects`, like the name of its axis.
  if (scope.group.empty() && scope.block.empty() && IsGroup("objects"))
    if (const schema::Parameter* parameter = schema::FindParameter(path, true))
      return scenario::ParameterKey{"objects", parameter};
  const std::size_t dot = path.find('.');
  if (dot != std::string::npos && IsGroup(path.substr(0, dot)))
    if (const schema::Parameter* parameter = schema::FindParameter(path.substr(dot + 1), true))
      return scenario::ParameterKey{path.substr(0, dot), parameter};
  return std::nullopt;
}

bool Names::IsGroup(std::string_view name) const {
  return std::ranges::find(layers_.groups, name) != layers_.groups.end();
}

}  // namespace cdb::names
