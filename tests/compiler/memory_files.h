// Files that are only in memory, for tests of the compiler.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "compiler/compile.h"

namespace cdb::compiler {

/// Traces of a hundred cycles: a crowd of 1000 bodies in single precision, and what is too large
/// for `sap` in double.
inline std::optional<TraceFacts> MadeUpTraces(const std::string& path, std::string& why) {
  if (path.ends_with("crowd.trace.h5"))
    return TraceFacts{std::string(64, 'c'), 1000, 100, 1.0 / 60, false};
  if (path.ends_with("large.trace.h5"))
    return TraceFacts{std::string(64, '1'), 100'000, 100, 1.0 / 240, true};
  why = path.ends_with("result.h5") ? "it is HDF5, but no trace (cdb-results)"
                                    : "there is no such file";
  return std::nullopt;
}

/// Compiles `text` as `test.cdb` beside `others`.
inline Compilation CompileText(const std::string& text,
                               std::map<std::string, std::string> others = {}) {
  others["test.cdb"] = text;
  return Compile("test.cdb",
                 [&](const std::string& path, std::string& why) -> std::optional<std::string> {
                   const auto file = others.find(path);
                   if (file != others.end()) return file->second;
                   why = "No such file or directory";
                   return std::nullopt;
                 },
                 {"lib", std::nullopt, MadeUpTraces});
}

}  // namespace cdb::compiler
