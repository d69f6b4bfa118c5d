// The detectors of the table that tests loop over.
#pragma once

#include <string>
#include <vector>

#include "compiler/schema/catalogue.h"

namespace cdb::tests {

/// Broad phases that find pairs: cdb's own, and unless `only_own`, Bullet's.
inline std::vector<std::string> BroadPhases(bool only_own = false) {
  std::vector<std::string> names;
  for (const schema::DetectorInfo& info : schema::Detectors())
    if (info.part.empty() && info.FindsPairs() && (info.IsOwn() || !only_own))
      names.emplace_back(info.name);
  return names;
}

}  // namespace cdb::tests
