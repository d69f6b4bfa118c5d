// The rules that keep every reader working, checked through HDF5's own interface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

using testing::ElementsAre;

constexpr unsigned kOrder = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;

/// The attributes that the dimension scale specification itself writes.
const std::set<std::string> kScaleAttributes = {"CLASS", "NAME", "DIMENSION_LIST",
                                                "REFERENCE_LIST"};

std::vector<std::string> LinksInOrder(hid_t group) {
  std::vector<std::string> names;
  H5Literate(
      group, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t* info, void* out) -> herr_t {
        EXPECT_EQ(info->type, H5L_TYPE_HARD) << name;
        static_cast<std::vector<std::string>*>(out)->push_back(name);
        return 0;
      },
      &names);
  return names;
}

std::vector<std::string> Attributes(hid_t object) {
  std::vector<std::string> names;
  H5Aiterate2(
      object, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->push_back(name);
        return 0;
      },
      &names);
  return names;
}

std::string TextOf(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return "(none)";
  const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  const hid_t type = H5Aget_type(attribute);
  std::string text(H5Tget_size(type), '\0');
  H5Aread(attribute, type, text.data());
  H5Tclose(type);
  H5Aclose(attribute);
  return text;
}

std::vector<hsize_t> ShapeOf(hid_t dataset) {
  const hid_t space = H5Dget_space(dataset);
  std::vector<hsize_t> shape(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  H5Sclose(space);
  return shape;
}

void ExpectAttributes(hid_t object) {
  for (const std::string& name : Attributes(object)) {
    if (kScaleAttributes.contains(name)) continue;
    SCOPED_TRACE(name);
    EXPECT_NE(name, "_Netcdf4Dimid");
    const hid_t attribute = H5Aopen(object, name.c_str(), H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    const hid_t space = H5Aget_space(attribute);
    if (H5Tget_class(type) == H5T_STRING) {
      EXPECT_EQ(H5Tis_variable_str(type), 0);
      EXPECT_EQ(H5Tget_strpad(type), H5T_STR_NULLPAD);
      EXPECT_EQ(H5Tget_cset(type), H5T_CSET_UTF8);
      EXPECT_EQ(H5Sget_simple_extent_type(space), H5S_SCALAR);
      EXPECT_EQ(std::string(TextOf(object, name.c_str())).find('\0'), std::string::npos);
      if (name == "units") {
        EXPECT_THAT(TextOf(object, "units"),
                    testing::AnyOf("1", "ns", "s", "m", "m/s", "kg m/s", "rad", "J", "bytes",
                                   "seconds since 1970-01-01 00:00:00"));
      }
    } else {
      EXPECT_THAT(H5Tget_class(type), testing::AnyOf(H5T_INTEGER, H5T_FLOAT));
    }
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
  }
}

/// The only scale attached to a dimension.
std::string ScaleOf(hid_t dataset, unsigned dimension) {
  std::vector<std::string> names;
  struct Visit {
    std::vector<std::string>* names;
    hsize_t extent;
    bool attached;
  } visit = {&names, 0, false};
  H5DSiterate_scales(
      dataset, dimension, nullptr,
      [](hid_t data, unsigned at, hid_t scale, void* out) -> herr_t {
        char name[256] = {};
        H5Iget_name(scale, name, sizeof(name));
        auto* result = static_cast<Visit*>(out);
        result->names->push_back(name + 1);
        result->extent = ShapeOf(scale).at(0);
        result->attached = H5DSis_attached(data, scale, at) > 0 && H5DSis_scale(scale) > 0;
        return 0;
      },
      &visit);
  EXPECT_EQ(names.size(), 1u) << "dimension " << dimension;
  EXPECT_EQ(visit.extent, ShapeOf(dataset).at(dimension));
  EXPECT_TRUE(visit.attached) << "the scale does not name the array";
  return names.empty() ? "" : names[0];
}

plan::Axis Sampled(plan::Axis axis) {
  axis.sampled = {{"mu", 0, 1, false, {0.3}}};
  return axis;
}

/// The results file of a plan, with errors or without. It has the largest chunks, and therefore
/// takes a while to write: tests share it.
class WrittenPlan {
 public:
  explicit WrittenPlan(bool accuracy)
      : plan_(MakePlan({Sampled(NumberAxis("quantity", {1})), NumberAxis("size", {0.5, 2}, "m"),
                        TextAxis("type", {"sphere", "any(sphere 3, cone)"})},
                       2,
                       {.cycles = 35000,
                        .objects = 1,
                        .record = {"timing", "stability", "contacts", "poses", "boxes"},
                        .metrics = accuracy ? schema::WordList{"pairs", "position"}
                                            : schema::WordList{"none"}})) {
    for (const plan::Run& run : plan_.runs) {
      const FakeResult fake(run);
      WriteRun(plan_, run, fake.result, {{"cpu", "cpu " + run.id}, {"compiler", "gcc"}},
               folder_.path());
    }
    for (const plan::Run& run : plan_.references) {
      const std::vector<double> samples(protocol::SampleShapeOf(run.scene)->Count(), 0.5);
      results::RunResult result;
      result.status = results::Status::kDone;
      WriteReference(plan_, run, result, samples, {}, folder_.path());
    }
    journal::Merge(plan_, {}, folder_.path(), merged());
  }
  std::filesystem::path merged() const { return folder_ / "out.h5"; }

 private:
  const TemporaryFolder folder_;
  const plan::Plan plan_;
};

/// True if the values are a few named ones, stored in a byte.
bool IsFlag(const std::string& name) {
  return name.ends_with("status") || name == "verdict" || name == "run/noise";
}

class Conventions : public testing::TestWithParam<bool> {
 protected:
  static void SetUpTestSuite() {
    for (const bool accuracy : {false, true})
      written_[accuracy] = std::make_unique<WrittenPlan>(accuracy);
  }
  static void TearDownTestSuite() { written_ = {}; }

  Conventions() {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    if (GetParam()) groups_.insert(groups_.end(), {"/accuracy", "/accuracy/reference"});
    file_ = H5Fopen(written().merged().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    for (const std::string& group : groups_) {
      const hid_t id = H5Gopen2(file_, group.c_str(), H5P_DEFAULT);
      for (const std::string& name : LinksInOrder(id)) {
        const hid_t object = H5Oopen(id, name.c_str(), H5P_DEFAULT);
        if (H5Iget_type(object) == H5I_DATASET)
          datasets_.push_back(group == "/" ? name : group.substr(1) + "/" + name);
        H5Oclose(object);
      }
      H5Gclose(id);
    }
  }
  ~Conventions() override { H5Fclose(file_); }

  static const WrittenPlan& written() { return *written_[GetParam()]; }

  void ForEachDataset(const std::function<void(const std::string&, hid_t)>& visit) {
    for (const std::string& name : datasets_) {
      SCOPED_TRACE(name);
      const hid_t dataset = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
      ASSERT_GE(dataset, 0);
      visit(name, dataset);
      H5Dclose(dataset);
    }
  }

  static inline std::array<std::unique_ptr<WrittenPlan>, 2> written_;
  hid_t file_ = -1;
  std::vector<std::string> groups_ = {"/", "/run", "/provenance", "/sampled"};
  std::vector<std::string> datasets_;
};

TEST_P(Conventions, CreationOrderIsTrackedAndIndexedEverywhere) {
  unsigned flags = 0;
  for (const std::string& name : groups_) {
    const hid_t group = H5Gopen2(file_, name.c_str(), H5P_DEFAULT);
    const hid_t creation = H5Gget_create_plist(group);
    H5Pget_link_creation_order(creation, &flags);
    EXPECT_EQ(flags, kOrder) << name;
    H5Pget_attr_creation_order(creation, &flags);
    EXPECT_EQ(flags, kOrder) << name;
    H5Pclose(creation);
    H5Gclose(group);
  }
  ForEachDataset([&](const std::string&, hid_t dataset) {
    const hid_t creation = H5Dget_create_plist(dataset);
    H5Pget_attr_creation_order(creation, &flags);
    EXPECT_EQ(flags, kOrder);
    H5Pclose(creation);
  });
}

TEST_P(Conventions, AxesComeFirstAndInOrder) {
  std::vector<std::string> expected = {
      "quantity", "size",     "type",  "rep",    "phase",       "cycle",        "body",
      "pose",     "box_body", "bound", "filter", "contact_row", "contact_side", "xyz"};
  expected.emplace_back("duration");
  const std::vector<std::string> first(
      datasets_.begin(), datasets_.begin() + static_cast<std::ptrdiff_t>(expected.size()));
  EXPECT_EQ(first, expected);
}

TEST_P(Conventions, EveryAxisOfEveryArrayHasItsScale) {
  std::size_t arrays = 0;
  ForEachDataset([&](const std::string& path, hid_t dataset) {
    const std::string group = path.substr(0, path.rfind('/') + 1), name = path.substr(group.size());
    const std::vector<hsize_t> shape = ShapeOf(dataset);
    if (H5DSis_scale(dataset) > 0) {
      char scale[256] = {};
      H5DSget_scale_name(dataset, scale, sizeof(scale));
      if (name == "contact_row") {
        EXPECT_THAT(scale, testing::StartsWith("This is a netCDF dimension but not a netCDF var"));
      } else {
        EXPECT_EQ(name, scale);
      }
      EXPECT_EQ(shape.size(), 1u);
      return;
    }
    ++arrays;
    std::vector<std::string> expected = {"quantity", "size", "type", "rep"};
    if (group == "provenance/") expected = {"run"};
    if (group == "sampled/") expected = {"quantity"};
    if (name.ends_with("_text")) expected = {};
    if (name.ends_with("_series")) expected.emplace_back("sample");
    if (group == "accuracy/reference/") expected = {"reference"};
    if (name == "states") expected.insert(expected.end(), {"sample", "body", "state"});
    if (name == "observables") expected.insert(expected.end(), {"sample", "observable"});
    if (name == "contact_body") expected = {"contact_row", "contact_side"};
    if (name == "contact_point" || name == "contact_normal") expected = {"contact_row", "xyz"};
    if (name == "contact_distance") expected = {"contact_row"};
    if (name == "duration") expected.push_back("phase");
    if (const protocol::Series* series = protocol::FindSeries(path)) {
      if (series->HasCycles()) expected.emplace_back("cycle");
      if (series->shape == protocol::SeriesShape::kBox)
        expected.insert(expected.end(), {"box_body", "bound"});
      if (series->shape == protocol::SeriesShape::kFilter)
        expected.insert(expected.end(), {"box_body", "filter"});
      if (series->shape == protocol::SeriesShape::kPose)
        expected.insert(expected.end(), {"body", "pose"});
    }
    // A reader of one group finds the coordinates within it.
    for (std::string& scale : expected) scale.insert(0, group);
    std::vector<std::string> scales;
    for (unsigned d = 0; d < shape.size(); ++d) scales.push_back(ScaleOf(dataset, d));
    EXPECT_EQ(scales, expected);
  });
  EXPECT_GE(arrays, 30u);
}

TEST_P(Conventions, OnlyTypesThatEveryReaderHas) {
  ForEachDataset([&](const std::string& name, hid_t dataset) {
    const hid_t type = H5Dget_type(dataset);
    const std::size_t bytes = H5Tget_size(type);
    switch (H5Tget_class(type)) {
      case H5T_STRING:
        EXPECT_GT(H5Tis_variable_str(type), 0);
        EXPECT_EQ(H5Tget_cset(type), H5T_CSET_UTF8);
        break;
      case H5T_INTEGER:
        EXPECT_EQ(bytes, IsFlag(name) ? 1u : 4u);
        EXPECT_EQ(H5Tget_sign(type), H5T_SGN_2);
        break;
      case H5T_FLOAT:
        EXPECT_EQ(bytes, 8u);
        break;
      default:
        ADD_FAILURE() << "another class of type";
    }
    H5Tclose(type);
    ExpectAttributes(dataset);
  });
  const hid_t root = H5Gopen2(file_, "/", H5P_DEFAULT);
  ExpectAttributes(root);
  EXPECT_THAT(Attributes(root),
              testing::IsSupersetOf({"Conventions", "title", "source", "comment", "schema",
                                     "schema_version", "history", "date_created", "plan_sha256"}));
  EXPECT_EQ(TextOf(root, "Conventions"), "CF-1.8");
  EXPECT_THAT(TextOf(root, "comment"), testing::HasSubstr("whole nanoseconds as float64"));
  H5Gclose(root);
}

TEST_P(Conventions, EveryMergedVariableHasALongNameAndEveryNumberAUnit) {
  ForEachDataset([&](const std::string& name, hid_t dataset) {
    if (name == "contact_row") return;  // a dimension without a variable
    EXPECT_NE(TextOf(dataset, "long_name"), "(none)");
    const hid_t type = H5Dget_type(dataset);
    const bool is_text = H5Tget_class(type) == H5T_STRING;
    H5Tclose(type);
    if (is_text || H5Aexists(dataset, "flag_meanings") > 0) return;
    const bool is_mixed = H5Aexists(dataset, "component_units") > 0;
    EXPECT_EQ(TextOf(dataset, "units") == "(none)", is_mixed);
    EXPECT_EQ(is_mixed,
              name == "poses" || name.ends_with("/states") || name.ends_with("/observables"));
  });
}

TEST_P(Conventions, FillValuesAreTold) {
  ForEachDataset([&](const std::string& name, hid_t dataset) {
    const bool has = H5Aexists(dataset, "_FillValue") > 0;
    const hid_t type = H5Dget_type(dataset);
    const H5T_class_t kind = H5Tget_class(type);
    H5Tclose(type);
    const bool is_flag = IsFlag(name);
    EXPECT_EQ(is_flag, H5Aexists(dataset, "flag_meanings") > 0);
    const bool is_coordinate = H5DSis_scale(dataset) > 0;
    if (is_flag || kind == H5T_STRING || is_coordinate) {
      EXPECT_FALSE(has);
      return;
    }
    double told = 0, used = 0;
    ASSERT_TRUE(has);
    const hid_t attribute = H5Aopen(dataset, "_FillValue", H5P_DEFAULT);
    H5Aread(attribute, H5T_NATIVE_DOUBLE, &told);
    H5Aclose(attribute);
    const hid_t creation = H5Dget_create_plist(dataset);
    H5Pget_fill_value(creation, H5T_NATIVE_DOUBLE, &used);
    H5Pclose(creation);
    if (kind == H5T_INTEGER) {
      EXPECT_EQ(told, -1);
      EXPECT_EQ(used, -1);
    } else {
      EXPECT_TRUE(std::isnan(told) && std::isnan(used));
    }
  });
}

TEST_P(Conventions, ChunksHoldOneRunAndStayUnderOneMebibyte) {
  ForEachDataset([&](const std::string& name, hid_t dataset) {
    const protocol::Series* series = protocol::FindSeries(name);
    if (series == nullptr) return;
    const hid_t creation = H5Dget_create_plist(dataset);
    ASSERT_EQ(H5Pget_layout(creation), H5D_CHUNKED);
    std::vector<hsize_t> chunk(ShapeOf(dataset).size());
    H5Pget_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
    hsize_t bytes = series->ItemBytes();
    for (const hsize_t n : chunk) bytes *= n;
    EXPECT_LT(bytes, 1u << 20);
    EXPECT_TRUE(bytes > 1u << 17 || !series->HasCycles()) << "chunks are needlessly small";
    EXPECT_THAT(std::vector(chunk.begin(), chunk.begin() + 4), ElementsAre(1, 1, 1, 1));
    EXPECT_TRUE(name != "duration" || chunk[4] == 6);
    ASSERT_EQ(H5Pget_nfilters(creation), 3);
    unsigned flags = 0, level = 0;
    std::size_t n = 1;
    EXPECT_EQ(H5Pget_filter2(creation, 0, &flags, &n, &level, 0, nullptr, nullptr),
              H5Z_FILTER_SHUFFLE);
    n = 1;
    EXPECT_EQ(H5Pget_filter2(creation, 1, &flags, &n, &level, 0, nullptr, nullptr),
              H5Z_FILTER_DEFLATE);
    EXPECT_EQ(level, 1u);
    H5Pclose(creation);
  });
}

TEST_P(Conventions, CoordinatesSayWhatTheyAre) {
  const auto text = [&](const char* dataset, const char* attribute) {
    const hid_t id = H5Dopen2(file_, dataset, H5P_DEFAULT);
    const std::string result = TextOf(id, attribute);
    H5Dclose(id);
    return result;
  };
  EXPECT_EQ(text("size", "units"), "m");
  EXPECT_EQ(text("size", "parameter"), "objects.size");
  EXPECT_EQ(text("quantity", "units"), "1");
  EXPECT_EQ(text("run/size", "units"), "m");
  EXPECT_EQ(text("run/size", "parameter"), "objects.size");
  EXPECT_EQ(text("poses", "component_units"), "m m m 1 1 1 1");
  if (GetParam()) {
    EXPECT_EQ(text("accuracy/sample", "units"), "s");
    EXPECT_EQ(text("accuracy/size", "units"), "m");
  }
  EXPECT_EQ(text("run/host", "long_name"), "the machine that the run ran on");
  EXPECT_EQ(text("phase", "labels"), "broad narrow detect solve integrate step");
  EXPECT_EQ(text("phase", "labels_separator"), " ");
  EXPECT_EQ(text("contacts", "sample_dimension"), "contact_row");
  EXPECT_EQ(text("type", "labels"), "sphere;any(sphere 3, cone)");
  EXPECT_EQ(text("type", "labels_separator"), ";");
  EXPECT_EQ(text("status", "flag_meanings"), "missing done skipped failed crashed timed_out");
  EXPECT_EQ(
      text("verdict", "flag_meanings"),
      "unknown stable drifting penetrating collapsed clamped tunnelled exploded frozen removed "
      "non_finite timed_out crashed");
  EXPECT_EQ(text("duration", "units"), "ns");
}

TEST_P(Conventions, ProvenanceIsThere) {
  const hid_t group = H5Gopen2(file_, "/provenance", H5P_DEFAULT);
  EXPECT_THAT(LinksInOrder(group), ElementsAre("run", "cpu", "plan_text", "scenario_text"));
  EXPECT_EQ(TextOf(group, "compiler"), "gcc");
  H5Gclose(group);
}

INSTANTIATE_TEST_SUITE_P(, Conventions, testing::Bool(),
                         [](const testing::TestParamInfo<bool>& accuracy) {
                           return std::string(accuracy.param ? "WithErrors" : "WithoutErrors");
                         });

}  // namespace
}  // namespace cdb::tests
