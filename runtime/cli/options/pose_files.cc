#include "runtime/cli/options/pose_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "compiler/analysis/model.h"
#include "compiler/plan/text_table.h"
#include "compiler/schema/parametrised_words.h"
#include "library/layouts/pose_columns.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "runtime/figures/points.h"
#include "runtime/pages/view/selection.h"
#include "runtime/protocol/series.h"
#include "runtime/results/store.h"

namespace cdb::options {
namespace {

using layouts::PoseRow;
using layouts::PoseTable;
using library::SceneError;
using results::ResultFile;

/// The arguments of a call `poses` or `path`; empty if they are a word, or of the other.
struct Arguments {
  explicit Arguments(const schema::Call& poses) : file(*Text(poses, "file")) {
    if (poses.name == schema::kPathCall) return;
    if (const auto* number = schema::AsNumber(schema::ArgumentOf(poses, "cycle")))
      cycle = number->AsCount();
    run = Text(poses, "run");
    group = Text(poses, "group");
  }
  static std::optional<std::string> Text(const schema::Call& poses, std::string_view argument) {
    const schema::Text* text = schema::AsText(schema::ArgumentOf(poses, argument));
    return text != nullptr ? std::optional(text->text) : std::nullopt;
  }
  std::string file;
  std::optional<std::uint64_t> cycle;
  std::optional<std::string> run, group;
};

[[noreturn]] void Refuse(const Arguments& from, const std::string& cause,
                         const std::string& remedy) {
  throw SceneError(fmt::format("{}: {}", from.file, cause), remedy);
}

/// `detector=dbvt, quantity=100`.
std::vector<figures::AxisSelection> SelectionsOf(const std::string& text) {
  std::vector<figures::AxisSelection> selections;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string word = text.substr(begin, end - begin);
    word.erase(0, word.find_first_not_of(' '));
    word.erase(word.find_last_not_of(' ') + 1);
    selections.push_back(figures::ParseSelection(word));
    begin = end + 1;
  }
  return selections;
}

ResultFile::Cell CellOf(const ResultFile& file, const Arguments& from) {
  ResultFile::Cell cell{std::vector<std::size_t>(file.axes().size(), 0), 0};
  const auto selections =
      from.run ? SelectionsOf(*from.run) : std::vector<figures::AxisSelection>();
  const auto is_named = [&](std::string_view axis) {
    return std::ranges::find(selections, axis, &figures::AxisSelection::axis) != selections.end();
  };
  std::string open;
  for (const plan::Axis& axis : file.axes())
    if (axis.values.size() > 1 && !is_named(axis.name))
      open += fmt::format("{}{}=…", open.empty() ? "" : ", ", axis.name);
  if (file.repeats() > 1 && !is_named("rep")) open += open.empty() ? "rep=0" : ", rep=0";
  if (!open.empty())
    Refuse(from, "it has several runs", fmt::format("name one: run: \"{}\"", open));
  view::Select(file.axes(), file.repeats(), selections, cell);
  return cell;
}

/// True if an earlier version recorded such objects about other axes.
bool HadOtherAxes(const plan::Group& group) {
  return std::ranges::any_of(analysis::TypesOf(group.settings), [](const schema::Value& type) {
    return objects::IsDecomposed(type) || type == schema::Value(schema::Word{"torus"});
  });
}

/// The range of objects requested: the first, and the one after the last.
std::pair<std::size_t, std::size_t> ObjectsOf(const ResultFile& file, const ResultFile::Cell& cell,
                                              const Arguments& from) {
  const auto plan = figures::ReadPlan(file);
  if (!plan) Refuse(from, "its plan is from another version of cdb", "run it again with this one");
  const auto run = std::ranges::find_if(plan->runs, [&](const plan::Run& candidate) {
    return candidate.at == cell.at && candidate.rep == cell.rep;
  });
  if (run == plan->runs.end()) Refuse(from, "this run was skipped by `skip`", "name another run");
  std::size_t first = 0;
  std::string names;
  for (const plan::Group& group : run->scene.groups) {
    const std::size_t count = group.settings.Count("quantity");
    const bool is_asked_for = !from.group || group.name == *from.group;
    if (is_asked_for && HadOtherAxes(group) && !file.HasPosesOfOrigins())
      Refuse(
          from,
          fmt::format("an earlier version of cdb recorded the poses of `{}`, about other axes of "
                      "their meshes",
                      group.name),
          "run it again with this one");
    if (from.group && is_asked_for) return {first, first + count};
    names += fmt::format("{}{}", names.empty() ? "" : ", ", group.name);
    first += count;
  }
  if (from.group)
    Refuse(from, fmt::format("its run has no group `{}`", *from.group),
           fmt::format("there are {}", names));
  return {0, first};
}

PoseTable RecordedPoses(const ResultFile& file, const Arguments& from) {
  const ResultFile::Cell cell = CellOf(file, from);
  if (!file.Has("poses"))
    Refuse(
        from, "it has no poses",
        "run it again with `record timing, counts, poses`, or give the file a dataset `position`");
  const std::uint64_t cycles = file.ReadCycleCount(cell);
  if (cycles == 0)
    Refuse(
        from,
        fmt::format("its run is {} and has no cycles", results::StatusName(file.ReadStatus(cell))),
        "name another run");
  const std::uint64_t cycle = from.cycle.value_or(cycles - 1);
  if (cycle >= cycles)
    Refuse(from, fmt::format("it has no cycle {}", cycle),
           fmt::format("its cycles are 0 to {}", cycles - 1));
  const auto [first, end] = ObjectsOf(file, cell, from);
  const std::vector<double> poses = file.ReadCycle("poses", cell, cycle);
  if (first == end || poses.size() < end * protocol::kPoseSize)
    Refuse(from, "it has no poses of such objects", "name another run or group");
  PoseTable table;
  table.has_orientation = true;
  for (std::size_t i = first; i < end; ++i) {
    const double* pose = &poses[i * protocol::kPoseSize];
    const auto turn = layouts::UnitQuaternion(pose[6], pose[3], pose[4], pose[5]);
    PoseRow& row = table.rows.emplace_back();
    row.position = {pose[0], pose[1], pose[2]};
    if (!turn || !row.position.allFinite())
      Refuse(from, fmt::format("object {} has no finite pose in cycle {}", i + 1, cycle),
             "name an earlier cycle");
    row.orientation = *turn;
  }
  return table;
}

/// The poses of the datasets with the usual names.
PoseTable TableOf(const results::PoseArrays& arrays, const Arguments& from,
                  const schema::Call& poses) {
  struct Array {
    const std::vector<double>* values;
    std::size_t first, width;  ///< columns of layouts::PoseColumns
    const char* name;
  };
  const bool is_path = poses.name == schema::kPathCall;
  const Array all[] = {{&arrays.time, layouts::kTimeColumn, 1, "time"},
                       {&arrays.position, 0, 3, "position"},
                       {&arrays.orientation, 3, 4, "orientation"},
                       {&arrays.linear_velocity, 7, 3, "linear_velocity"},
                       {&arrays.angular_velocity, 10, 3, "angular_velocity"}};
  layouts::PoseColumns columns;
  columns.name = from.file;
  columns.place = [&](std::size_t row) { return fmt::format("{}: row {}", from.file, row); };
  columns.rows = arrays.position.size() / 3;
  if (is_path && arrays.time.empty())
    Refuse(from, "it has no dataset `time`", "a path needs the time of each pose, in s");
  for (const Array& array : all) {
    if (array.values->empty() || (!is_path && array.width == 1)) continue;
    if (is_path && array.first > 6 && array.width == 3)
      Refuse(from, fmt::format("a path has no `{}`; it follows from the positions", array.name),
             "name the columns to read: columns: \"t=/time, x=/position[:,0], …\"");
    for (std::size_t k = 0; k < array.width; ++k) {
      columns.has[array.first + k] = true;
      std::vector<double>& column = columns.values[array.first + k];
      for (std::size_t row = 0; row < columns.rows; ++row) {
        column.push_back((*array.values)[array.width * row + k]);
        if (!std::isfinite(column.back()))
          Refuse(from, fmt::format("row {} of `{}` is not finite", row, array.name),
                 "write finite numbers");
      }
    }
  }
  return layouts::PosesOfColumns(columns, poses);
}

/// The poses of the columns that the call names.
PoseTable PosesOfColumns(const std::vector<layouts::NamedColumn>& named, const Arguments& from,
                         const schema::Call& poses) {
  std::vector<std::string> written;
  std::vector<std::optional<text::Unit>> units;
  for (const layouts::NamedColumn& column : named) {
    plan::ColumnName name = plan::ParseColumnName(column.written);
    // Part of the array: `/pos[:,0]`.
    if (name.unit_text.find(':') != std::string::npos) name = {column.written, {}, {}};
    if (!name.unit_text.empty() && !name.unit)
      Refuse(from, fmt::format("`{}` is not a known unit", name.unit_text),
             fmt::format("the units are {}", text::UnitNames()));
    layouts::CheckUnit(column.column, name.unit, column.written, from.file);
    written.push_back(name.stem);
    units.push_back(name.unit);
  }
  std::vector<std::vector<double>> values = results::ReadColumns(from.file, written);
  layouts::PoseColumns columns;
  columns.name = from.file;
  columns.place = [&](std::size_t row) { return fmt::format("{}: row {}", from.file, row); };
  columns.rows = values[0].size();
  for (std::size_t i = 0; i < named.size(); ++i) {
    if (values[i].size() != columns.rows)
      Refuse(from,
             fmt::format("`{}` has {} rows, but `{}` has {}", written[i], values[i].size(),
                         written[0], columns.rows),
             "name columns of the same length");
    for (std::size_t row = 0; row < columns.rows; ++row) {
      double& value = values[i][row];
      if (!std::isfinite(value))
        Refuse(from, fmt::format("row {} of `{}` is not finite", row, written[i]),
               "write finite numbers");
      if (units[i]) value = plan::InSi(value, *units[i]);
    }
    columns.has[named[i].column] = true;
    columns.values[named[i].column] = std::move(values[i]);
  }
  return layouts::PosesOfColumns(columns, poses);
}

/// The arguments that concern text alone.
void CheckArguments(const Arguments& from, const schema::Call& poses) {
  for (const char* argument : {"separator", "decimal", "header"}) {
    const schema::Word* word = AsWord(schema::ArgumentOf(poses, argument));
    if (word == nullptr || word->text != "auto")
      Refuse(from, fmt::format("an HDF5 file has no {}", argument),
             fmt::format("remove {}", argument));
  }
}

std::string RemedyFor(const Arguments& from, bool names_columns) {
  const std::string arrays = results::ArraysIn(from.file);
  if (arrays.empty()) return "name a results file with poses, or one with a dataset `position`";
  const bool is_pandas = arrays.find("block0_values") != std::string::npos ||
                         arrays.find("values_block_0") != std::string::npos;
  return fmt::format(
      "{}it has {}{}",
      names_columns ? ""
                    : "name a results file with poses, one with a dataset `position`, or the "
                      "columns, such as columns: \"x=/log/x, y=/log/position[:,1], …\"; ",
      arrays,
      is_pandas ? "; from pandas, write h5py.File(\"start.h5\", \"w\")[\"position\"] = df[[\"x\", "
                  "\"y\", \"z\"]]"
                : "");
}

}  // namespace

PoseTable ReadHdf5Poses(const schema::Call& poses) {
  const Arguments from(poses);
  CheckArguments(from, poses);
  try {
    if (const auto named = layouts::NamedColumns(poses); !named.empty()) {
      if (from.cycle || from.run || from.group)
        Refuse(from, "columns are named, but not of cycles, runs or groups",
               "remove cycle, run and group, or columns");
      return PosesOfColumns(named, from, poses);
    }
    if (const auto arrays = results::ReadPoseArrays(from.file, poses.name == schema::kPathCall)) {
      if (from.cycle || from.run || from.group)
        Refuse(from, "it has `position`, but no cycles, runs or groups",
               "remove cycle, run and group");
      return TableOf(*arrays, from, poses);
    }
    if (poses.name == schema::kPathCall)
      Refuse(from, "a results file has poses by cycle, not by time",
             "write those of one object as datasets `time`, `position` and `orientation`, or as "
             "CSV: t,x,y,z,qw,qx,qy,qz");
    for (const char* argument : {"rotation", "up"})
      if (schema::ArgumentOf(poses, argument) !=
          schema::Value(schema::Word{argument == std::string_view("up") ? "y" : "none"}))
        Refuse(from, fmt::format("`{}` does not apply to a results file", argument),
               fmt::format("remove {}", argument));
    return RecordedPoses(ResultFile(from.file), from);
  } catch (const files::StoreError& error) {
    const std::string what = error.what();
    throw SceneError(what.starts_with(from.file) ? what : fmt::format("{}: {}", from.file, what),
                     RemedyFor(from, AsText(schema::ArgumentOf(poses, "columns")) != nullptr));
  }
}

}  // namespace cdb::options
