// Grids of bytes: raw, binvox and NumPy.
#include "library/terrain/voxel_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "library/terrain/height_formats.h"

namespace cdb::terrain {
namespace {

using Counts = std::array<std::uint64_t, 3>;

std::string TextOf(const Counts& counts) {
  return fmt::format("{} x {} x {}", counts[0], counts[1], counts[2]);
}

/// Cells of the values of a file, one after the other.
class ValueCells {
 public:
  ValueCells(VoxelGrid& grid, std::uint64_t threshold) : grid_(grid), threshold_(threshold) {}

  void Put(std::size_t cell, unsigned char value) {
    largest_ = std::max(largest_, value);
    grid_.solid[cell] = value >= threshold_;
    is_solid_ = is_solid_ || value >= threshold_;
  }
  void RefuseIfEmpty(std::string_view name) const {
    if (is_solid_) return;
    RefuseFile(
        name,
        fmt::format("no cell is solid: the largest value is {}, the threshold {}", largest_,
                    threshold_),
        largest_ > 0 ? fmt::format("for example `threshold: {}`", largest_) : "name another file");
  }

 private:
  VoxelGrid& grid_;
  const std::uint64_t threshold_;
  unsigned char largest_ = 0;
  bool is_solid_ = false;
};

/// The words of a line of a header.
std::vector<std::string_view> WordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (line.empty()) return words;
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

std::optional<std::uint64_t> CountIn(std::string_view word) {
  std::uint64_t count = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(count)
                                                                  : std::nullopt;
}

}  // namespace

double GivenCell(std::string_view name, const VoxelOptions& options) {
  if (!options.cell)
    RefuseFile(name, "it does not say how large a cell is", "give it in m, such as `cell: 0.1`");
  return *options.cell;
}

VoxelGrid EmptyGrid(const Counts& counts, std::string_view name) {
  if (std::ranges::find(counts, 0u) != counts.end())
    RefuseFile(name, fmt::format("it has {} cells", TextOf(counts)), "name another file");
  if (counts[0] > kMaxCells || counts[1] > kMaxCells / counts[0] ||
      counts[2] > kMaxCells / counts[0] / counts[1])
    RefuseFile(name, fmt::format("it has {} cells; the limit is {}", TextOf(counts), kMaxCells),
               "take a part of it, or larger cells");
  VoxelGrid grid;
  for (std::size_t i = 0; i < 3; ++i) grid.counts[i] = static_cast<std::int64_t>(counts[i]);
  grid.solid.resize(counts[0] * counts[1] * counts[2]);
  return grid;
}

VoxelGrid ReadRaw(std::string_view bytes, std::string_view name, const VoxelOptions& options) {
  constexpr std::string_view kWords[] = {"columns", "rows", "layers"};
  Counts counts;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!options.counts[i])
      RefuseFile(name, fmt::format("raw bytes do not say how many {} they have", kWords[i]),
                 "for example `columns: 64, rows: 64, layers: 32`: along x, y and z of the file");
    counts[i] = *options.counts[i];
  }
  const double cell = GivenCell(name, options);
  VoxelGrid grid = EmptyGrid(counts, name);
  if (bytes.size() != grid.solid.size())
    RefuseFile(name,
               fmt::format("it has {} bytes, but {} cells are {}", bytes.size(), TextOf(counts),
                           grid.solid.size()),
               "correct columns, rows and layers; a cell is one byte");
  grid.cell = cell;
  ValueCells cells(grid, options.threshold);
  for (std::size_t i = 0; i < bytes.size(); ++i) cells.Put(i, static_cast<unsigned char>(bytes[i]));
  cells.RefuseIfEmpty(name);
  return grid;
}

namespace {

constexpr const char* kExportAgain = "write the file again";

struct BinvoxHeader {
  Counts counts = {};  ///< along x, z and y
  Eigen::Vector3d translate = Eigen::Vector3d::Zero();
  double scale = 1;
  std::size_t size = 0;  ///< bytes
};

BinvoxHeader HeaderOfBinvox(std::string_view bytes, std::string_view name) {
  constexpr std::size_t kMostLines = 100;
  BinvoxHeader header;
  bool has_counts = false;
  for (std::size_t line = 1; line <= kMostLines; ++line) {
    const std::string_view rest = bytes.substr(header.size);
    const std::size_t end = rest.find('\n');
    if (end == rest.npos) break;
    header.size += end + 1;
    const std::vector<std::string_view> words = WordsOf(rest.substr(0, end));
    if (line == 1 && (words.size() != 2 || words[0] != "#binvox" || words[1] != "1"))
      RefuseFile(name, "it does not begin with `#binvox 1`", kExportAgain);
    if (line == 1 || words.empty()) continue;
    const auto number = [&](std::size_t i) {
      const std::optional<double> found = HeightIn(words[i]);
      if (!found || !std::isfinite(*found))
        RefuseLine(name, line, fmt::format("`{}` is not a number", words[i]), kExportAgain);
      return *found;
    };
    if (words[0] == "data" && words.size() == 1) {
      if (!has_counts) RefuseLine(name, line, "the header has no `dim`", kExportAgain);
      return header;
    }
    if (words[0] == "dim" && words.size() == 4) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::optional<std::uint64_t> count = CountIn(words[i + 1]);
        if (!count)
          RefuseLine(name, line, fmt::format("`{}` is not a number of cells", words[i + 1]),
                     kExportAgain);
        header.counts[i] = *count;
      }
      has_counts = true;
    } else if (words[0] == "translate" && words.size() == 4) {
      header.translate = {number(1), number(2), number(3)};
    } else if (words[0] == "scale" && words.size() == 2) {
      header.scale = number(1);
      if (!(header.scale > 0))
        RefuseLine(name, line, "the scale must be more than 0", kExportAgain);
    } else {
      RefuseLine(name, line, "it is not dim, translate, scale or data with their numbers",
                 kExportAgain);
    }
  }
  RefuseFile(name, "the header has no `data`", kExportAgain);
}

}  // namespace

// The unit cube, scaled and moved, has the longest side of the grid. Runs go along y, then z, then
// x.
VoxelGrid ReadBinvox(std::string_view bytes, std::string_view name, const VoxelOptions& options) {
  const BinvoxHeader header = HeaderOfBinvox(bytes, name);
  const auto [along_x, along_z, along_y] = header.counts;
  VoxelGrid grid = EmptyGrid({along_x, along_y, along_z}, name);
  const double own = header.scale / static_cast<double>(std::ranges::max(header.counts));
  grid.cell = options.cell.value_or(own);
  grid.lower = grid.cell / own * header.translate;
  ValueCells cells(grid, options.threshold);
  std::size_t filled = 0;
  const std::size_t count = grid.solid.size();
  for (std::size_t at = header.size; at + 1 < bytes.size(); at += 2) {
    const auto value = static_cast<unsigned char>(bytes[at]),
               length = static_cast<unsigned char>(bytes[at + 1]);
    if (length == 0) RefuseFile(name, fmt::format("byte {}: a run of no cells", at), kExportAgain);
    if (length > count - filled)
      RefuseFile(name, fmt::format("byte {}: its runs have more than {} cells", at, count),
                 "the file is damaged, or `dim` is wrong");
    for (unsigned i = 0; i < length; ++i, ++filled) {
      const std::size_t y = filled % along_y, z = filled / along_y % along_z,
                        x = filled / along_y / along_z;
      cells.Put((z * along_y + y) * along_x + x, value);
    }
  }
  if (filled == count && (bytes.size() - header.size) % 2 != 0)
    RefuseFile(name, "there is a byte after its last run", kExportAgain);
  if (filled < count)
    RefuseFile(name, fmt::format("its runs have {} cells, its header {}", filled, count),
               "the file is truncated or damaged");
  cells.RefuseIfEmpty(name);
  return grid;
}

namespace {

/// What follows a key of the header's dictionary.
std::string_view After(std::string_view header, std::string_view key, std::string_view name) {
  const std::size_t at = header.find(fmt::format("'{}':", key));
  if (at == header.npos)
    RefuseFile(name, fmt::format("its header has no '{}'", key), "write it by numpy.save");
  std::string_view rest = header.substr(at + key.size() + 3);
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  return rest;
}

/// The text between two characters, the first of which `text` begins with.
std::string_view Between(std::string_view text, char open, char close) {
  const std::size_t end = text.starts_with(open) ? text.find(close, 1) : text.npos;
  return end == text.npos ? std::string_view() : text.substr(1, end - 1);
}

}  // namespace

VoxelGrid ReadNpy(std::string_view bytes, std::string_view name, const VoxelOptions& options) {
  constexpr std::string_view kMagic = "\x93NUMPY";
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
  if (!bytes.starts_with(kMagic) || bytes.size() < 12)
    RefuseFile(name, "it is not a NumPy array", "write it by numpy.save");
  const unsigned version = byte(6);
  if (version < 1 || version > 3)
    RefuseFile(name, fmt::format("version {} of the format is not known", version),
               "write it by numpy.save");
  const std::size_t start = version == 1 ? 10 : 12;
  std::size_t length = 0;
  for (std::size_t i = start; i-- > 8;) length = length << 8 | byte(i);
  if (length > bytes.size() - start)
    RefuseFile(name, "the file ends in its header", "the file is truncated");
  const std::string_view header = bytes.substr(start, length), data = bytes.substr(start + length);
  const std::string_view type = Between(After(header, "descr", name), '\'', '\'');
  if (type != "|u1" && type != "|b1")
    RefuseFile(name,
               fmt::format("its values are of type '{}', not uint8 or bool",
                           type.empty() ? "of several fields" : type),
               "write `(array > 0.5).astype(\"uint8\")` by numpy.save");
  const bool is_fortran = After(header, "fortran_order", name).starts_with("True");
  const std::string_view shape = Between(After(header, "shape", name), '(', ')');
  std::string spaced(shape);
  std::ranges::replace(spaced, ',', ' ');
  const std::vector<std::string_view> words = WordsOf(spaced);
  Counts counts = {};
  bool is_shape = words.size() == 3;
  for (std::size_t i = 0; is_shape && i < 3; ++i) {
    const std::optional<std::uint64_t> count = CountIn(words[i]);
    is_shape = count.has_value();
    counts[i] = count.value_or(0);
  }
  if (!is_shape)
    RefuseFile(name, fmt::format("its shape is ({}), which is not of three dimensions", shape),
               "write an array of cells along x, y and z");
  const double cell = GivenCell(name, options);
  VoxelGrid grid = EmptyGrid(counts, name);
  if (data.size() != grid.solid.size())
    RefuseFile(name,
               fmt::format("it has {} bytes after its header, but {} cells are {}", data.size(),
                           TextOf(counts), grid.solid.size()),
               "the file is truncated or damaged");
  grid.cell = cell;
  ValueCells cells(grid, options.threshold);
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::size_t z = i % counts[2], y = i / counts[2] % counts[1],
                      x = i / counts[2] / counts[1];
    cells.Put(is_fortran ? i : (z * counts[1] + y) * counts[0] + x,
              static_cast<unsigned char>(data[i]));
  }
  cells.RefuseIfEmpty(name);
  return grid;
}

}  // namespace cdb::terrain
