// Renaming a let wherever it is used.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "runtime/lsp/documents.h"

namespace cdb::lsp {

/// The name cannot be changed; the text says why.
struct RenameError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The range of the let's name at this place. Throws RenameError.
Json PrepareRename(const Analysis& analysis, std::uint32_t offset);

/// A WorkspaceEdit. The edited texts are compiled: if the runs would not be the same, nothing is
/// changed. Throws RenameError.
Json Rename(Documents& documents, Document& document, std::uint32_t offset, const std::string& name,
            const std::string& library);

}  // namespace cdb::lsp
