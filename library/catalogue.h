// What a scenario can name: object types, detectors, layouts, closed forms. The compiler, `cdb
// list` and `cdb doc` read these tables.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace cdb::library {

struct ObjectType {
  std::string_view name;
  std::string_view doc;
};

struct DetectorInfo {
  std::string_view name;
  std::string_view doc;
  std::string_view source;
  std::string_view phases;       ///< `broad`
  std::uint64_t max_bodies = 0;  ///< objects and walls together; 0 means no limit
  /// So many, walls included.
  bool Holds(std::uint64_t bodies) const { return max_bodies == 0 || bodies <= max_bodies; }
};

struct LayoutInfo {
  std::string_view name;
  std::string_view doc;
};

struct ClosedFormInfo {
  std::string_view name;
  std::string_view doc;
};

std::span<const ObjectType> ObjectTypes();
std::span<const DetectorInfo> Detectors();
std::span<const LayoutInfo> Layouts();
/// library/closed_forms/closed_form.h makes them.
std::span<const ClosedFormInfo> ClosedForms();

/// Null where there is none of that name.
const DetectorInfo* FindDetector(std::string_view name);

}  // namespace cdb::library
