// The other files of a glTF scene.
//
// A .gltf file may keep its numbers in other files, its buffers. The file and its buffers count as
// one: their bytes follow each other, so that `cat a.gltf a.bin | sha256sum` is their hash.
// Errors: `why` is the reason, without the name of the file. Threads: any.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace cdb::plan {

/// The contents of a file, or nullopt and the reason.
using ReadFile =
    std::function<std::optional<std::string>(const std::string& path, std::string& why)>;

/// `bytes` of the file at `path`, and the buffers that it names, in their order; of each, as many
/// bytes as it declares. Other formats and damaged files remain as they are. Buffers must be in the
/// folder of the file or below. At most `max_bytes` in all.
std::optional<std::string> WithGltfBuffers(const std::string& path, std::string bytes,
                                           const ReadFile& read, std::size_t max_bytes,
                                           std::string& why);

}  // namespace cdb::plan
