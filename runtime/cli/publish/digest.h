// The digest of a folder, a text that can be signed: the SHA-256 of each of its files, as
// `sha256sum` prints it, so that `sha256sum -c digest.txt` checks the folder without cdb.
//
// Threads: any.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace cdb::publish {

inline constexpr const char* kDigestFile = "digest.txt";
inline constexpr const char* kSignatureFile = "digest.txt.sig";

/// The SHA-256 of each file of a digest, by its name.
using Digest = std::map<std::string, std::string>;

/// Of the files in `folder`, without those of the digest and its signature. Throws CommandError if
/// one cannot be read.
Digest ComputeDigest(const std::filesystem::path& folder);

/// The digest as it is written in `folder`; empty if there is none that can be read.
Digest ReadDigest(const std::filesystem::path& folder);

/// A line for each file: `HEX  NAME`.
std::string DigestText(const Digest& digest);

/// The first digits of a digest of the results files in it (.h5), which tell results apart.
std::string ResultsWord(const Digest& digest);

/// The reasons why the files in `folder` are not those of its digest; empty if they are. Files that
/// the digest lacks are a fault, and so is all that is not a regular file.
std::vector<std::string> FindDigestFaults(const std::filesystem::path& folder);

}  // namespace cdb::publish
