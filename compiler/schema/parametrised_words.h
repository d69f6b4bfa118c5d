// THE table of words that take arguments: layouts, models from files, schedules, sizes and masses.
// The checker, `cdb doc`, the plan and the engine read it; a parameter lists those that it takes
// (Parameter::calls).
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"

namespace cdb::schema {

/// In a scenario `ring`, `ring(radius: 20)` or, of one argument, `ring radius: 20`; positions count
/// as names do: `at(0, 5, 0)`.
struct ParametrisedWord {
  std::string_view name;
  std::string_view doc;  ///< one line
  /// Described as parameters are; one without a default must be given.
  std::span<const Parameter> arguments;
  /// It takes a list of points instead of its arguments too: `at((0, 0, 0), (1, 2, 3))`.
  bool takes_points = false;
};

/// The unit of an argument that is itself a value of the parameter: `every(60, (0, -9.8, 0))`.
inline constexpr std::string_view kParametersUnit = "as the parameter";

std::span<const ParametrisedWord> ParametrisedWords();
/// Null where there is none.
const ParametrisedWord* FindParametrisedWord(std::string_view name);
/// Those without a default, in order.
std::vector<std::string_view> RequiredArguments(const ParametrisedWord& info);
/// The word by itself, every argument at its default; nullopt where one has none.
std::optional<Call> WithDefaults(const ParametrisedWord& info);
/// An argument's default; one without is our own bug.
Value DefaultOf(const Parameter& argument);
/// It names a file that is read, and holds its hash: `mesh("rock.obj")`.
inline bool NamesFile(const ParametrisedWord& info) {
  return info.arguments[0].type == ParameterType::kText;
}
/// The call that a text alone stands for behind `trace`.
inline constexpr std::string_view kTraceCall = "file";
/// The layout that reads a file.
inline constexpr std::string_view kPosesCall = "poses";
/// The type that is a grid of heights.
inline constexpr std::string_view kHeightsCall = "heights";
/// The layout that reads the path of a kinematic object.
inline constexpr std::string_view kPathCall = "path";
/// The call's arguments are a list of points, each a vector, instead of those of its row.
bool ListsPoints(const Call& call);
/// The argument of a call of the plan that lists no points; a name that its row does not have is
/// our own bug.
const Value& ArgumentOf(const Call& call, std::string_view argument);

}  // namespace cdb::schema
