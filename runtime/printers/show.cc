#include "runtime/printers/show.h"

#include <utility>
#include "runtime/figures/model.h"
#include "runtime/printers/show_parts.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

/// The axes that make the rows of each table.
std::vector<std::vector<std::size_t>> ChooseTables(const figures::Model& model,
                                                   const std::vector<std::size_t>& asked) {
  if (!asked.empty()) return {asked};
  const std::vector<std::size_t> all = figures::AllAxes(model.file());
  if (model.points().size() <= kMaxRows) return {all};
  std::vector<std::vector<std::size_t>> tables;
  for (const std::size_t axis : all) tables.push_back({axis});
  return tables;
}

}  // namespace

Printed Show(const results::ResultFile& file, const ShowOptions& options) {
  std::vector<std::size_t> asked;
  for (const std::string& name : options.by) asked.push_back(figures::FindAxis(file, name));
  const figures::Model model(file,
                             {.only_sound = options.only_sound, .statistic = options.statistic});
  Document document = {SummaryHead(model)};
  for (const auto& by : ChooseTables(model, asked)) AddPhases(model, by, options.phases, document);
  AddDetectors(model, asked, document);
  AddRatios(model, options.baseline, options.phases, document);
  AddOtherFaults(model, document);
  if (options.plots) AddPlots(model, options.phases, document);
  return {TextOf(document, options.format), model.bad_count()};
}

RowTable::RowTable(const results::ResultFile& file, const figures::Rows& rows)
    : file_(file), rows_(rows) {
  AddAxes(file, rows.by, table_);
  if (rows.pools) table_.AddColumn("cells", true);
}

void RowTable::AddRow(const figures::Row& row, const std::vector<std::string>& figures,
                      const std::string& note) {
  std::vector<std::string> cells = Coordinates(file_, rows_.by, row.at);
  if (rows_.pools) cells.push_back(row.CellsText());
  cells.insert(cells.end(), figures.begin(), figures.end());
  const std::string both = note + (note.empty() || row.mark.empty() ? "" : ", ") + row.mark;
  if (!both.empty()) cells.push_back(both);
  has_notes_ = has_notes_ || !both.empty();
  table_.rows.push_back(std::move(cells));
}

Table RowTable::Take() {
  if (has_notes_) table_.AddColumn("", false);
  return std::move(table_);
}

void AddAxes(const results::ResultFile& file, const std::vector<std::size_t>& axes, Table& table) {
  for (const std::size_t axis : axes)
    table.AddColumn(file.axes()[axis].name, !file.axes()[axis].IsText());
  table.keys = axes.size();
}

std::vector<std::string> Coordinates(const results::ResultFile& file,
                                     const std::vector<std::size_t>& axes,
                                     const figures::Point& at) {
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < at.size(); ++i)
    cells.push_back(terminal::CoordinateText(file.axes()[axes[i]], at[i]));
  return cells;
}

}  // namespace cdb::printers
