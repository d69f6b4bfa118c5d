// Reading JSON of which nothing is known: what is missing or of another type is a default.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "runtime/lsp/positions.h"

namespace cdb::lsp {

using Json = nlohmann::json;

/// null where `object` is none, or has no such member.
const Json& Member(const Json& object, const char* name);
std::string TextIn(const Json& object, const char* name);
/// 0 for what is no whole number.
std::int64_t NumberIn(const Json& object, const char* name);
Position PositionIn(const Json& object, const char* name);

Json ToJson(const Position& position);
/// Of a span of `source`.
Json RangeJson(const text::Span& span);

}  // namespace cdb::lsp
