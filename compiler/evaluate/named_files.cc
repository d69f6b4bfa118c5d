#include "compiler/evaluate/named_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::evaluate {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kModelFormats[] = {".obj", ".ply", ".stl", ".off"};

std::string LowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// The SHA-256 of the trace or model at `path`; else `why` not.
std::optional<std::string> HashOf(const scenario::Scenario& scenario, bool is_trace,
                                  const std::string& path, std::string& why) {
  if (!is_trace) return scenario.HashOf(path, why);
  const auto facts = scenario.TraceAt(path, why);
  return facts ? std::optional(facts->sha256) : std::nullopt;
}

}  // namespace

bool ReadNamedFile(const scenario::Scenario& scenario, schema::Call& call,
                   dsl::Diagnostics& diagnostics) {
  const auto& [name, written] = std::get<schema::Text>(call.arguments[0]);
  const bool is_trace = call.name == schema::kTraceCall;
  const std::string extension = LowerCase(fs::path(name).extension().string());
  if (!is_trace && std::ranges::find(kModelFormats, extension) == std::end(kModelFormats)) {
    diagnostics.Report(scenario::kOutOfDomain, written,
                       fmt::format("'{}' is no model that can be read", name),
                       fmt::format("its name ends in {}", fmt::join(kModelFormats, ", ")));
    return false;
  }
  const fs::path folder = fs::path(written.source->name()).parent_path();
  const std::string path = (folder / name).lexically_normal().string();
  std::string why;
  const auto hash = HashOf(scenario, is_trace, path, why);
  if (!hash) {
    diagnostics.Report(
        scenario::kNoSuchFile, written, fmt::format("cannot read '{}': {}", path, why),
        fmt::format("{}its name counts from the folder of the .cdb file that says it",
                    is_trace ? "`cdb trace` writes such files; " : ""));
    return false;
  }
  const schema::Text* wanted = AsText(call.arguments[1]);
  if (wanted != nullptr && LowerCase(wanted->text) != *hash) {
    diagnostics.Report(scenario::kContradiction, wanted->written,
                       fmt::format("'{}' has the SHA-256 {}, not {}", path, *hash, wanted->text),
                       "it is another file than the one meant, or was changed");
    return false;
  }
  call.arguments = {schema::Text{path}, schema::Text{*hash}};
  return true;
}

std::optional<schema::Call> TraceNamed(const scenario::Scenario& scenario, const schema::Text& name,
                                       dsl::Diagnostics& diagnostics) {
  const schema::ParametrisedWord& info = *schema::FindParametrisedWord(schema::kTraceCall);
  schema::Call call{std::string(info.name), {name, schema::DefaultOf(info.arguments[1])}};
  if (!ReadNamedFile(scenario, call, diagnostics)) return std::nullopt;
  return call;
}

}  // namespace cdb::evaluate
