#include "dsl/text/units.h"

#include <algorithm>
#include <array>
#include <utility>

namespace cdb::text {
namespace {

struct UnitRow {
  std::string_view name;
  Unit unit;
};

constexpr Unit Length(int tens) { return {.tens = tens, .length = 1}; }
constexpr Unit Mass(int tens) { return {.tens = tens, .mass = 1}; }
constexpr Unit Time(double factor, int tens = 0) {
  return {.factor = factor, .tens = tens, .time = 1};
}
constexpr Unit Frequency(int tens) { return {.tens = tens, .time = -1}; }
constexpr Unit Memory(double factor, int tens = 0) {
  return {.factor = factor, .tens = tens, .memory = 1};
}
constexpr Unit Force(int tens) { return {.tens = tens, .length = 1, .mass = 1, .time = -2}; }
constexpr Unit Pressure(int tens) { return {.tens = tens, .length = -1, .mass = 1, .time = -2}; }

constexpr auto kUnitRows = std::to_array<UnitRow>({
    {"km", Length(3)},
    {"m", Length(0)},
    {"cm", Length(-2)},
    {"mm", Length(-3)},
    {"um", Length(-6)},
    {"t", Mass(3)},
    {"kg", Mass(0)},
    {"g", Mass(-3)},
    {"mg", Mass(-6)},
    {"h", Time(3600)},
    {"min", Time(60)},
    {"s", Time(1)},
    {"ms", Time(1, -3)},
    {"us", Time(1, -6)},
    {"ns", Time(1, -9)},
    {"rad", {.angle = 1}},
    {"deg", {.divisor = 180, .pis = 1, .angle = 1}},
    {"rpm", {.divisor = 30, .pis = 1, .time = -1, .angle = 1}},
    {"Hz", Frequency(0)},
    {"kHz", Frequency(3)},
    {"N", Force(0)},
    {"kN", Force(3)},
    {"Pa", Pressure(0)},
    {"kPa", Pressure(3)},
    {"MPa", Pressure(6)},
    {"%", {.tens = -2}},
    {"B", Memory(1)},
    {"kB", Memory(1, 3)},
    {"MB", Memory(1, 6)},
    {"GB", Memory(1, 9)},
    {"TB", Memory(1, 12)},
    {"KiB", Memory(1024)},
    {"MiB", Memory(1024.0 * 1024)},
    {"GiB", Memory(1024.0 * 1024 * 1024)},
    {"TiB", Memory(1024.0 * 1024 * 1024 * 1024)},
});

const UnitRow* FindRow(std::string_view name) {
  const auto* row = std::ranges::find(kUnitRows, name, &UnitRow::name);
  return row == kUnitRows.end() ? nullptr : row;
}

}  // namespace

bool IsUnitName(std::string_view name) { return FindRow(name) != nullptr; }

std::string_view UnitCalled(std::string_view word) {
  constexpr std::pair<std::string_view, std::string_view> kMeant[] = {
      {"sec", "s"},          {"secs", "s"},          {"second", "s"},       {"seconds", "s"},
      {"msec", "ms"},        {"mins", "min"},        {"minute", "min"},     {"minutes", "min"},
      {"hr", "h"},           {"hour", "h"},          {"hours", "h"},        {"meter", "m"},
      {"meters", "m"},       {"metre", "m"},         {"metres", "m"},       {"degree", "deg"},
      {"degrees", "deg"},    {"degs", "deg"},        {"radian", "rad"},     {"radians", "rad"},
      {"rads", "rad"},       {"kilo", "kg"},         {"kgs", "kg"},         {"gram", "g"},
      {"grams", "g"},        {"hz", "Hz"},           {"newton", "N"},       {"micron", "um"},
      {"microns", "um"},     {"tonne", "t"},         {"tonnes", "t"},       {"usec", "us"},
      {"KG", "kg"},          {"CM", "cm"},           {"MM", "mm"},          {"Kg", "kg"},
      {"byte", "B"},         {"bytes", "B"},         {"KB", "kB"},          {"mb", "MB"},
      {"gb", "GB"},          {"Gb", "GB"},           {"kiB", "KiB"},        {"gib", "GiB"},
      {"millimeter", "mm"},  {"millimeters", "mm"},  {"millimetre", "mm"},  {"millimetres", "mm"},
      {"centimeter", "cm"},  {"centimeters", "cm"},  {"centimetre", "cm"},  {"centimetres", "cm"},
      {"millisecond", "ms"}, {"milliseconds", "ms"}, {"microsecond", "us"}, {"microseconds", "us"},
      {"nanosecond", "ns"},  {"nanoseconds", "ns"},  {"nsec", "ns"}};
  for (const auto& [word_written, unit] : kMeant)
    if (word_written == word) return unit;
  return {};
}

std::string UnitNames() {
  std::string names;
  for (const UnitRow& row : kUnitRows) {
    if (!names.empty()) names += ' ';
    names += row.name;
  }
  return names;
}

Unit Multiplied(Unit a, const Unit& b, int power) {
  for (int i = 0; i < (power < 0 ? -power : power); ++i) {
    a.factor *= power < 0 ? b.divisor : b.factor;
    a.divisor *= power < 0 ? b.factor : b.divisor;
  }
  a.tens += power * b.tens;
  a.pis += power * b.pis;
  a.length += power * b.length;
  a.mass += power * b.mass;
  a.time += power * b.time;
  a.angle += power * b.angle;
  a.memory += power * b.memory;
  return a;
}

std::optional<Unit> ParseUnit(std::string_view text) {
  Unit unit;
  if (text.starts_with("1/")) text.remove_prefix(1);
  for (int sign = 1; !text.empty();) {
    if (text.front() == '/' || text.front() == ' ') {
      // The `/` applies only to the name after it.
      sign = text.front() == '/' ? -1 : 1;
      text.remove_prefix(1);
    }
    const std::size_t end = std::min(text.find_first_of("/ "), text.size());
    std::string_view name = text.substr(0, end);
    text.remove_prefix(end);
    int power = 1;
    if (const std::size_t caret = name.find('^'); caret != std::string_view::npos) {
      if (caret + 2 != name.size() || name[caret + 1] < '1' || name[caret + 1] > '9')
        return std::nullopt;
      power = name[caret + 1] - '0';
      name = name.substr(0, caret);
    }
    const UnitRow* row = FindRow(name);
    if (row == nullptr) return std::nullopt;
    unit = Multiplied(unit, row->unit, sign * power);
    sign = 1;
  }
  return unit;
}

}  // namespace cdb::text
