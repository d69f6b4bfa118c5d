#include "runtime/report/row_table.h"

#include <algorithm>
#include <utility>

namespace cdb::report {

void RowTable::AddRow(const statistics::Row& row, std::vector<std::string> figures,
                      const std::string& note) {
  const std::string both = note + (note.empty() || row.mark.empty() ? "" : ", ") + row.mark;
  lines_.push_back({row, std::move(figures), both});
}

std::string RowTable::Text() const {
  terminal::Table table(by_.size());
  for (const std::size_t axis : by_)
    table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
  if (pools_) table.AddColumn("cells", true);
  for (const std::string& head : heads_) table.AddColumn(head, true);
  if (std::ranges::any_of(lines_, [](const Line& line) { return !line.note.empty(); }))
    table.AddColumn("", false);
  for (const auto& [row, figures, note] : lines_) {
    std::vector<std::string> cells = Coordinates(file_, by_, row.at);
    if (pools_) cells.push_back(statistics::Rows::CellsText(row));
    cells.insert(cells.end(), figures.begin(), figures.end());
    if (!note.empty()) cells.push_back(note);
    table.AddRow(std::move(cells));
  }
  return table.Text();
}

std::vector<std::string> Coordinates(const store::ResultFile& file,
                                     const std::vector<std::size_t>& axes,
                                     const statistics::Point& at) {
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < at.size(); ++i)
    cells.push_back(terminal::CoordinateText(file.axes()[axes[i]], at[i]));
  return cells;
}

}  // namespace cdb::report
