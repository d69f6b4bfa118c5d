// Temporary folders, and functions that read and write whole files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cdb::tests {

/// An empty folder, removed on destruction.
class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Names of the files in a folder, sorted.
std::vector<std::string> FilesIn(const std::filesystem::path& folder);

/// Both throw std::runtime_error on failure.
std::string ReadFile(const std::filesystem::path& file);
void WriteFile(const std::filesystem::path& file, const std::string& bytes);

}  // namespace cdb::tests
