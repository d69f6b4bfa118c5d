#include "runtime/printers/results_document.h"

#include <fmt/format.h>

#include <limits>

#include "runtime/figures/conclusions.h"
#include "runtime/printers/json_parts.h"

namespace cdb::printers {
namespace {

constexpr int kVersion = 1;
/// Limit of failures on a page.
constexpr std::size_t kMaxFailures = 200;

std::string GeneratorOf(const store::ResultFile& file) {
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
        fmt::format("{} points are more than a document holds ({}): take a part of them, by `cdb "
                    "show --json --select AXIS=VALUE`",
                    model.grid().size(), kMaxDocumentPoints));
}

}  // namespace

Printed ResultsDocument(const store::ResultFile& file, const DocumentOptions& options) {
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

}  // namespace cdb::printers
