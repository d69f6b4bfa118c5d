// The outcomes of the runs of a sweep over one axis.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "runtime/results/store.h"

namespace cdb::tests {

struct CellEnd {
  results::Status status;
  std::string message, state_hash;
};

/// The outcome of the run at each value of the only axis.
inline std::map<std::string, CellEnd> Ends(const std::filesystem::path& file) {
  const results::ResultFile result(file);
  std::map<std::string, CellEnd> ends;
  const plan::Axis axis = result.axes().at(0);
  for (std::size_t i = 0; i < axis.values.size(); ++i) {
    const results::ResultFile::Cell cell{{i}, 0};
    ends[std::get<std::string>(axis.values[i])] = {result.ReadStatus(cell),
                                                   result.ReadText("message", cell),
                                                   result.ReadText("state_hash", cell)};
  }
  return ends;
}

inline bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace cdb::tests
