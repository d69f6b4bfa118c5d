#include "compiler/analysis/time_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/plan/input_file.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"

namespace cdb::analysis {
namespace {

using Eigen::Vector3d;
using plan::TableError;

std::string_view WordIn(const schema::Call& call, std::string_view argument) {
  return std::get<schema::Word>(schema::ArgumentOf(call, argument)).text;
}

const std::string& FileIn(const schema::Call& call) {
  return std::get<schema::Text>(schema::ArgumentOf(call, "file")).text;
}

/// The columns of time and values. Without headings, they are in this order.
std::vector<plan::Column> ColumnsOf(const plan::TextTable& table, const std::string& file,
                                    bool is_vector) {
  const std::size_t wanted = is_vector ? 4 : 2;
  if (table.width() != wanted)
    throw TableError(
        fmt::format("{} has {} columns, not {}", file, table.width(), wanted),
        is_vector ? "write the columns t, x, y and z" : "write the columns t and value");
  std::vector<plan::Column> columns;
  if (table.headings().empty()) {
    for (std::size_t i = 0; i < wanted; ++i) columns.push_back(table.At(i));
  } else if (is_vector) {
    for (const char* name : {"t", "x", "y", "z"}) columns.push_back(table.Find(name));
  } else {
    columns.push_back(table.Find("t"));
    columns.push_back(table.At(columns[0].index == 0 ? 1 : 0));
  }
  return columns;
}

void CheckUnit(const plan::TextTable& table, const plan::Column& column, std::string_view name) {
  const auto unit = plan::UnitNamed(name);
  CDB_CHECK(unit);
  if (!column.unit || column.unit->HasDimensionOf(*unit)) return;
  throw TableError(fmt::format("{}: the unit of {} is not one of {}", table.PlaceOfHeadings(),
                               column.name, name),
                   fmt::format("such as [{}]", name));
}

}  // namespace

TimeTable::TimeTable(const schema::Call& call, const std::string& text, std::string_view unit,
                     bool is_vector)
    : sha256_(plan::Sha256Hex(text)),
      is_vector_(is_vector),
      holds_(WordIn(call, "between") == "hold"),
      repeats_(WordIn(call, "then") == "repeat"),
      ends_(WordIn(call, "then") == "zero") {
  const std::string& file = FileIn(call);
  plan::TextTable table(text, file, plan::DialectOf(call));
  const std::vector<plan::Column> columns = ColumnsOf(table, file, is_vector);
  CheckUnit(table, columns[0], "s");
  for (std::size_t i = 1; i < columns.size(); ++i) CheckUnit(table, columns[i], unit);
  table.FindDecimal(columns);
  if (table.rows() == 0)
    throw TableError(fmt::format("{} has no line of numbers", file), "write a line for each time");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double time = table.Number(row, columns[0]);
    if (!rows_.empty() && !(time > rows_.back().time))
      throw TableError(fmt::format("{}: the time {} does not come after {}", table.Place(row),
                                   schema::FormatReal(time), schema::FormatReal(rows_.back().time)),
                       "write the lines in the order of their times, each time once");
    Vector3d value = Vector3d::Constant(table.Number(row, columns[1]));
    if (is_vector)
      for (const int axis : {1, 2})
        value[axis] = table.Number(row, columns[static_cast<std::size_t>(axis) + 1]);
    rows_.push_back({time, value});
  }
  if (repeats_ && rows_.size() < 2)
    throw TableError(fmt::format("{} has one line, and cannot repeat", file),
                     "write then: stay, or more lines");
}

Vector3d TimeTable::VectorAt(double time) const {
  const double first = rows_.front().time, last = rows_.back().time;
  if (time > last) {
    if (ends_) return Vector3d::Zero();
    if (!repeats_) return rows_.back().value;
    time = first + std::fmod(time - first, last - first);
  }
  const auto next = std::ranges::upper_bound(rows_, time, {}, &Row::time);
  if (next == rows_.begin()) return rows_.front().value;
  const Row& from = *(next - 1);
  if (holds_ || next == rows_.end()) return from.value;
  return from.value + (time - from.time) / (next->time - from.time) * (next->value - from.value);
}

double TimeTable::Largest() const {
  double most = 0;
  for (const Row& row : rows_)
    most = std::max(most, is_vector_ ? row.value.norm() : std::abs(row.value.x()));
  return most;
}

const schema::Call* TimeTableOf(const schema::Value& value) {
  const schema::Call* call = schema::AsCall(value);
  return call != nullptr && call->name == schema::kTableCall ? call : nullptr;
}

std::string_view UnitIn(const plan::GroupSettings& settings, const schema::Parameter& parameter) {
  const bool slides = !parameter.slider_unit.empty() && settings.WordOr("joints.type") == "slider";
  return slides ? parameter.slider_unit : parameter.unit;
}

TimeTable ReadTimeTable(const schema::Call& call, std::string_view unit, bool is_vector) {
  std::string why;
  const auto text = plan::ReadInputFile(FileIn(call), why);
  if (!text) throw TableError(fmt::format("cannot read '{}': {}", FileIn(call), why), "");
  TimeTable table(call, *text, unit, is_vector);
  const auto* planned = std::get_if<schema::Text>(&schema::ArgumentOf(call, "sha256"));
  if (planned != nullptr && planned->text != table.sha256())
    throw TableError(
        fmt::format("{}: it differs from the file that the plan was made with", FileIn(call)),
        "plan again from the .cdb file, or put the other file back");
  return table;
}

std::optional<TimeTableFault> FindTimeTableFault(
    const plan::Scene& scene,
    const std::function<std::optional<std::string>(const std::string& path)>& text_of) {
  const auto fault_in = [&](const std::string& owner, const plan::GroupSettings& settings,
                            schema::GroupParameter parameter,
                            bool is_vector) -> std::optional<TimeTableFault> {
    const schema::Call* call = TimeTableOf(settings.Get(parameter));
    const auto text = call == nullptr ? std::nullopt : text_of(FileIn(*call));
    if (!text) return std::nullopt;  // which is reported elsewhere
    try {
      const TimeTable table(*call, *text, UnitIn(settings, *parameter), is_vector);
    } catch (const TableError& error) {
      return TimeTableFault{owner, parameter.get(), error.what(), error.remedy};
    }
    return std::nullopt;
  };
  for (const plan::Group& group : scene.groups)
    for (const auto parameter : {schema::GroupParameter("force"), schema::GroupParameter("torque")})
      if (group.settings.Count("quantity") > 0)
        if (auto fault = fault_in(group.name, group.settings, parameter, true)) return fault;
  for (const plan::Joint& joint : scene.joints)
    for (const auto parameter : {schema::GroupParameter("joints.motor.velocity"),
                                 schema::GroupParameter("joints.motor.position"),
                                 schema::GroupParameter("joints.motor.torque"),
                                 schema::GroupParameter("joints.motor.force")})
      if (scene.HoldsObjects(joint))
        if (auto fault = fault_in(joint.name, joint.settings, parameter, false)) return fault;
  return std::nullopt;
}

}  // namespace cdb::analysis
