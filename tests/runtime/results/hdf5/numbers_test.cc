// Arrays of numbers in HDF5 files of other programs: every type and storage reads back, and damage
// never crashes the reader.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "runtime/results/files/errors.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"
#include "tests/support/files.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Random = std::mt19937;

std::uint64_t Below(std::uint64_t count, Random& random) { return random() % count; }

/// numpy's float16.
hid_t HalfFloat() {
  const hid_t type = H5Tcopy(H5T_IEEE_F32BE);
  H5Tset_fields(type, 15, 10, 5, 0, 10);
  H5Tset_size(type, 2);
  H5Tset_ebias(type, 15);
  return type;
}

/// A copy of a type of numbers, integers and floats in both byte orders.
hid_t NumberType(Random& random) {
  const hid_t types[] = {
      H5T_STD_I8LE,  H5T_STD_I16LE,  H5T_STD_I16BE,  H5T_STD_I32LE,  H5T_STD_I32BE, H5T_STD_I64LE,
      H5T_STD_I64BE, H5T_STD_U8LE,   H5T_STD_U16BE,  H5T_STD_U32LE,  H5T_STD_U32BE, H5T_STD_U64LE,
      H5T_STD_U64BE, H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE, H5T_IEEE_F64BE};
  const std::uint64_t i = Below(std::size(types) + 1, random);
  return i < std::size(types) ? H5Tcopy(types[i]) : HalfFloat();
}

/// What the reader should return; each type can hold the values.
struct Written {
  hdf5::Shape shape;
  std::vector<double> values;
};

/// Chunked and compressed, or not.
hid_t Storage(const hdf5::Shape& shape, Random& random) {
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  if (shape.empty() || Below(2, random) == 0) return creation;
  std::vector<hsize_t> chunk(shape.size());
  for (std::size_t i = 0; i < chunk.size(); ++i) chunk[i] = 1 + Below(shape[i], random);
  H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
  if (Below(2, random) == 0) H5Pset_shuffle(creation);
  if (Below(2, random) == 0) H5Pset_deflate(creation, 4);
  if (Below(3, random) == 0) H5Pset_fletcher32(creation);
  return creation;
}

/// Adds an array of a number type, or with `member` of rows that have it among others.
Written Add(hid_t place, const char* name, const char* member, Random& random) {
  Written written;
  for (std::uint64_t i = Below(4, random); i > 0; --i)
    written.shape.push_back(1 + Below(5, random));
  for (std::uint64_t i = hdf5::Product(written.shape); i > 0; --i)
    written.values.push_back(static_cast<double>(Below(100, random)));
  const std::vector<hsize_t> shape(written.shape.begin(), written.shape.end());
  const hid_t space = shape.empty()
                          ? H5Screate(H5S_SCALAR)
                          : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
  hid_t type = NumberType(random), memory = H5Tcopy(H5T_NATIVE_DOUBLE);
  if (member != nullptr) {
    const hid_t text = H5Tcopy(H5T_C_S1), number = type, of_member = memory;
    H5Tset_size(text, 3);
    type = H5Tcreate(H5T_COMPOUND, 3 + H5Tget_size(number));
    H5Tinsert(type, "name", 0, text);
    H5Tinsert(type, member, 3, number);
    memory = H5Tcreate(H5T_COMPOUND, sizeof(double));
    H5Tinsert(memory, member, 0, of_member);
    for (const hid_t part : {text, number, of_member}) H5Tclose(part);
  }
  const hid_t creation = Storage(written.shape, random);
  const hid_t set = H5Dcreate2(place, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  EXPECT_GE(set, 0);
  EXPECT_GE(H5Dwrite(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, written.values.data()), 0);
  H5Dclose(set);
  H5Pclose(creation);
  H5Sclose(space);
  H5Tclose(type);
  H5Tclose(memory);
  return written;
}

/// Adds an array that is not of numbers.
void AddOther(hid_t place, const char* name, hid_t type) {
  const hid_t space = H5Screate(H5S_SCALAR);
  H5Dclose(H5Dcreate2(place, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(space);
  H5Tclose(type);
}

class Hdf5Numbers : public testing::Test {
 protected:
  /// The arrays /plain, /group/inner and the member x of /rows, and three others.
  std::vector<Written> WriteFileOf(Random& random) {
    const hid_t file = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t group = H5Gcreate2(file, "group", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const std::vector<Written> all = {Add(file, "plain", nullptr, random),
                                      Add(group, "inner", nullptr, random),
                                      Add(file, "rows", "x", random)};
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Tset_size(text, H5T_VARIABLE);
    AddOther(file, "text", text);
    AddOther(file, "choice", H5Tenum_create(H5T_NATIVE_INT8));
    const hsize_t three = 3;
    AddOther(file, "triple", H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &three));
    H5Gclose(group);
    H5Fclose(file);
    return all;
  }

  const TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "numbers.h5";
};

constexpr const char* kArrays[] = {"/plain", "/group/inner", "/rows/x"};

TEST_F(Hdf5Numbers, ReadBackInEveryTypeAndStorage) {
  Random random(20260101);
  for (int round = 0; round < Cases(200); ++round) {
    SCOPED_TRACE(round);
    const std::vector<Written> written = WriteFileOf(random);
    const hdf5::File file = hdf5::File::Open(path_);
    for (std::size_t i = 0; i < written.size(); ++i) {
      const hdf5::Numbers numbers = file.ReadNumbers(kArrays[i]);
      EXPECT_EQ(numbers.shape, written[i].shape) << kArrays[i];
      EXPECT_EQ(numbers.values, written[i].values) << kArrays[i];
    }
    for (const char* other : {"/text", "/choice", "/triple", "/rows", "/rows/name", "/rows/y",
                              "/group", "/none", "/plain/x"})
      EXPECT_THROW(file.ReadNumbers(other), hdf5::Error) << other;
  }
}

TEST_F(Hdf5Numbers, SurviveDamage) {
  Random random(20260102);
  for (int round = 0; round < Cases(40); ++round) {
    WriteFileOf(random);
    const std::string whole = ReadFile(path_);
    for (int change = 0; change < 25; ++change) {
      std::string bytes = whole;
      // The beginning of the file has its structure.
      for (std::uint64_t i = 1 + Below(4, random); i > 0; --i)
        bytes[Below(
            Below(2, random) == 0 ? std::min<std::size_t>(bytes.size(), 2048) : bytes.size(),
            random)] = static_cast<char>(random());
      if (Below(8, random) == 0) bytes.resize(Below(bytes.size(), random));
      WriteFile(path_, bytes);
      for (const char* array : kArrays) try {
          for (const auto& column : results::ReadColumns(path_, {array}))
            EXPECT_LT(column.size(), 1'000'000u);
        } catch (const files::StoreError& error) {
          EXPECT_NE(std::string(error.what()).find(path_.string()), std::string::npos);
        }
      results::ArraysIn(path_);
    }
  }
}

}  // namespace
}  // namespace cdb::tests
