// Completion: the words that are allowed at a position.
#pragma once

#include <string>

#include "runtime/editor/documents.h"

namespace cdb::editor {

/// A list of CompletionItem. `library`: the folder of the scenarios that come with cdb.
Json Complete(const Analysis& analysis, const std::string& path, std::uint32_t offset,
              const std::string& library);

}  // namespace cdb::editor
