#include "runtime/printers/notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "runtime/protocol/machine/noise.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {

using figures::Cell;

std::string NoiseNote(const results::ResultFile& file, const std::vector<Cell>& cells) {
  if (!file.Has("noise") || !file.Has("noise_cause") || !file.Has("cpu_time")) return {};
  std::size_t noisy = 0;
  const Cell* worst = nullptr;
  double least_share = std::numeric_limits<double>::infinity();
  for (const Cell& cell : cells) {
    if (file.ReadReal("noise", cell) != static_cast<double>(machine::Noise::kNoisy)) continue;
    ++noisy;
    const double share = file.ReadReal("cpu_time", cell) / file.ReadReal("cycles_time", cell);
    if (worst != nullptr && !(share < least_share)) continue;
    least_share = share;
    worst = &cell;
  }
  if (worst == nullptr) return {};
  return fmt::format("The machine was noisy in {} of {} run{}; worst in {}: {} (cdb doc noise).",
                     noisy, cells.size(), cells.size() == 1 ? "" : "s",
                     figures::PlaceText(file, *worst), file.ReadText("noise_cause", *worst));
}

std::vector<std::string> ProcessorNotes(const results::ResultFile& file,
                                        const std::vector<Cell>& cells) {
  std::map<std::string, std::size_t> runs;
  std::map<figures::Point, std::set<std::string>> kinds;  // keyed by points without their detector
  const auto detector = figures::DetectorAxis(file);
  for (const Cell& cell : cells) {
    if (figures::EndingOf(file, cell).Rank() < 0) continue;
    std::string kind = file.ReadProvenance("cpu", cell);
    if (kind.empty()) kind = "a processor without a name";
    ++runs[kind];
    kinds[detector ? figures::Without(cell.at, *detector) : cell.at].insert(std::move(kind));
  }
  if (runs.size() < 2) return {};
  std::vector<std::string> notes = {
      "Run on different processors, whose times are not comparable (cdb doc cluster):"};
  for (const auto& [kind, count] : runs)
    notes.push_back(fmt::format("  {} run{} on {}", count, count == 1 ? "" : "s", kind));
  const auto mixed = static_cast<std::size_t>(
      std::ranges::count_if(kinds, [](const auto& point) { return point.second.size() > 1; }));
  if (mixed > 0)
    notes.push_back(fmt::format(
        "  At {} of {} points, detectors or repeats ran on several of them.", mixed, kinds.size()));
  return notes;
}

std::string HarnessNote(const figures::Model& model) {
  const auto cost = figures::HarnessCostOf(model);
  if (!cost) return {};
  std::string text =
      fmt::format("Measurement overhead: {} ns per cycle", terminal::ShortNumber(cost->median));
  if (const auto& fastest = cost->fastest)
    text += fmt::format(", {} % of the detection of {}{}",
                        terminal::ShortNumber(100 * cost->median / fastest->time),
                        fastest->detector.empty() ? "the detector" : fastest->detector,
                        fastest->is_only ? "" : ", the fastest");
  return text + "; not subtracted.";
}

std::string BuildNote(const results::ResultFile& file) {
  const std::string build = file.ReadProvenance("build_type");
  if (build == "Release") return {};
  return fmt::format("Timed with a {} build of cdb: do not quote these timings.", build);
}

std::string JobsNote(const results::ResultFile& file) {
  const std::string jobs = file.ReadProvenance("jobs");
  if (jobs.empty() || jobs == "1") return {};
  return fmt::format("Timed with parallel runs (jobs {}), which disturb each other.", jobs);
}

}  // namespace cdb::printers
