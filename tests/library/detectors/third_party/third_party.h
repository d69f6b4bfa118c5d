// The detectors of third-party libraries, for tests: those whose modules are built.
#pragma once

#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "library/detectors/detector.h"

namespace cdb::tests {

/// For GoogleTest's messages.
inline void PrintTo(const schema::DetectorInfo& info, std::ostream* out) { *out << info.name; }

}  // namespace cdb::tests

namespace cdb::tests {

/// Rows of the catalogue for the phase that belong to third-party libraries.
std::vector<schema::DetectorInfo> ThirdPartyDetectors(std::string_view phase);

/// Null if the module is not built.
std::unique_ptr<Detector> MakeThirdParty(const schema::DetectorInfo& info);

/// Names GoogleTest's instances by detector.
struct DetectorName {
  template <typename Info>
  std::string operator()(const Info& info) const {
    return std::string(info.param.name);
  }
};

}  // namespace cdb::tests
