#include "compiler/yaml/brief_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "compiler/plan/plan.h"
#include "compiler/yaml/plan_yaml.h"

namespace cdb::yaml {
namespace {

/// The text after `key` in a line that begins with it.
bool Follows(std::string_view line, std::string_view key, std::string_view& rest) {
  if (!line.starts_with(key)) return false;
  rest = line.substr(key.size());
  return true;
}

bool ReadCount(std::string_view text, std::uint64_t& count) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, count);
  return error == std::errc{} && stop == end;
}

/// `[1, 2, 3]`.
bool ReadIndices(std::string_view text, std::vector<std::size_t>& indices) {
  if (!text.starts_with('[') || !text.ends_with(']')) return false;
  text = text.substr(1, text.size() - 2);
  while (!text.empty()) {
    const std::string_view item = text.substr(0, text.find(','));
    std::uint64_t index = 0;
    if (!ReadCount(item, index)) return false;
    indices.push_back(index);
    text.remove_prefix(std::min(text.size(), item.size() + 2));
  }
  return true;
}

/// False if the line is malformed.
bool ReadLine(std::string_view line, BriefRun& run) {
  std::string_view rest;
  if (Follows(line, "    at: ", rest)) return ReadIndices(rest, run.at);
  if (Follows(line, "      detector: ", rest)) run.detector = rest;
  if (!Follows(line, "        quantity: ", rest)) return true;
  std::uint64_t objects = 0;
  if (!ReadCount(rest, objects)) return false;
  run.objects += objects;
  return true;
}

}  // namespace

std::optional<std::vector<BriefRun>> FindBriefRuns(std::string_view yaml) {
  constexpr std::string_view kRuns = "\nruns:\n";
  const std::size_t begin = yaml.find(kRuns);
  if (begin == std::string_view::npos) return std::nullopt;
  const std::string version = fmt::format("\n{}: {}\n", kPlanFormat, plan::kPlanVersion);
  if (yaml.substr(0, begin).find(version) == std::string_view::npos) return std::nullopt;
  yaml.remove_prefix(begin + kRuns.size());
  std::vector<BriefRun> runs;
  while (!yaml.empty()) {
    const std::string_view line = yaml.substr(0, yaml.find('\n'));
    if (!line.starts_with(' ')) break;  // `scenario:`
    yaml.remove_prefix(std::min(yaml.size(), line.size() + 1));
    std::string_view id;
    if (Follows(line, "  - id: \"", id)) {
      runs.push_back({std::string(id.substr(0, id.find('"'))), {}, {}, 0});
    } else if (runs.empty() || !ReadLine(line, runs.back())) {
      return std::nullopt;
    }
  }
  return runs;
}

}  // namespace cdb::yaml
