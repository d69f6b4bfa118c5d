#include "runtime/results/hdf5/calls.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace cdb::hdf5 {
namespace {

/// The first failure on HDF5's error stack, or the system's message if the system failed.
std::string Cause() {
  std::string cause;
  const auto visit = [](unsigned depth, const H5E_error2_t* error, void* out) -> herr_t {
    if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, visit, &cause);
  H5Eclear2(H5E_DEFAULT);
  constexpr std::string_view kSystem = "error message = '";
  if (const std::size_t begin = cause.find(kSystem); begin != std::string::npos) {
    cause.erase(0, begin + kSystem.size());
    cause.erase(std::min(cause.find('\''), cause.size()));
  }
  return cause.empty() ? "HDF5 does not say why" : cause;
}

}  // namespace

void Fail(std::string_view doing) { throw Error(fmt::format("cannot {}: {}", doing, Cause())); }

void Check(herr_t result, std::string_view doing) {
  if (result < 0) Fail(doing);
}

Id NewProperties(hid_t kind) { return {H5Pcreate(kind), H5Pclose, "set up HDF5"}; }

Id NewSpace(const Shape& shape) {
  const int rank = static_cast<int>(shape.size());
  return {rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, Dims(shape), nullptr),
          H5Sclose, "describe an array"};
}

Id NewText(std::size_t bytes) {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose, "describe text");
  Check(H5Tset_size(type.get(), bytes), "describe text");
  Check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "describe text");
  if (bytes != H5T_VARIABLE) Check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "describe text");
  return type;
}

Id FileType(Type type) {
  switch (type) {
    case Type::kInt8:
      return {H5Tcopy(H5T_STD_I8LE), H5Tclose, "describe numbers"};
    case Type::kInt32:
      return {H5Tcopy(H5T_STD_I32LE), H5Tclose, "describe numbers"};
    case Type::kFloat32:
      return {H5Tcopy(H5T_IEEE_F32LE), H5Tclose, "describe numbers"};
    case Type::kFloat64:
      return {H5Tcopy(H5T_IEEE_F64LE), H5Tclose, "describe numbers"};
    case Type::kText:
      break;
  }
  return NewText(H5T_VARIABLE);
}

Shape ShapeOf(const Id& space) {
  const int rank = Checked(H5Sget_simple_extent_ndims(space.get()), "read an array's shape");
  Shape shape(static_cast<std::size_t>(rank));
  if (rank > 0)
    Check(H5Sget_simple_extent_dims(space.get(), reinterpret_cast<hsize_t*>(shape.data()), nullptr),
          "read an array's shape");
  return shape;
}

void WriteAttribute(const Id& object, const char* name, const Id& type, hid_t memory_type,
                    const Id& space, const void* data) {
  const std::string doing = fmt::format("write the attribute {}", name);
  const Id attribute(
      H5Acreate2(object.get(), name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      doing);
  Check(H5Awrite(attribute.get(), memory_type, data), doing);
}

}  // namespace cdb::hdf5
