// Diagnostics in the format of rustc: one JSON object per line.
#pragma once

#include <string>

#include "dsl/diagnostics.h"

namespace cdb::options {

/// One object per line, in order of file and position. The fields are those of `rustc
/// --error-format=json`: message, code, level, spans (file_name, byte_start, byte_end, line_start,
/// line_end, column_start, column_end, is_primary, text, label), children (notes and help),
/// rendered. Bytes count from 0 in the file, lines and columns (code points) from 1; ends are
/// exclusive. Bytes that are not UTF-8 become U+FFFD.
std::string DiagnosticsJson(const dsl::Diagnostics& diagnostics);

}  // namespace cdb::options
