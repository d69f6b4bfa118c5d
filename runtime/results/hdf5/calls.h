// Calls of HDF5's C API that throw, and types and spaces that several of them take. Included only
// by the sources of this folder.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "runtime/results/hdf5/object.h"

namespace cdb::hdf5 {

static_assert(sizeof(hid_t) == sizeof(std::int64_t) && sizeof(hsize_t) == sizeof(std::uint64_t));

/// Throws Error with the cause reported by HDF5.
[[noreturn]] void Fail(std::string_view doing);
void Check(herr_t result, std::string_view doing);
template <typename Number>
Number Checked(Number result, std::string_view doing) {
  if (result < 0) Fail(doing);
  return result;
}

inline const hsize_t* Dims(const Shape& shape) {
  return reinterpret_cast<const hsize_t*>(shape.data());
}

/// Objects and their attributes are listed in the order of creation.
inline constexpr unsigned kCreationOrder = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
Id NewProperties(hid_t kind);

Id NewSpace(const Shape& shape);
Shape ShapeOf(const Id& space);
/// A text type of `bytes`, or H5T_VARIABLE.
Id NewText(std::size_t bytes);
/// A new HDF5 type for each use, because text needs a copy.
Id FileType(Type type);

void WriteAttribute(const Id& object, const char* name, const Id& type, hid_t memory_type,
                    const Id& space, const void* data);

}  // namespace cdb::hdf5
