#include <utility>

#include "runtime/printers/show_parts.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {

RowTable::RowTable(const store::ResultFile& file, const figures::Rows& rows)
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

void AddAxes(const store::ResultFile& file, const std::vector<std::size_t>& axes, Table& table) {
  for (const std::size_t axis : axes)
    table.AddColumn(file.axes()[axis].name, !file.axes()[axis].IsText());
  table.keys = axes.size();
}

std::vector<std::string> Coordinates(const store::ResultFile& file,
                                     const std::vector<std::size_t>& axes,
                                     const figures::Point& at) {
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < at.size(); ++i)
    cells.push_back(terminal::CoordinateText(file.axes()[axes[i]], at[i]));
  return cells;
}

}  // namespace cdb::printers
