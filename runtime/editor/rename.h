// Renames a let and all its uses.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "runtime/editor/documents.h"

namespace cdb::editor {

/// The name cannot be changed; the message gives the reason.
struct RenameError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The range of the let's name at this position. Throws RenameError.
Json PrepareRename(const Analysis& analysis, std::uint32_t offset);

/// Returns a WorkspaceEdit. The edited texts are compiled, and nothing is changed if the runs would
/// differ. Throws RenameError.
Json Rename(Documents& documents, Document& document, std::uint32_t offset, const std::string& name,
            const std::string& library);

}  // namespace cdb::editor
