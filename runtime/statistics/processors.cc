#include "runtime/statistics/processors.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "runtime/statistics/cells.h"
#include "runtime/statistics/points.h"

namespace cdb::statistics {

std::string ProcessorText(const store::ResultFile& file,
                          const std::vector<store::ResultFile::Cell>& cells) {
  std::map<std::string, std::size_t> runs;
  std::map<Point, std::set<std::string>> kinds;  // keyed by points without their detector
  const auto detector = DetectorAxis(file);
  for (const store::ResultFile::Cell& cell : cells) {
    const store::Status status = file.ReadStatus(cell);
    if (status == store::Status::kMissing || status == store::Status::kSkipped) continue;
    std::string kind = file.ReadProvenance("cpu", cell);
    if (kind.empty()) kind = "a processor without a name";
    ++runs[kind];
    kinds[detector ? Without(cell.at, *detector) : cell.at].insert(std::move(kind));
  }
  if (runs.size() < 2) return {};
  std::string text =
      "  Run on different processors, whose times are not comparable (cdb doc cluster):\n";
  for (const auto& [kind, count] : runs)
    text += fmt::format("    {} run{} on {}\n", count, count == 1 ? "" : "s", kind);
  const auto mixed = static_cast<std::size_t>(
      std::ranges::count_if(kinds, [](const auto& point) { return point.second.size() > 1; }));
  if (mixed > 0)
    text += fmt::format("    At {} of {} points, detectors or repeats ran on several of them.\n",
                        mixed, kinds.size());
  return text;
}

}  // namespace cdb::statistics
