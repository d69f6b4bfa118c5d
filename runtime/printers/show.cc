#include "runtime/printers/show.h"

#include "runtime/figures/model.h"
#include "runtime/printers/show_parts.h"

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

Printed Show(const store::ResultFile& file, const ShowOptions& options) {
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

}  // namespace cdb::printers
