#include "runtime/report/show_noise.h"

#include <fmt/format.h>

#include <limits>

#include "runtime/machine/noise.h"
#include "runtime/statistics/cells.h"

namespace cdb::report {

std::string NoiseText(const store::ResultFile& file,
                      const std::vector<store::ResultFile::Cell>& cells) {
  if (!file.Has("noise") || !file.Has("noise_cause") || !file.Has("cpu_time")) return {};
  std::size_t noisy = 0;
  const store::ResultFile::Cell* worst = nullptr;
  double least_share = std::numeric_limits<double>::infinity();
  for (const store::ResultFile::Cell& cell : cells) {
    if (file.ReadReal("noise", cell) != static_cast<double>(machine::Noise::kNoisy)) continue;
    ++noisy;
    const double share = file.ReadReal("cpu_time", cell) / file.ReadReal("cycles_time", cell);
    if (worst != nullptr && !(share < least_share)) continue;
    least_share = share;
    worst = &cell;
  }
  if (worst == nullptr) return {};
  return fmt::format(
      "  The machine was noisy in {} of {} run{}; worst in {}: {} (cdb doc noise).\n", noisy,
      cells.size(), cells.size() == 1 ? "" : "s", statistics::PlaceText(file, *worst),
      file.ReadText("noise_cause", *worst));
}

}  // namespace cdb::report
