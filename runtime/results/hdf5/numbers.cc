// Arrays of numbers in files that other programs wrote.

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <string>
#include <utility>

#include "runtime/results/hdf5/calls.h"
#include "runtime/results/hdf5/file.h"

namespace cdb::hdf5 {
namespace {

bool IsNumberType(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return (kind == H5T_INTEGER || kind == H5T_FLOAT) && H5Tget_size(type) <= 8;
}

/// Opens a member of a group; a link that is not a member itself may lead out of the file.
Id OpenMember(const Id& group, const std::string& name) {
  H5L_info_t info = {};
  if (H5Iget_type(group.get()) != H5I_GROUP ||
      H5Lexists(group.get(), name.c_str(), H5P_DEFAULT) <= 0)
    throw Error(fmt::format("there is no `{}`", name));
  Check(H5Lget_info(group.get(), name.c_str(), &info, H5P_DEFAULT), "find an array");
  if (info.type != H5L_TYPE_HARD) throw Error(fmt::format("`{}` is a link", name));
  return {H5Oopen(group.get(), name.c_str(), H5P_DEFAULT), H5Oclose, "open an array"};
}

/// The type in memory of a whole array, or of one member of its rows.
Id MemoryType(const Id& type, const std::string& member) {
  if (member.empty()) return {H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose, "set up a type"};
  const int index = H5Tget_member_index(type.get(), member.c_str());
  if (index < 0) throw Error(fmt::format("its rows have no `{}`", member));
  const Id of_member(H5Tget_member_type(type.get(), static_cast<unsigned>(index)), H5Tclose,
                     "read a type");
  if (!IsNumberType(of_member.get()))
    throw Error(fmt::format("`{}` of its rows is not a number", member));
  Id memory(H5Tcreate(H5T_COMPOUND, sizeof(double)), H5Tclose, "set up a type");
  Check(H5Tinsert(memory.get(), member.c_str(), 0, H5T_NATIVE_DOUBLE), "set up a type");
  return memory;
}

Numbers ReadFrom(const Id& dataset, const std::string& member, std::uint64_t file_bytes) {
  CheckStorage(dataset, file_bytes, Accept::kNumbers);
  const Id type(H5Dget_type(dataset.get()), H5Tclose, "read an array's type");
  const bool is_compound = H5Tget_class(type.get()) == H5T_COMPOUND;
  if (is_compound && member.empty())
    throw Error("its rows have several members: name one, as in /table/x");
  if (!is_compound && !member.empty()) throw Error(fmt::format("there is no `{}`", member));
  if (!is_compound && !IsNumberType(type.get())) throw Error("it is not an array of numbers");
  const Id memory_type = MemoryType(type, member);
  Numbers numbers;
  numbers.shape = ShapeOf({H5Dget_space(dataset.get()), H5Sclose, "read an array's shape"});
  numbers.is_from_matlab = H5Aexists(dataset.get(), "MATLAB_class") > 0;
  CheckReadable(dataset, Product(numbers.shape), H5Tget_size(type.get()), file_bytes);
  numbers.values.resize(Product(numbers.shape));
  if (!numbers.values.empty())
    Check(H5Dread(dataset.get(), memory_type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                  numbers.values.data()),
          "read an array");
  return numbers;
}

std::string MembersOf(const Id& type) {
  std::string names;
  for (int i = 0; i < H5Tget_nmembers(type.get()); ++i) {
    char* name = H5Tget_member_name(type.get(), static_cast<unsigned>(i));
    if (name == nullptr) continue;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
    H5free_memory(name);
  }
  return names;
}

/// `/robot/position (100 x 3)`.
std::string Described(const Id& dataset, const std::string& path) {
  const Id type(H5Dget_type(dataset.get()), H5Tclose, "read an array's type");
  const Shape shape = ShapeOf({H5Dget_space(dataset.get()), H5Sclose, "read an array's shape"});
  if (H5Tget_class(type.get()) == H5T_COMPOUND)
    return fmt::format("{} ({} rows of {})", path, Product(shape), MembersOf(type));
  return fmt::format("{} ({})", path, fmt::join(shape, " x "));
}

constexpr int kMostDepth = 6;

void AddArrays(const Id& group, const std::string& path, int depth, std::size_t most,
               std::vector<std::string>& arrays) {
  H5G_info_t info = {};
  Check(H5Gget_info(group.get(), &info), "list a group");
  for (hsize_t i = 0; i < info.nlinks && arrays.size() < most; ++i) {
    char name[256] = {};
    if (H5Lget_name_by_idx(group.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof name,
                           H5P_DEFAULT) >= static_cast<ssize_t>(sizeof name))
      continue;
    H5L_info_t link = {};
    if (H5Lget_info(group.get(), name, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
      continue;
    const Id member = OpenMember(group, name);
    const std::string inner = path + "/" + name;
    const H5I_type_t kind = H5Iget_type(member.get());
    if (kind == H5I_DATASET) arrays.push_back(Described(member, inner));
    if (kind == H5I_GROUP && depth < kMostDepth) AddArrays(member, inner, depth + 1, most, arrays);
  }
}

}  // namespace

Numbers Group::ReadNumbers(const std::string& path) const {
  Id at(H5Gopen2(id_.get(), ".", H5P_DEFAULT), H5Gclose, "open a group");
  for (std::size_t begin = path.starts_with('/') ? 1 : 0;;) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string name = path.substr(begin, end - begin);
    if (H5Iget_type(at.get()) == H5I_DATASET) {
      if (end < path.size()) throw Error(fmt::format("there is no `{}`", path));
      return ReadFrom(at, name, foreign_bytes_);
    }
    if (name.empty()) throw Error("it is not the path of an array");
    at = OpenMember(at, name);
    if (end < path.size()) {
      begin = end + 1;
      continue;
    }
    if (H5Iget_type(at.get()) != H5I_DATASET) throw Error("it is a group, not an array");
    return ReadFrom(at, {}, foreign_bytes_);
  }
}

std::string Group::TextOfMember(const std::string& member, const char* attribute) const {
  struct Member : Object {
    explicit Member(Id id) : Object(std::move(id)) {}
  };
  return Member(OpenMember(id_, member)).Text(attribute);
}

std::vector<std::string> Group::ListArrays(std::size_t most) const {
  std::vector<std::string> arrays;
  AddArrays(id_, {}, 0, most, arrays);
  return arrays;
}

}  // namespace cdb::hdf5
