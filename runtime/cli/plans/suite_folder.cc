#include "runtime/cli/plans/suite_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "compiler/plan/sha256.h"
#include "runtime/cli/options/exit_status.h"
#include "runtime/cli/plans/suite_plan.h"
#include "runtime/pages/page/page.h"
#include "runtime/printers/results_document.h"
#include "runtime/results/files/safe_file.h"

namespace cdb::plans {

namespace fs = std::filesystem;

namespace {

std::string FileSha256(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return plan::Sha256Hex(std::string(std::istreambuf_iterator<char>(in), {}));
}

bool IsLong(const results::ResultFile& file) {
  return std::ranges::any_of(file.axes(),
                             [](const plan::Axis& axis) { return axis.parameter == "seed"; });
}

}  // namespace

SuiteFolder ReadSuiteFolder(const fs::path& folder) {
  SuiteFolder read;
  std::error_code error;
  for (const figures::StandardScene& scene : figures::StandardScenes()) {
    const fs::path file = folder / scene.ResultName();
    if (!fs::exists(file, error)) {
      read.facts.missing.push_back(scene.Id());
      continue;
    }
    auto of = std::make_unique<figures::ComparedFile>(file, file.string());
    read.scenes.push_back(figures::CollectScene(scene, of->model));
    read.facts.sha256[scene.ResultName()] = FileSha256(file);
    read.files.push_back(std::move(of));
  }
  if (read.files.empty())
    throw options::CommandError(
        fmt::format("'{}' has no results of the standard suite; `cdb suite -o {}` makes them",
                    folder.string(), folder.string()));
  const figures::ComparedFile& first = *read.files[0];
  read.facts.is_long = IsLong(first.file);
  if (!read.facts.is_long && first.plan && !first.plan->runs.empty()) {
    const std::uint64_t seed = first.plan->runs[0].scene.world.Count("seed");
    if (seed != kLongSeeds[0]) read.facts.seed = seed;
  }
  return read;
}

std::string SuiteSummary(const SuiteFolder& read) {
  std::vector<const results::ResultFile*> files;
  for (const auto& of : read.files) files.push_back(&of->file);
  return printers::SuiteJson(read.scenes, files, read.facts);
}

void WriteSuiteSummary(const SuiteFolder& read, const fs::path& folder) {
  const std::string summary = SuiteSummary(read);
  files::WriteWhole(summary, folder / kSuiteSummary);
  std::string documents;
  for (const auto& of : read.files) {
    if (!documents.empty()) documents += ',';
    documents += printers::ResultsDocument(
                     of->file, {.file = fs::path(of->name).filename().string(), .for_page = true})
                     .text;
  }
  files::WriteWhole(
      page::Assemble(page::ReportTemplate(), "The standard suite of cdb",
                     fmt::format("{{\"suite\":{},\"documents\":[{}]}}", summary, documents)),
      folder / kSuitePage);
}

}  // namespace cdb::plans
