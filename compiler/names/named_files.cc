#include "compiler/names/named_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <span>

#include "compiler/plan/foreign_model.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::names {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTableFormats[] = {".csv", ".tsv", ".txt", ".h5", ".hdf5", ".nc"};

std::string LowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::span<const std::string_view> FormatsOf(const schema::Call& call) {
  if (call.name == schema::kTraceCall) return {};  // as the user named it
  if (call.name == schema::kPosesCall || call.name == schema::kPathCall) return kTableFormats;
  if (call.name == schema::kListCall || call.name == schema::kTableCall)
    return analysis::kTextFormats;
  if (call.name == schema::kHeightsCall) return plan::kHeightFormats;
  if (call.name == schema::kVoxelsCall) return plan::kVoxelFormats;
  return plan::kModelFormats;
}

/// What a file should be, and the function that tells what else it is; null if none does.
struct Reader {
  std::string_view what;
  plan::ForeignModel (*foreign)(std::string_view name, std::string_view bytes);
};
Reader ReaderOf(const schema::Call& call, bool is_table) {
  if (is_table) return {"table", nullptr};
  if (call.name == schema::kHeightsCall) return {"height field", plan::ForeignHeightsOf};
  if (call.name == schema::kVoxelsCall) return {"grid of voxels", plan::ForeignVoxelsOf};
  return {"model", plan::ForeignModelOf};
}

/// The SHA-256 of the table in `call`, which is at `written` in a scenario; nullopt after a
/// diagnostic.
std::optional<std::string> HashOfTable(const scenario::Scenario& scenario, const schema::Call& call,
                                       const text::Span& written, dsl::Diagnostics& diagnostics) {
  for (const char* name : {"cycle", "run", "group"}) {
    if (call.name == schema::kPathCall || !analysis::IsCsv(call) || AsWord(ArgumentOf(call, name)))
      continue;
    diagnostics.Report(scenario::kBadArguments, written, fmt::format("a CSV file has no {}s", name),
                       fmt::format("remove {}, or name a results file (.h5)", name));
    return std::nullopt;
  }
  analysis::PoseFault why;
  if (const auto facts = scenario.PosesAt(call, why)) return facts->sha256;
  if (why.is_unreadable) {
    diagnostics.Report(scenario::kNoSuchFile, written, fmt::format("cannot read {}", why.cause),
                       why.remedy);
  } else {
    diagnostics.Report(scenario::kOutOfDomain, written, why.cause, why.remedy);
  }
  return std::nullopt;
}

/// The SHA-256 of the trace or model at `path`; nullopt after a diagnostic.
std::optional<std::string> HashOf(const scenario::Scenario& scenario, bool is_trace,
                                  const std::string& path, const text::Span& written,
                                  dsl::Diagnostics& diagnostics) {
  std::string why;
  std::optional<std::string> hash;
  if (is_trace) {
    if (const auto facts = scenario.TraceAt(path, why)) hash = facts->sha256;
  } else {
    hash = scenario.HashOf(path, why);
  }
  if (!hash)
    diagnostics.Report(
        scenario::kNoSuchFile, written, fmt::format("cannot read '{}': {}", path, why),
        fmt::format("{}the path is relative to the folder of the .cdb file that names it",
                    is_trace ? "`cdb trace` writes such files; " : ""));
  return hash;
}

}  // namespace

bool ReadNamedFile(const scenario::Scenario& scenario, schema::Call& call,
                   dsl::Diagnostics& diagnostics) {
  const auto [name, written] = std::get<schema::Text>(call.arguments[0]);
  const bool is_table = call.name == schema::kPosesCall || call.name == schema::kPathCall;
  const std::string extension = LowerCase(fs::path(name).extension().string());
  const auto formats = FormatsOf(call);
  const bool is_list = call.name == schema::kListCall || call.name == schema::kTableCall;
  const Reader reader = ReaderOf(call, is_table || is_list);
  const bool is_imported = reader.foreign == plan::ForeignModelOf && !formats.empty() &&
                           !plan::ImporterOf(extension).empty();
  if (!formats.empty() && !is_imported && std::ranges::find(formats, extension) == formats.end()) {
    const auto [kind, remedy] =
        reader.foreign != nullptr ? reader.foreign(name, std::string_view()) : plan::ForeignModel();
    diagnostics.Report(
        scenario::kOutOfDomain, written,
        kind.empty() ? fmt::format("'{}' is not a readable {}", name, reader.what)
                     : fmt::format("'{}' is {}, not a {} that cdb reads", name, kind, reader.what),
        kind.empty() ? fmt::format("its name ends in {}", fmt::join(formats, ", ")) : remedy);
    return false;
  }
  const fs::path folder = fs::path(written.source->name()).parent_path();
  const std::string path = (folder / name).lexically_normal().string();
  const schema::Value wanted_hash = call.arguments[1];
  call.arguments[0] = schema::Text{path};
  const auto hash =
      is_table ? HashOfTable(scenario, call, written, diagnostics)
               : HashOf(scenario, call.name == schema::kTraceCall, path, written, diagnostics);
  if (!hash) return false;
  const schema::Text* wanted = AsText(wanted_hash);
  if (wanted != nullptr && LowerCase(wanted->text) != *hash) {
    diagnostics.Report(scenario::kContradiction, wanted->written,
                       fmt::format("'{}' has the SHA-256 {}, not {}", path, *hash, wanted->text),
                       "it is a different file, or it was changed");
    return false;
  }
  call.arguments[1] = schema::Text{*hash};
  return true;
}

std::optional<schema::Call> TraceNamed(const scenario::Scenario& scenario, const schema::Text& name,
                                       dsl::Diagnostics& diagnostics) {
  const schema::ParametrisedWord& info = *schema::FindParametrisedWord(schema::kTraceCall);
  schema::Call call{std::string(info.name), {name, schema::DefaultOf(info.arguments[1])}};
  if (!ReadNamedFile(scenario, call, diagnostics)) return std::nullopt;
  return call;
}

}  // namespace cdb::names
