#include "compiler/analysis/trace.h"

#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {

std::optional<TraceName> TraceOf(const plan::Scene& scene) {
  const schema::Call* call = schema::AsCall(scene.world.Get("trace"));
  if (call == nullptr) return std::nullopt;
  return TraceName{std::get<schema::Text>(schema::ArgumentOf(*call, "file")).text,
                   std::get<schema::Text>(schema::ArgumentOf(*call, "sha256")).text};
}

}  // namespace cdb::analysis
