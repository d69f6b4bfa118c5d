// Queries of the scene, for `cdb show` and `cdb verify`.

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "runtime/figures/model.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::QueryFigures;

/// One type of queries.
void AddTable(const figures::Model& model, const figures::Rows& rows, schema::QueryType type,
              Document& document) {
  const results::ResultFile& file = model.file();
  const bool is_counted = file.Has("query_count"), is_timed = file.Has("query_time"),
             is_compared = file.Has("compared_queries");
  RowTable table(file, rows);
  const auto add_columns = [&](std::initializer_list<const char*> heads) {
    for (const char* head : heads) table.AddColumn(head);
  };
  if (is_counted) add_columns({"queries", "hits"});
  if (is_timed) add_columns({"time, us", "update, us"});
  if (is_timed && is_counted) add_columns({"ns/query"});
  if (is_compared) add_columns({"compared", "missed", "false", "error, m", "normal error"});
  bool has_rows = false;
  for (const figures::Row& row : rows.rows) {
    const QueryFigures of = figures::QueriesOf(file, row.points, type);
    if (!of.HasQueries()) continue;
    has_rows = true;
    std::vector<std::string> figures;
    const auto add = [&](double value) { figures.push_back(terminal::ShortNumber(value)); };
    const auto add_count = [&](double value) {
      figures.push_back(std::isnan(value) ? "-" : fmt::format("{:.0f}", value));
    };
    if (is_counted) add(of.count), add(of.hits);
    if (is_timed) add(of.time_ns / 1e3), add(of.update_ns / 1e3);
    if (is_timed && is_counted) add(of.ns_per_query);
    if (is_compared) {
      add_count(of.compared), add_count(of.missed), add_count(of.wrong);
      add(of.error), add(of.normal_error);
    }
    table.AddRow(row, figures);
  }
  if (!has_rows) return;
  Section section = {.title = fmt::format("Queries of type {}, per cycle",
                                          schema::kQueryTypes[static_cast<std::size_t>(type)]),
                     .table = table.Take()};
  if (is_timed)
    section.notes.emplace_back(
        "time: of the queries, which is not part of step; update: of cdb's own tree, not part of "
        "ns/query (cdb doc queries).");
  if (is_compared)
    section.notes.emplace_back(
        "compared: with exact answers, over all cycles; the others only graze a body. error: the "
        "largest, of the distance, and of the normal in rad.");
  document.push_back(std::move(section));
}

}  // namespace

void AddQueries(const figures::Model& model, const std::vector<std::size_t>& by,
                Document& document) {
  if (model.points().empty() || !figures::HasQueries(model.file())) return;
  const figures::Rows rows = figures::MatchRows(model.points(), by);
  for (std::size_t type = 0; type < protocol::kQueryTypeCount; ++type)
    AddTable(model, rows, static_cast<schema::QueryType>(type), document);
}

}  // namespace cdb::printers
