#include "compiler/schema/parametrised_words.h"

#include <algorithm>

#include "dsl/check.h"

namespace cdb::schema {
namespace {

using enum ParameterType;

constexpr Domain kAny = {};
constexpr Domain kPositive = {.min = 0, .min_open = true};
constexpr Domain kNotZero = {.not_zero = true};
constexpr Domain kCountFromOne = {.min = 1, .max = 2147483647};

struct ArgumentOptions {
  std::string_view default_text = {};
  std::string_view words = {};
  bool distribution = false;
};

constexpr Parameter Argument(std::string_view name, ParameterType type, Domain domain,
                             std::string_view unit, std::string_view doc,
                             ArgumentOptions options = {}) {
  Parameter parameter;
  parameter.name = name;
  parameter.type = type;
  parameter.domain = domain;
  parameter.distribution = options.distribution;
  parameter.unit = unit;
  parameter.default_text = options.default_text;
  parameter.words = options.words;
  parameter.doc = doc;
  return parameter;
}

constexpr ArgumentOptions kFit = {.default_text = "fit", .words = "fit"};

// clang-format off
constexpr Parameter kGrid[] = {
    Argument("spacing", kReal, kPositive, "m", "between centres; fit spreads them over the cube", kFit)};
constexpr Parameter kStack[] = {
    Argument("height", kCount, kCountFromOne, "", "objects in a column; all makes one column", {.default_text = "all", .words = "all"}),
    Argument("gap", kReal, kPositive, "m", "between surfaces; fit is a thousandth of the larger object's height", kFit),
    Argument("spacing", kReal, kPositive, "m", "between the columns' centres; fit is 1.5 times the widest object", kFit)};
constexpr Parameter kPyramid[] = {
    Argument("gap", kReal, kPositive, "m", "between surfaces; fit is a thousandth of the largest extent", kFit)};
constexpr Parameter kPile[] = {
    Argument("width", kReal, kPositive, "m", "of the square that they are dropped over; fit makes it about as wide as high", kFit)};
constexpr Parameter kRing[] = {
    Argument("radius", kReal, kPositive, "m", "of the centres; fit leaves a tenth of the largest extent between neighbours", kFit)};
constexpr Parameter kLine[] = {
    Argument("gap", kReal, kAny, "m", "between surfaces along the line; fit is a tenth of the largest extent", kFit),
    Argument("along", kVector, kNotZero, "", "the way from the first to the last; down is (0, -1, 0)", {.default_text = "down", .words = "down"})};
constexpr Parameter kAt[] = {
    Argument("x", kReal, kAny, "m", "of the centre of mass"),
    Argument("y", kReal, kAny, "m", "of the centre of mass"),
    Argument("z", kReal, kAny, "m", "of the centre of mass")};
constexpr Parameter kPair[] = {
    Argument("distance", kReal, kPositive, "m", "between the surfaces")};
constexpr Parameter kModel[] = {
    Argument("file", kText, kAny, "", "OBJ, PLY, STL or OFF, from the folder of the .cdb file"),
    Argument("sha256", kText, kAny, "", "of the file's bytes: another file is refused", {.default_text = "any", .words = "any"})};
constexpr Parameter kTraceFile[] = {
    Argument("file", kText, kAny, "", "as `cdb trace` writes it, from the folder of the .cdb file"),
    Argument("sha256", kText, kAny, "", "of its boxes: another trace is refused", {.default_text = "any", .words = "any"})};
constexpr Parameter kEvery[] = {
    Argument("cycles", kCount, kCountFromOne, "", "from one draw to the next"),
    Argument("value", kVector, kAny, kParametersUnit, "a vector, or a distribution that is drawn anew each time", {.distribution = true})};
constexpr Parameter kRotating[] = {
    Argument("vector", kVector, kAny, kParametersUnit, "at the start"),
    Argument("about", kVector, kNotZero, "", "the axis, by the right hand"),
    Argument("period", kReal, kPositive, "s", "of a whole turn")};

constexpr ParametrisedWord kCalls[] = {
    {"grid", "a cubic lattice about the centre", kGrid},
    {"stack", "columns that stand on the floor, one object on the other", kStack},
    {"pyramid", "layers on the floor, each one fewer along both sides", kPyramid},
    {"pile", "dropped from above and settled before the first cycle", kPile},
    {"ring", "evenly on a circle about the centre, in the horizontal plane", kRing},
    {"line", "in a straight line about the centre, the first object first", kLine},
    {"at", "one object, just there", kAt},
    {"pair", "two objects about the centre whose surfaces are so far apart, in a direction drawn by chance", kPair},
    {"mesh", "a solid of your own as a compound of convex hulls; the mesh must be watertight", kModel},
    {"hull", "the convex hull of a mesh of your own", kModel},
    {"file", "a recorded run; its name alone in quotes is the same", kTraceFile},
    {"every", "set again every so many cycles", kEvery},
    {"rotating", "a vector that turns steadily", kRotating},
};
// clang-format on

}  // namespace

std::span<const ParametrisedWord> ParametrisedWords() { return kCalls; }

const ParametrisedWord* FindParametrisedWord(std::string_view name) {
  const auto* row = std::ranges::find(kCalls, name, &ParametrisedWord::name);
  return row == std::end(kCalls) ? nullptr : row;
}

std::vector<std::string_view> RequiredArguments(const ParametrisedWord& info) {
  std::vector<std::string_view> names;
  for (const Parameter& argument : info.arguments)
    if (argument.default_text.empty()) names.push_back(argument.name);
  return names;
}

Value DefaultOf(const Parameter& argument) {
  CDB_CHECK(argument.HasWord(argument.default_text));
  return Word{std::string(argument.default_text)};
}

std::optional<Call> WithDefaults(const ParametrisedWord& info) {
  if (!RequiredArguments(info).empty()) return std::nullopt;
  Call call{std::string(info.name), {}};
  for (const Parameter& argument : info.arguments) call.arguments.push_back(DefaultOf(argument));
  return call;
}

const Value& ArgumentOf(const Call& call, std::string_view argument) {
  const ParametrisedWord* info = FindParametrisedWord(call.name);
  CDB_CHECK(info != nullptr && info->arguments.size() == call.arguments.size());
  const auto row = std::ranges::find(info->arguments, argument, &Parameter::name);
  CDB_CHECK(row != info->arguments.end());
  return call.arguments[static_cast<std::size_t>(row - info->arguments.begin())];
}

}  // namespace cdb::schema
