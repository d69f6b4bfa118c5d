// Reads untrusted JSON: values that are missing or have another type become defaults.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "runtime/editor/positions.h"

namespace cdb::editor {

using Json = nlohmann::json;

/// null if `object` is not an object, or has no such member.
const Json& Member(const Json& object, const char* name);
std::string TextIn(const Json& object, const char* name);
/// 0 if the member is not a whole number.
std::int64_t NumberIn(const Json& object, const char* name);
Position PositionIn(const Json& object, const char* name);

Json ToJson(const Position& position);
/// The range of a span of `source`.
Json RangeJson(const text::Span& span);

}  // namespace cdb::editor
