#include "compiler/trace.h"

#include "compiler/calls.h"

namespace cdb::compiler {

std::optional<TraceName> TraceOf(const Scene& scene) {
  const Call* call = AsCall(scene.world.Get("trace"));
  if (call == nullptr) return std::nullopt;
  return TraceName{std::get<Text>(ArgumentOf(*call, "file")).text,
                   std::get<Text>(ArgumentOf(*call, "sha256")).text};
}

}  // namespace cdb::compiler
