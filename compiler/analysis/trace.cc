#include "compiler/analysis/trace.h"

#include <algorithm>

#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {

std::optional<TraceName> TraceOf(const plan::Scene& scene) {
  const schema::Call* call = schema::AsCall(scene.world.Get("trace"));
  if (call == nullptr) return std::nullopt;
  return TraceName{std::get<schema::Text>(schema::ArgumentOf(*call, "file")).text,
                   std::get<schema::Text>(schema::ArgumentOf(*call, "sha256")).text};
}

bool IsOnPairs(const plan::Scene& scene) {
  return scene.world.WordOr("narrow_phase") != "own" && TraceOf(scene).has_value();
}

namespace {

const schema::Call* LayoutCalled(std::string_view name, const plan::Group& group) {
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  return layout != nullptr && layout->name == name ? layout : nullptr;
}

}  // namespace

const schema::Call* PosesOf(const plan::Group& group) {
  return LayoutCalled(schema::kPosesCall, group);
}

const schema::Call* PathOf(const plan::Group& group) {
  return LayoutCalled(schema::kPathCall, group);
}

bool IsCsv(const schema::Call& poses) {
  const std::string& file = std::get<schema::Text>(schema::ArgumentOf(poses, "file")).text;
  std::string end = file.substr(file.size() - std::min<std::size_t>(file.size(), 4));
  for (char& c : end)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return std::ranges::find(kTextFormats, end) != std::end(kTextFormats);
}

namespace {

bool MayBeSurface(const schema::Value& type) {
  if (const schema::Call* call = schema::AsCall(type)) return IsSurface(*call);
  const schema::Distribution* drawn = schema::AsDistribution(type);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, MayBeSurface);
}

}  // namespace

bool IsSurface(const schema::Call& type) {
  return type.name == kSurfaceWord || type.name == schema::kHeightsCall ||
         type.name == schema::kHeightCall || type.name == schema::kImplicitCall ||
         type.name == schema::kVoxelsCall;
}

bool HasSurface(const plan::GroupSettings& settings) {
  return settings.Count("quantity") > 0 && MayBeSurface(settings.Get("type"));
}

}  // namespace cdb::analysis
