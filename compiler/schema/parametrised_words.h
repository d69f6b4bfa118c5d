// THE table of words with arguments: layouts, models from files, schedules, sizes and masses. The
// checker, `cdb doc`, the plan and the engine read it; a parameter lists the ones it takes
// (Parameter::calls).
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"

namespace cdb::schema {

/// In a scenario `ring`, `ring(radius: 20)` or, with one argument, `ring radius: 20`; arguments can
/// also be given by position: `at(0, 5, 0)`.
struct ParametrisedWord {
  std::string_view name;
  std::string_view doc;  ///< one line
  /// Described as parameters are; an argument without a default is required.
  std::span<const Parameter> arguments;
  /// Also takes a list of points instead of its arguments: `at((0, 0, 0), (1, 2, 3))`.
  bool takes_points = false;
  /// Also takes a list of parts, without names, before its arguments: `compound(part(…), …)`. In a
  /// Call, they follow the arguments.
  bool takes_parts = false;
};

/// The unit of an argument that is a value of the parameter itself: `every(60, (0, -9.8, 0))`.
inline constexpr std::string_view kParametersUnit = "as the parameter";

std::span<const ParametrisedWord> ParametrisedWords();
/// Null if there is none with this name.
const ParametrisedWord* FindParametrisedWord(std::string_view name);
/// The arguments of empirical( ), which is no parameter's word but a distribution; its values, not
/// its arguments, are in plans.
const ParametrisedWord& EmpiricalTable();
/// The arguments without a default, in order; `part` for a list of parts.
std::vector<std::string_view> RequiredArguments(const ParametrisedWord& info);
/// The word with all arguments at their defaults; nullopt if one has none.
std::optional<Call> WithDefaults(const ParametrisedWord& info);
/// The default of an argument; calling it for an argument without one is an internal error.
Value DefaultOf(const Parameter& argument);
/// True if it names a file to read, and holds its hash: `mesh("rock.obj")`.
inline bool NamesFile(const ParametrisedWord& info) {
  return info.arguments[0].type == ParameterType::kText;
}
/// The call that a plain text after `trace` stands for.
inline constexpr std::string_view kTraceCall = "file";
/// The layout that reads a file.
inline constexpr std::string_view kPosesCall = "poses";
/// The type of a grid of heights.
inline constexpr std::string_view kHeightsCall = "heights";
/// The types of ground that formulae give: heights over x and z, and where a function of x, y and z
/// changes its sign.
inline constexpr std::string_view kHeightCall = "height", kImplicitCall = "implicit";
/// The type of a grid of solid cells, or of a cloud of points that makes one.
inline constexpr std::string_view kVoxelsCall = "voxels";
/// The layout that reads the path of a kinematic object.
inline constexpr std::string_view kPathCall = "path";
/// The positions of joints that a file lists.
inline constexpr std::string_view kListCall = "list";
/// The values over time that a file lists.
inline constexpr std::string_view kTableCall = "table";
/// The type of a soft body that is made of a mesh.
inline constexpr std::string_view kSoftCall = "soft";
/// The layout at the objects of another group.
inline constexpr std::string_view kRelativeCall = "relative_to";
/// A part of a list, as the parameter that its scope has.
const Parameter& PartParameter();
/// The parts of a call, each a Call; empty for words that take none.
std::span<const Value> PartsOf(const Call& call);
/// The files that the call, or a part of it, names.
std::vector<std::string_view> FilesOf(const Call& call);
/// True if the arguments are a list of points, each a vector, instead of those of its row.
bool ListsPoints(const Call& call);
/// The argument of a call in the plan that lists no points; a name that its row does not have is an
/// internal error.
const Value& ArgumentOf(const Call& call, std::string_view argument);

}  // namespace cdb::schema
