#include "tests/support/folders.h"

namespace cdb::tests {

std::filesystem::path SourceFolder() { return CDB_SOURCE_DIR; }
std::filesystem::path BuildFolder() { return CDB_BINARY_DIR; }

}  // namespace cdb::tests
