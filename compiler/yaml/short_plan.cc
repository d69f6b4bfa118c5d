#include "compiler/yaml/short_plan.h"

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

/// Reads the lines of a run. Settings at their defaults have none.
class LineReader {
 public:
  BriefRun Begin(std::string_view id) const {
    return {std::string(id),
            {},
            std::string(defaults_.WordOr("detector")),
            std::string(defaults_.WordOr("narrow_phase")),
            0,
            false};
  }

  /// False if the line is malformed.
  bool Read(std::string_view line, BriefRun& run) const {
    std::string_view rest;
    if (Follows(line, "    at: ", rest)) return ReadIndices(rest, run.at);
    if (Follows(line, "      detector: ", rest)) run.detector = rest;
    if (Follows(line, "      narrow_phase: ", rest)) run.narrow_phase = rest;
    if (Follows(line, "      trace: ", rest)) run.is_on_trace = true;
    if (Follows(line, "      - name: ", rest)) run.objects += quantity_;
    if (!Follows(line, "        quantity: ", rest)) return true;
    std::uint64_t objects = 0;
    if (!ReadCount(rest, objects)) return false;
    run.objects += objects - quantity_;
    return true;
  }

 private:
  const plan::WorldSettings defaults_ = {};
  const std::uint64_t quantity_ = plan::GroupSettings().Count("quantity");
};

}  // namespace

std::optional<int> FindPlanVersion(std::string_view yaml) {
  constexpr std::size_t kHead = 400;
  const std::string_view head = yaml.substr(0, kHead);
  for (const std::string_view format : {kPlanFormat, kShortPlanFormat}) {
    const std::string key = fmt::format("\n{}: ", format);
    const std::size_t at = head.find(key);
    std::uint64_t version = 0;
    if (at == head.npos) continue;
    const std::string_view rest = head.substr(at + key.size());
    if (ReadCount(rest.substr(0, rest.find('\n')), version)) return static_cast<int>(version);
  }
  return std::nullopt;
}

std::optional<std::vector<BriefRun>> FindBriefRuns(std::string_view yaml) {
  constexpr std::string_view kRuns = "\nruns:\n";
  const std::size_t begin = yaml.find(kRuns);
  if (begin == std::string_view::npos) return std::nullopt;
  const auto version = FindPlanVersion(yaml);
  if (!version || *version < plan::kOldestPlanVersion || *version > plan::kPlanVersion)
    return std::nullopt;
  const LineReader reader;
  yaml.remove_prefix(begin + kRuns.size());
  std::vector<BriefRun> runs;
  while (!yaml.empty()) {
    const std::string_view line = yaml.substr(0, yaml.find('\n'));
    if (!line.starts_with(' ')) break;  // `scenario:`
    yaml.remove_prefix(std::min(yaml.size(), line.size() + 1));
    std::string_view id;
    if (Follows(line, "  - id: \"", id)) {
      runs.push_back(reader.Begin(id.substr(0, id.find('"'))));
    } else if (runs.empty() || !reader.Read(line, runs.back())) {
      return std::nullopt;
    }
  }
  return runs;
}

}  // namespace cdb::yaml
