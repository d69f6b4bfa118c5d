// The units in which a value can be given: `10 ms`, `90 deg/s`, `5 N s/m`.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cdb::text {

/// A unit: its factor to SI, `factor / divisor * 10^tens * pi^pis`, and its powers of the SI base
/// units and of the byte. The factor and the divisor are integers, exact up to 2^53.
struct Unit {
  double factor = 1, divisor = 1;
  int tens = 0, pis = 0;
  int length = 0, mass = 0, time = 0, angle = 0;
  int memory = 0;  ///< power of the byte

  bool IsPure() const { return HasDimensionOf({}); }
  bool HasDimensionOf(const Unit& other) const {
    return length == other.length && mass == other.mass && time == other.time &&
           angle == other.angle && memory == other.memory;
  }
};

/// One of the names in the table: `ms`, `kg`, `deg`.
bool IsUnitName(std::string_view name);
/// The unit for which `word` is another name: `s` for `seconds`; empty if there is none.
std::string_view UnitCalled(std::string_view word);
/// All names of units, separated by spaces.
std::string UnitNames();

/// Parses `m/s^2`, `N s/m`, `1/s`: names joined by spaces or `/`, each with a power of one digit.
/// Nullopt if the text is not a unit. The empty text is the unit of a number without one.
std::optional<Unit> ParseUnit(std::string_view text);

/// `a * b^power`, as a unit.
Unit Multiplied(Unit a, const Unit& b, int power);

}  // namespace cdb::text
