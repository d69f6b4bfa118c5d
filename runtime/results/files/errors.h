// Errors of reading and writing files.
#pragma once

#include <stdexcept>

namespace cdb::files {

/// A file is damaged, or could not be read or written. The message names the file, the cause, what
/// was kept, and the remedy. Exit status 2. If the system cannot read or check a file at the
/// moment, which implies nothing about the file, std::runtime_error is thrown instead.
class StoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cdb::files
