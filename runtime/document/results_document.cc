#include "runtime/document/results_document.h"

#include <fmt/format.h>

#include <limits>

#include "runtime/conclusions/conclusions.h"
#include "runtime/document/comparison.h"
#include "runtime/document/cycles.h"
#include "runtime/document/head.h"
#include "runtime/document/points.h"
#include "runtime/document/source.h"
#include "runtime/document/warnings.h"

namespace cdb::document {
namespace {

constexpr int kVersion = 1;
/// Limit of failures on a page.
constexpr std::size_t kMaxFailures = 200;

std::string GeneratorOf(const store::ResultFile& file) {
  const std::string version = file.ReadProvenance("cdb_version");
  return version.empty() ? "cdb" : "cdb " + version;
}

Json IntervalWords(const DocumentSource& source) {
  const statistics::CycleTimes& times = source.times();
  const std::string name = times.IntervalName();
  return {{"name", name.empty() ? Json(nullptr) : Json(name)},
          {"text", Sentence(times.IntervalLine())}};
}

Json DocumentConclusions(const DocumentSource& source, bool only_sound) {
  Json all = Json::array();
  if (source.IsLarge()) return all;
  for (const conclusions::Conclusion& of : conclusions::Conclusions(
           {source.file(), source.measured(), source.findings(), source.times(), only_sound}))
    all.push_back({{"question", of.question},
                   {"answer", of.answer},
                   {"kind", of.kind},
                   {"certainty", conclusions::CertaintyName(of.certainty)}});
  return all;
}

void CheckSize(const DocumentSource& source) {
  if (source.points().size() > kMaxDocumentPoints)
    throw files::StoreError(
        fmt::format("{} points are more than a document can have ({}): select a part, by `cdb show "
                    "--json --select AXIS=VALUE`",
                    source.points().size(), kMaxDocumentPoints));
}

}  // namespace

DocumentText ResultsDocument(const store::ResultFile& file, const DocumentOptions& options) {
  const DocumentSource source(file, options.only_sound);
  CheckSize(source);
  Json document = {{"document", kVersion}, {"generator", GeneratorOf(file)}};
  document["sources"] = Json::array(
      {{{"file", options.file}, {"benchmark", file.benchmark()}, {"title", file.title()}}});
  document["title"] = file.title();
  document["runs"] = DocumentRuns(source);
  document["warnings"] = DocumentWarnings(source);
  document["conclusions"] = DocumentConclusions(source, options.only_sound);
  document["axes"] = DocumentAxes(source);
  document["detector_axis"] = DocumentDetectorAxis(source);
  document["statistic"] = Sentence(source.times().StatisticLine(false));
  document["interval"] = IntervalWords(source);
  document["phases"] = DocumentPhases();
  document["points"] = DocumentPoints(source);
  document["ratios"] = DocumentRatios(source, options.baseline);
  document["fronts"] = DocumentFronts(source, options.only_sound);
  if (options.for_page) {
    document["cycles"] = DocumentCycles(source);
    document["distributions"] = DocumentDistributions(source);
  }
  document["omissions"] = DocumentOmissions(source);
  document["findings"] = DocumentFindings(source);
  document["failures"] = DocumentFailures(
      source, options.for_page ? kMaxFailures : std::numeric_limits<std::size_t>::max());
  document["noise"] = DocumentNoise(source);
  document["machine"] = DocumentMachine(file);
  document["build"] = DocumentBuild(file);
  document["provenance"] = DocumentProvenance(file);
  // The text of damaged files may not be UTF-8.
  return {document.dump(-1, ' ', false, Json::error_handler_t::replace),
          source.groups().bad.size() + source.references().size()};
}

}  // namespace cdb::document
