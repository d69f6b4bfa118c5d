#include "runtime/editor/json.h"

namespace cdb::editor {

const Json& Member(const Json& object, const char* name) {
  static const Json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(name);
  return found == object.end() ? nothing : *found;
}

std::string TextIn(const Json& object, const char* name) {
  const Json& member = Member(object, name);
  return member.is_string() ? member.get<std::string>() : std::string();
}

std::int64_t NumberIn(const Json& object, const char* name) {
  const Json& member = Member(object, name);
  return member.is_number_integer() ? member.get<std::int64_t>() : 0;
}

Position PositionIn(const Json& object, const char* name) {
  const Json& member = Member(object, name);
  return {NumberIn(member, "line"), NumberIn(member, "character")};
}

Json ToJson(const Position& position) {
  return {{"line", position.line}, {"character", position.character}};
}

Json RangeJson(const text::Span& span) {
  if (span.source == nullptr) return {{"start", ToJson({})}, {"end", ToJson({})}};
  return {{"start", ToJson(PositionOf(*span.source, span.begin))},
          {"end", ToJson(PositionOf(*span.source, span.end))}};
}

}  // namespace cdb::editor
