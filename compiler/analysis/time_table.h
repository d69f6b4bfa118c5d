// Values over time from a file, `table("push.csv")`: forces and torques of objects, and what motors
// seek or give.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/plan/text_table.h"

namespace cdb::analysis {

/// A function of time, in SI units. Before the first line its value applies; after the last line
/// its value, 0, or the table again, without its last line. Of a number, the components are equal.
/// Threads: any.
class TimeTable {
 public:
  /// `text` is that of the file; `unit` that of the parameter, which is a vector or a number.
  /// Throws plan::TableError.
  TimeTable(const schema::Call& call, const std::string& text, std::string_view unit,
            bool is_vector);

  Eigen::Vector3d VectorAt(double time) const;
  double At(double time) const { return VectorAt(time).x(); }
  /// The largest length of its values; of numbers, the largest one, whatever its sign.
  double Largest() const;
  double first_time() const { return rows_.front().time; }
  const std::string& sha256() const { return sha256_; }

 private:
  struct Row {
    double time;
    Eigen::Vector3d value;
  };

  std::vector<Row> rows_;
  std::string sha256_;
  bool is_vector_, holds_, repeats_, ends_;
};

/// The call `table` of a setting; null if it has another value.
const schema::Call* TimeTableOf(const schema::Value& value);
/// The unit of the setting of a joint, or a group.
std::string_view UnitIn(const plan::GroupSettings& settings, const schema::Parameter& parameter);
/// The table that a setting names. Throws plan::TableError, also if the file differs from the one
/// that the plan was made with.
TimeTable ReadTimeTable(const schema::Call& call, std::string_view unit, bool is_vector);

struct TimeTableFault {
  std::string owner;                   ///< the group or joint
  const schema::Parameter* parameter;  ///< whose value is at fault
  std::string message, help;
};
/// The first table of the scene that cannot be used; nullopt if there is none. `text_of`: of a file
/// by its path, nullopt if it cannot be read.
std::optional<TimeTableFault> FindTimeTableFault(
    const plan::Scene& scene,
    const std::function<std::optional<std::string>(const std::string& path)>& text_of);

}  // namespace cdb::analysis
