// Runs `cdb` as a user would, in a temporary folder.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/files.h"

namespace cdb::tests {

struct Finished {
  int status = 0;  ///< exit status; 128 + signal if a signal ended it
  std::string out, err;
};

/// A temporary folder, with functions to run the program in it.
class Program {
 public:
  const std::filesystem::path& folder() const { return folder_.path(); }
  void Write(const std::string& name, const std::string& text) const;
  /// Empty if there is no such file.
  std::string Read(const std::string& name) const;
  bool Exists(const std::string& name) const;

  /// Runs `cdb` with these arguments, in the folder.
  Finished Run(const std::vector<std::string>& arguments) const;
  /// Runs a line of shell code, in the folder; `$CDB` is the program.
  Finished Shell(const std::string& line) const;
  /// Starts `cdb` and returns its process id.
  pid_t Start(const std::vector<std::string>& arguments) const;

 private:
  TemporaryFolder folder_;
};

/// The path of the program under test.
std::string CdbPath();

}  // namespace cdb::tests
