#include "library/detectors/plugin.h"

#include <dlfcn.h>
#include <elf.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

#include "library/detectors/c_detector.h"
#include "library/detectors/detector.h"

namespace cdb::detectors {

namespace {

bool IsName(std::string_view text) {
  const auto is_word = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !text.empty() && !(text[0] >= '0' && text[0] <= '9') && std::ranges::all_of(text, is_word);
}

/// None if they are not written as CDB_PHASES_... are.
Phases PhasesOf(const cdb_detector& row) {
  const std::string_view text = row.phases;
  const Phases poses = row.needs_poses != 0 ? kNeedsPoses : Phases{};
  if (text == CDB_PHASES_BROAD) return kBroad | poses;
  if (text == CDB_PHASES_NARROW) return kNarrow | poses;
  if (text == CDB_PHASES_BOTH) return kBroad | kNarrow | poses;
  return poses;
}

bool IsComplete(const DetectorEntry& entry) {
  return entry.name != nullptr && entry.doc != nullptr && entry.make != nullptr &&
         HasAny(entry.phases, kBroad | kNarrow);
}

bool IsComplete(const cdb_detector& row) {
  if (row.name == nullptr || row.phases == nullptr || row.functions == nullptr) return false;
  const Phases phases = PhasesOf(row);
  return HasAny(phases, kBroad | kNarrow) &&
         (!HasAny(phases, kBroad) || row.functions->find_pairs != nullptr) &&
         (!HasAny(phases, kNarrow) || row.functions->find_contacts != nullptr);
}

}  // namespace

void CheckAbi(std::uint32_t abi, std::uint32_t own, const std::string& path) {
  if (abi == own) return;
  const bool is_c = own == CDB_C_ABI;
  throw PluginError(
      fmt::format("'{}' was built for {}detector interface {}, but this cdb has {}; rebuild it "
                  "with this cdb's cdb/{}",
                  path, is_c ? "C " : "", abi, own, is_c ? "detector_c.h" : "detector.h"));
}

void CheckName(std::string_view name, const std::string& shown, const std::string& path) {
  if (!IsName(name))
    throw PluginError(
        fmt::format("'{}' calls a detector '{}', which is not a name in .cdb files; a name "
                    "consists of letters, digits and _, and does not begin with a digit",
                    path, shown));
}

void RefuseBuild(const std::string& build, const std::string& path) {
  throw PluginError(
      fmt::format("'{}' was built with {}, but this cdb with {}; build it with the same compiler",
                  path, build, DetectorBuild()));
}

LoadedDetector::LoadedDetector(const DetectorEntry& entry)
    : name(entry.name),
      phases(entry.phases),
      max_bodies(entry.max_bodies),
      make([function = entry.make](const Options& options) {
        return std::unique_ptr<Detector>(function(options));
      }) {}

LoadedDetector::LoadedDetector(const cdb_detector& row)
    : name(row.name),
      phases(PhasesOf(row)),
      max_bodies(row.max_bodies),
      make([&row](const Options& options) { return MakeCDetector(row, options); }) {}

std::vector<LoadedDetector> LoadPlugin(const std::string& path) {
  // The initializers of libraries linked with -ffast-math flush denormals to zero.
  const KeepsFloatingPoint keeps;
  // A name without a slash would be searched for in the system's folders.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw PluginError(fmt::format("cannot load '{}': {}", path, dlerror()));
  std::vector<LoadedDetector> loaded;
  const auto add = [&](const auto* rows, std::size_t count) {
    for (const auto& row : std::span(rows, rows == nullptr ? 0 : count)) {
      if (!IsComplete(row))
        throw PluginError(
            fmt::format("'{}' has a detector without name, line, phase or function", path));
      CheckName(row.name, row.name, path);
      if (FindDetector(loaded, row.name) != nullptr)
        throw PluginError(fmt::format("'{}' has two detectors called '{}'", path, row.name));
      loaded.emplace_back(row);
    }
  };
  if (const auto get = reinterpret_cast<const Plugin* (*)()>(dlsym(handle, "cdb_plugin"))) {
    const Plugin* plugin = get();
    if (plugin == nullptr) throw PluginError(fmt::format("'{}': cdb_plugin returns nothing", path));
    CheckAbi(plugin->abi, kDetectorAbi, path);
    if (plugin->build == nullptr || std::string_view(plugin->build) != DetectorBuild())
      RefuseBuild(plugin->build == nullptr ? "nothing named" : plugin->build, path);
    add(plugin->entries, plugin->count);
  } else if (const auto get_c =
                 reinterpret_cast<const cdb_c_plugin* (*)()>(dlsym(handle, "cdb_c_plugin_table"))) {
    const cdb_c_plugin* plugin = get_c();
    if (plugin == nullptr)
      throw PluginError(fmt::format("'{}': cdb_c_plugin_table returns nothing", path));
    CheckAbi(plugin->abi, CDB_C_ABI, path);
    add(plugin->detectors, plugin->count);
  } else {
    throw PluginError(
        fmt::format("'{}' has no detectors: it has no function cdb_plugin; write CDB_DETECTORS "
                    "once in it (cdb/detector.h), or CDB_C_DETECTORS (cdb/detector_c.h)",
                    path));
  }
  if (loaded.empty())
    throw PluginError(fmt::format("'{}' has no detectors: its array is empty", path));
  return loaded;
}

const LoadedDetector* FindDetector(const std::vector<LoadedDetector>& detectors,
                                   std::string_view name) {
  const auto found = std::ranges::find(detectors, name, &LoadedDetector::name);
  return found == detectors.end() ? nullptr : &*found;
}

namespace {

/// In place of a build, as CDB_MANIFEST_HEAD has it.
constexpr std::string_view kCBuild = "C";
constexpr std::size_t kMostBytes = 1 << 20;

/// Reads a structure at an offset of the file; nullopt if it is not entirely inside.
template <typename T>
std::optional<T> StructureAt(std::string_view bytes, std::uint64_t at) {
  if (at > bytes.size() || bytes.size() - at < sizeof(T)) return std::nullopt;
  T structure;
  std::memcpy(&structure, bytes.data() + at, sizeof structure);
  return structure;
}

std::optional<std::string_view> ContentsOf(std::string_view bytes, const Elf64_Shdr& section) {
  if (section.sh_type == SHT_NOBITS || section.sh_offset > bytes.size() ||
      bytes.size() - section.sh_offset < section.sh_size)
    return std::nullopt;
  return bytes.substr(section.sh_offset, section.sh_size);
}

std::optional<Elf64_Ehdr> ElfHeader(std::string_view bytes) {
  const auto header = StructureAt<Elf64_Ehdr>(bytes, 0);
  constexpr unsigned char kOrder =
      std::endian::native == std::endian::little ? ELFDATA2LSB : ELFDATA2MSB;
  if (!header || std::memcmp(header->e_ident, ELFMAG, SELFMAG) != 0 ||
      header->e_ident[EI_CLASS] != ELFCLASS64 || header->e_ident[EI_DATA] != kOrder ||
      header->e_type != ET_DYN || header->e_shentsize != sizeof(Elf64_Shdr))
    return std::nullopt;
  return header;
}

/// The contents of the section with that name, if there is one.
std::optional<std::string_view> FindSection(std::string_view bytes, const Elf64_Ehdr& header,
                                            std::string_view name) {
  const auto section_at = [&](std::uint64_t index) {
    return header.e_shoff > bytes.size()
               ? std::nullopt
               : StructureAt<Elf64_Shdr>(bytes, header.e_shoff + index * sizeof(Elf64_Shdr));
  };
  const auto of_names = section_at(header.e_shstrndx);
  const auto names = of_names ? ContentsOf(bytes, *of_names) : std::nullopt;
  if (!names) return std::nullopt;
  for (std::uint64_t i = 0; i < header.e_shnum; ++i) {
    const auto section = section_at(i);
    if (!section || section->sh_name >= names->size()) continue;
    const std::string_view rest = names->substr(section->sh_name);
    if (rest.starts_with(name) && rest.size() > name.size() && rest[name.size()] == '\0')
      return ContentsOf(bytes, *section);
  }
  return std::nullopt;
}

/// Removes and returns the text up to `end`, and removes `end`; all of it if there is no `end`.
std::string_view TakeUntil(std::string_view& text, char end) {
  const std::size_t at = std::min(text.find(end), text.size());
  const std::string_view taken = text.substr(0, at);
  text.remove_prefix(std::min(at + 1, text.size()));
  return taken;
}

template <typename T>
std::optional<T> WholeNumber(std::string_view text) {
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// A printable form for messages.
std::string Shown(std::string_view text) {
  constexpr std::size_t kMostShown = 80;
  std::string shown(text.substr(0, kMostShown));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

/// Removes the first line, `ABI <tab> BUILD`, and checks it.
void CheckInterface(std::string_view& text, const std::string& path) {
  std::string_view line = TakeUntil(text, '\n');
  const auto abi = WholeNumber<std::uint32_t>(TakeUntil(line, '\t'));
  if (!abi)
    throw PluginError(fmt::format(
        "'{}': its list of detectors cannot be read; write "
        "CDB_DETECTORS once in it (cdb/detector.h), or CDB_C_DETECTORS (cdb/detector_c.h)",
        path));
  if (line == kCBuild) return CheckAbi(*abi, CDB_C_ABI, path);
  CheckAbi(*abi, kDetectorAbi, path);
  if (line != DetectorBuild()) RefuseBuild(Shown(line), path);
}

schema::PluginDetector ReadLine(std::string_view line, const std::string& path) {
  schema::PluginDetector detector;
  detector.name = TakeUntil(line, '\t');
  detector.phases = TakeUntil(line, '\t');
  const auto most = WholeNumber<std::uint64_t>(line);
  CheckName(detector.name, Shown(detector.name), path);
  if (!most ||
      std::ranges::find(schema::kPluginPhases, detector.phases) == std::end(schema::kPluginPhases))
    throw PluginError(
        fmt::format("'{}' has a detector without phase or limit: '{}'", path, detector.name));
  detector.max_bodies = *most;
  return detector;
}

}  // namespace

std::vector<schema::PluginDetector> ReadManifest(std::string_view bytes, const std::string& path) {
  const auto header = ElfHeader(bytes);
  if (!header)
    throw PluginError(
        fmt::format("'{}' is not a shared library of this machine; build it from a source that has "
                    "CDB_DETECTORS (cdb/detector.h)",
                    path));
  const auto contents = FindSection(bytes, *header, kManifestSection);
  if (!contents || contents->size() > kMostBytes)
    throw PluginError(
        fmt::format("'{}' has no list of detectors that can be read without running it; write "
                    "CDB_DETECTORS once in it, and build it with this cdb's cdb/detector.h",
                    path));
  std::string_view text = contents->substr(0, contents->find('\0'));
  CheckInterface(text, path);
  std::vector<schema::PluginDetector> detectors;
  while (!text.empty()) {
    detectors.push_back(ReadLine(TakeUntil(text, '\n'), path));
    if (std::ranges::count(detectors, detectors.back().name, &schema::PluginDetector::name) > 1)
      throw PluginError(
          fmt::format("'{}' has two detectors called '{}'", path, detectors.back().name));
  }
  if (detectors.empty())
    throw PluginError(fmt::format("'{}' has no detectors: its array is empty", path));
  return detectors;
}

}  // namespace cdb::detectors
