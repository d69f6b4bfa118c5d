#include "runtime/printers/results_document.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "compiler/schema/metrics.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/model.h"
#include "runtime/printers/json_parts.h"

namespace cdb::printers {
namespace {

constexpr int kVersion = 1;
/// Limit of failures on a page.
constexpr std::size_t kMaxFailures = 200;

std::string GeneratorOf(const results::ResultFile& file) {
  const std::string version = file.ReadProvenance("cdb_version");
  return version.empty() ? "cdb" : "cdb " + version;
}

Json IntervalWords(const figures::Model& model) {
  const figures::CycleTimes& times = model.times();
  const std::string name = times.IntervalName();
  return {{"name", name.empty() ? Json(nullptr) : Json(name)}, {"text", times.IntervalNote()}};
}

Json DocumentConclusions(const figures::Model& model) {
  Json all = Json::array();
  if (IsLarge(model)) return all;
  for (const figures::Conclusion& of : figures::Conclusions(model))
    all.push_back({{"question", of.question},
                   {"answer", of.answer},
                   {"kind", of.kind},
                   {"certainty", figures::CertaintyName(of.certainty)}});
  return all;
}

void CheckSize(const figures::Model& model) {
  if (model.grid().size() > kMaxDocumentPoints)
    throw files::StoreError(
        fmt::format("{} points are more than a document can have ({}): select a part, by `cdb show "
                    "--json --select AXIS=VALUE`",
                    model.grid().size(), kMaxDocumentPoints));
}

using figures::GridPoint;
using figures::MeasuredPoint;

class PointTable {
 public:
  PointTable(const figures::Model& model, const std::vector<protocol::Phase>& phases)
      : model_(model), file_(model.file()) {
    table_.rows.resize(model.grid().size());
    AddAxes();
    Add("verdict", [](const GridPoint& point) { return point.ending.Word(); });
    Add("mark", [](const GridPoint& point) { return point.Mark(); });
    Add("repeats", [](const GridPoint& point) {
      return std::to_string(point.measured == nullptr ? 0 : point.measured->cells.size());
    });
    if (model.HasTimes())
      for (const protocol::Phase phase : phases.empty() ? figures::AllPhases() : phases)
        AddPhase(phase);
    for (const char* series : {"pairs", "manifolds", "contacts", "missed_pairs"})
      if (file_.Has(series))
        AddNumber(series,
                  [&](const MeasuredPoint& point) { return model_.CountOf(point, series); });
    if (file_.Has("peak_rss"))
      AddNumber("peak_rss_bytes",
                [&](const MeasuredPoint& point) { return model_.MemoryOf(point, "peak_rss"); });
    AddErrors();
  }

  const Table& table() const { return table_; }

 private:
  void Add(const std::string& head, const std::function<std::string(const GridPoint&)>& value) {
    table_.AddColumn(head, false);
    for (std::size_t i = 0; i < table_.rows.size(); ++i)
      table_.rows[i].push_back(value(model_.grid()[i]));
  }
  /// A numeric column for points with cycles.
  void AddNumber(const std::string& head,
                 const std::function<double(const MeasuredPoint&)>& value) {
    Add(head, [&](const GridPoint& point) {
      const double number = point.measured == nullptr ? figures::kNone : value(*point.measured);
      return std::isfinite(number) ? fmt::format("{:.6g}", number) : std::string();
    });
  }

  void AddAxes() {
    for (const std::size_t i : figures::AllAxes(file_))
      Add(model_.axis(i).name, [&](const GridPoint& point) {
        const plan::Coordinate& value = model_.axis(i).values[point.at[i]];
        if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
        return std::get<std::string>(value);
      });
  }

  void AddPhase(protocol::Phase phase) {
    const figures::CycleTimes& times = model_.times();
    const std::string name = figures::PhaseName(phase);
    const auto add = [&](const std::string& head, auto part_of) {
      AddNumber(head,
                [&](const MeasuredPoint& point) { return part_of(model_.TimeOf(point, phase)); });
    };
    using Figure = figures::Estimate;
    add(fmt::format("{}_{}_ns", name, times.StatisticName()),
        [](const Figure& figure) { return figure.value; });
    add(name + "_low_ns", [&](const Figure& figure) { return times.IntervalOf(figure).low; });
    add(name + "_high_ns", [&](const Figure& figure) { return times.IntervalOf(figure).high; });
  }

  void AddErrors() {
    for (const schema::ErrorInfo& error : schema::Errors())
      for (const char* suffix : {"", "_floor"}) {
        const std::string name = std::string(error.name) + suffix;
        // With a prefix, as an axis may have the same name.
        if (file_.Has("accuracy/" + name))
          AddNumber("error_" + name,
                    [&](const MeasuredPoint& point) { return model_.ErrorOf(point, name); });
      }
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  Table table_;
};

}  // namespace

Printed ResultsDocument(const results::ResultFile& file, const DocumentOptions& options) {
  const figures::Model model(file, {.only_sound = options.only_sound});
  CheckSize(model);
  const auto comparison = figures::CompareDetectors(model, options.baseline);
  const figures::Comparison* ratios = comparison ? &*comparison : nullptr;
  Json document = {{"document", kVersion}, {"generator", GeneratorOf(file)}};
  document["sources"] = Json::array(
      {{{"file", options.file}, {"benchmark", file.benchmark()}, {"title", file.title()}}});
  document["title"] = file.title();
  document["runs"] = DocumentRuns(model);
  document["warnings"] = DocumentWarnings(model);
  document["conclusions"] = DocumentConclusions(model);
  document["axes"] = DocumentAxes(model);
  document["detector_axis"] = model.detector_axis() ? Json(*model.detector_axis()) : Json(nullptr);
  document["statistic"] = model.times().StatisticNote(false);
  document["interval"] = IntervalWords(model);
  document["phases"] = DocumentPhases();
  document["points"] = DocumentPoints(model);
  document["ratios"] = DocumentRatios(model, ratios);
  document["fronts"] = DocumentFronts(model);
  if (options.for_page) {
    document["pooled"] = DocumentPooled(model, ratios);
    document["cycles"] = DocumentCycles(model);
    document["distributions"] = DocumentDistributions(model);
  }
  document["omissions"] = DocumentOmissions(model);
  document["findings"] = DocumentFindings(model);
  document["failures"] = DocumentFailures(
      model, options.for_page ? kMaxFailures : std::numeric_limits<std::size_t>::max());
  document["noise"] = DocumentNoise(model);
  document["machine"] = DocumentMachine(file);
  document["build"] = DocumentBuild(file);
  document["provenance"] = DocumentProvenance(file);
  // The text of damaged files may not be UTF-8.
  return {document.dump(-1, ' ', false, Json::error_handler_t::replace), model.bad_count()};
}

Printed CsvText(const results::ResultFile& file, const CsvOptions& options) {
  const figures::Model model(file,
                             {.only_sound = options.only_sound, .statistic = options.statistic});
  return {CsvOf(PointTable(model, options.phases).table()), model.runs().bad.size()};
}

}  // namespace cdb::printers
