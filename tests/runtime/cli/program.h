// Runs `cdb` as a user would, in a folder of its own.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace cdb::tests {

struct Finished {
  int status = 0;  ///< exit status; 128 + signal where a signal ended it
  std::string out, err;
};

/// A folder that goes when this does, and the program in it.
class Program {
 public:
  Program();
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  void Write(const std::string& name, const std::string& text) const;
  std::string Read(const std::string& name) const;
  bool Exists(const std::string& name) const;

  /// `cdb` with these arguments, in the folder.
  Finished Run(const std::vector<std::string>& arguments) const;
  /// A line for the shell, in the folder; `$CDB` is the program.
  Finished Shell(const std::string& line) const;
  /// Starts `cdb` and returns its process.
  pid_t Start(const std::vector<std::string>& arguments) const;

 private:
  std::filesystem::path folder_;
};

/// The program that the tests belong to.
std::string CdbPath();

}  // namespace cdb::tests
