// Damages a journal.
#pragma once

#include <filesystem>
#include <string>

namespace cdb::tests {

/// Changes a byte in the record of a run, behind the back of SQLite.
void ChangeFacts(const std::filesystem::path& journal, const std::string& run_id);

}  // namespace cdb::tests
