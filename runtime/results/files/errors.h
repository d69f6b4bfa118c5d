// Errors of reading and writing files.
#pragma once

#include <stdexcept>

namespace cdb::files {

/// A file is damaged, or could not be read or written. The message names the file, the cause, what
/// was kept, and the remedy. Exit status 2.
class StoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The system cannot read or check a file at the moment. This implies nothing about the file; it is
/// not a StoreError, so that it is not taken for damage.
class CannotRead : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cdb::files
