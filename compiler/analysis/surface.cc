#include "compiler/analysis/surface.h"

#include <algorithm>

#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {
namespace {

bool MayBeSurface(const schema::Value& type) {
  if (const schema::Call* call = schema::AsCall(type)) return IsSurface(*call);
  const schema::Distribution* drawn = schema::AsDistribution(type);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, MayBeSurface);
}

}  // namespace

bool IsSurface(const schema::Call& type) {
  return type.name == kSurfaceWord || type.name == schema::kHeightsCall;
}

bool HasSurface(const plan::GroupSettings& settings) {
  return settings.Count("quantity") > 0 && MayBeSurface(settings.Get("type"));
}

}  // namespace cdb::analysis
