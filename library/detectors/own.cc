#include "library/detectors/own.h"

namespace cdb::library {
namespace {

/// Finds nothing: what calling a detector costs.
class Null final : public Detector {};

template <typename T>
Detector* Make(const Options&) {
  return new T;
}

constexpr DetectorEntry kEntries[] = {
    {"null", "finds nothing", kBroad, 0, Make<Null>},
};

}  // namespace

std::span<const DetectorEntry> OwnDetectors() { return kEntries; }

}  // namespace cdb::library
