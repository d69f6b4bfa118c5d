// The catalogue: the names of object types, detectors, layouts and closed forms that a scenario can
// use. The compiler, `cdb list` and `cdb doc` read these tables.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::schema {

struct ObjectType {
  std::string_view name;
  std::string_view doc;
  double fill;  ///< about the fraction of its bounding box that it fills
};

/// Known errors of a third-party detector.
enum class KnownErrors : std::uint8_t {
  kNone = 0,
  kMissesPairs = 1,
  kFalsePositives = 2,
  kNoNearContacts = 4,  ///< no contact for bodies that are close but do not overlap
};
constexpr KnownErrors operator|(KnownErrors a, KnownErrors b) {
  return static_cast<KnownErrors>(static_cast<std::uint8_t>(a) | static_cast<std::uint8_t>(b));
}

/// A row of catalogue_table.h.
struct DetectorInfo {
  std::string_view name;
  std::string_view doc;
  std::string_view source;
  std::string_view phases;       ///< space-separated: `broad`, `narrow`
  std::string_view family;       ///< of algorithms; comma-separated if there are several
  std::uint64_t max_bodies = 0;  ///< objects and walls together; 0 means no limit
  std::string_view limits = {};  ///< other limitations or errors; may be empty
  std::string_view part = {};    ///< the optional part it is in; empty if always included
  KnownErrors known_errors = KnownErrors::kNone;
  /// A narrow phase that lists all contact points of a pair in each cycle, not one of them: those
  /// of earlier cycles need not be kept, and a body on a plane has all its points at once.
  bool lists_all_points = false;

  constexpr bool HasPhase(std::string_view phase) const {
    return phases.find(phase) != std::string_view::npos;
  }
  /// True if it supports this number of bodies, walls included.
  bool Holds(std::uint64_t bodies) const { return max_bodies == 0 || bodies <= max_bodies; }
  /// One of cdb's own, of which `null` finds nothing.
  constexpr bool IsOwn() const { return source == "cdb"; }
  bool FindsPairs() const { return HasPhase("broad") && family != "none"; }
  bool Makes(KnownErrors error) const {
    return (static_cast<std::uint8_t>(known_errors) & static_cast<std::uint8_t>(error)) != 0;
  }
};

/// A family of algorithms from section 2 of the source paper: a detector belongs to it
/// (DetectorInfo::family lists it), or `why_not` gives the reason why none does.
struct FamilyInfo {
  std::string_view name;
  std::string_view source;
  std::string_view why_not = {};
};

/// A shared library of detectors, built if its Debian package is installed:
/// `cdb-detectors-<name>.so`, in the folder `detectors` beside the workers.
struct DetectorPart {
  std::string_view name;
  std::string_view package;
  bool is_built = false;
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
/// The type with the exponents e1 and e2, and the fraction of its box that it fills.
inline constexpr std::string_view kSuperellipsoidType = "superellipsoid";
double SuperellipsoidFill(double e1, double e2);
std::span<const DetectorInfo> Detectors();
std::span<const DetectorPart> DetectorParts();
std::span<const FamilyInfo> Families();
std::span<const LayoutInfo> Layouts();
/// They are implemented by library/closed_forms/closed_form.h.
std::span<const ClosedFormInfo> ClosedForms();

/// Null if there is none with this name.
const DetectorInfo* FindDetector(std::string_view name);
/// False for plug-ins.
bool ListsAllPoints(std::string_view narrow_phase);
const DetectorPart* FindDetectorPart(std::string_view name);

/// The word of the language for a common alternative: `cuboid` for `cube`. Empty if there is none.
std::string_view WordFor(std::string_view word);

// Detectors of a user's shared library, as named in scenarios and plans.

struct PluginDetector {
  std::string name;
  std::string phases;            ///< as in the catalogue: `broad`, `narrow`, `broad narrow`
  std::uint64_t max_bodies = 0;  ///< walls included; 0 means no limit
  std::string path;              ///< of the library, as reached from its scenario file
  std::string sha256;            ///< of the library: another file is another detector
  bool operator==(const PluginDetector&) const = default;
};

/// The possible phases of a detector in a library.
inline constexpr std::string_view kPluginPhases[] = {"broad", "narrow", "broad narrow"};

/// The row of the catalogue, or the entry in `plugins`; nullopt if neither has the name. Its texts
/// live as long as `plugins`.
std::optional<DetectorInfo> FindDetector(std::string_view name,
                                         std::span<const PluginDetector> plugins);

}  // namespace cdb::schema
