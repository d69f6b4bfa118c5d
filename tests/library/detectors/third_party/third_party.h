// The detectors of other libraries, for tests: those of the parts that are built.
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

/// The rows of the catalogue that are in a part and have the phase.
std::vector<schema::DetectorInfo> ThirdPartyDetectors(std::string_view phase);

/// Null where its part is not built, which fails the test if CDB_REQUIRE_RIVALS is set, else skips.
std::unique_ptr<Detector> MakeThirdParty(const schema::DetectorInfo& info);

/// Of GoogleTest's parameters: the detector's name.
struct DetectorName {
  template <typename Info>
  std::string operator()(const Info& info) const {
    return std::string(info.param.name);
  }
};

}  // namespace cdb::tests
