// Files that are only in memory, for tests of the compiler.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "compiler/compile.h"

namespace cdb::compiler {

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
                 {"lib", std::nullopt});
}

}  // namespace cdb::compiler
