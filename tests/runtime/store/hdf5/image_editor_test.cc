// HDF5 reads what was written into the bytes of its file.
#include "runtime/store/hdf5/image_editor.h"

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <vector>

#include "runtime/store/hdf5/file.h"

namespace cdb::tests {
namespace {

using hdf5::Type;

/// A file with a value of each kind that can be edited, and others that cannot.
class ImageEditor : public testing::Test {
 protected:
  ImageEditor() {
    const auto make = [this](const char* name, Type type, hdf5::Shape shape, hdf5::Shape chunk,
                             bool is_small) {
      file_.CreateDataset({name, type, std::move(shape), std::move(chunk), 0, is_small});
    };
    make("flag", Type::kInt8, {1}, {}, true);
    make("count", Type::kInt32, {1, 1}, {}, true);
    make("real", Type::kFloat64, {}, {}, true);
    make("texts", Type::kText, {3}, {}, true);
    make("chunk", Type::kFloat64, {1, 50}, {1, 50}, true);
    make("chunks", Type::kFloat64, {1, 50}, {1, 25}, true);
    make("large", Type::kFloat64, {1}, {}, false);
    // So many that the header has several blocks.
    for (int i = 0; i < 40; ++i) file_.SetText(("a" + std::to_string(i)).c_str(), "0123456789");
  }

  hdf5::File file_ = hdf5::File::CreateInMemory();
};

TEST_F(ImageEditor, Hdf5ReadsWhatItWrote) {
  hdf5::EditableImage image(file_.Image());
  const auto flag = image.FindNumber(file_.OpenDataset("flag"));
  const auto count = image.FindNumber(file_.OpenDataset("count"));
  const auto real = image.FindNumber(file_.OpenDataset("real"));
  const auto texts = image.FindTexts(file_.OpenDataset("texts"));
  const auto chunk = image.FindChunk(file_.OpenDataset("chunk"));
  const auto first = image.FindAttribute(file_, "a0"), last = image.FindAttribute(file_, "a39");
  for (const double x : {1.0, -2.0}) {
    SCOPED_TRACE(x);
    std::vector<double> values(50, x);
    values[7] = 0.25;
    hdf5::ImageEditor editor(image);
    editor.SetNumber(flag, x);
    editor.SetNumber(count, 1000 * x);
    editor.SetNumber(real, x / 3);
    editor.SetText(texts, "first");
    editor.SetText(texts + 2 * hdf5::EditableImage::kTextBytes, std::string(5000, 'x'));
    editor.SetChunk(chunk, hdf5::Filtered(std::as_bytes(std::span(values)), sizeof(double)));
    editor.SetAttribute(first, "9876543210");
    editor.SetAttribute(last, "abcdefghij");
    EXPECT_THROW(editor.SetAttribute(last, "longer than before"), hdf5::Error);
    const std::vector<std::byte> bytes = editor.Finish();
    const hdf5::File read = hdf5::File::OpenImage(bytes);
    EXPECT_EQ(read.OpenDataset("flag").Read(), std::vector{x});
    EXPECT_EQ(read.OpenDataset("count").Read(), std::vector{1000 * x});
    EXPECT_EQ(read.OpenDataset("real").Read(), std::vector{x / 3});
    EXPECT_EQ(read.OpenDataset("texts").ReadText(),
              (std::vector<std::string>{"first", "", std::string(5000, 'x')}));
    EXPECT_EQ(read.OpenDataset("chunk").Read(), values);
    EXPECT_EQ(read.Text("a0"), "9876543210");
    EXPECT_EQ(read.Text("a1"), "0123456789");
    EXPECT_EQ(read.Text("a39"), "abcdefghij");
  }
}

TEST_F(ImageEditor, FindsNothingThatIsStoredOtherwise) {
  hdf5::EditableImage image(file_.Image());
  EXPECT_THROW(image.FindNumber(file_.OpenDataset("large")), hdf5::Error);
  EXPECT_THROW(image.FindNumber(file_.OpenDataset("chunk")), hdf5::Error);
  EXPECT_THROW(image.FindNumber(file_.OpenDataset("texts")), hdf5::Error);
  EXPECT_THROW(image.FindTexts(file_.OpenDataset("real")), hdf5::Error);
  EXPECT_THROW(image.FindChunk(file_.OpenDataset("real")), hdf5::Error);
  EXPECT_THROW(image.FindChunk(file_.OpenDataset("chunks")), hdf5::Error);
  EXPECT_THROW(image.FindAttribute(file_, "b"), hdf5::Error);
}

TEST_F(ImageEditor, RefusesDamagedHeaders) {
  const std::vector<std::byte> whole = file_.Image();
  const hdf5::Dataset dataset = file_.OpenDataset("chunk");
  EXPECT_THROW(hdf5::EditableImage(std::vector<std::byte>(whole.size())), hdf5::Error);
  EXPECT_THROW(hdf5::EditableImage({whole.begin(), whole.end() - 1}), hdf5::Error);
  EXPECT_THROW(hdf5::ObjectHeader(whole, whole.size()), hdf5::Error);
  EXPECT_THROW(hdf5::ObjectHeader(whole, ~std::uint64_t{0}), hdf5::Error);
  // No number in a header may lead out of the file.
  const std::uint64_t bytes = hdf5::ObjectHeader(whole, dataset.Address()).blocks().at(0).bytes;
  for (const std::uint64_t address : {dataset.Address(), file_.Address()})
    for (std::uint64_t i = 0; i < bytes; ++i)
      for (const int value : {0, 0x7f, 0xff}) {
        std::vector<std::byte> damaged = whole;
        damaged.at(address + i) = static_cast<std::byte>(value);
        try {
          const hdf5::ObjectHeader header(damaged, address);
          for (const hdf5::Extent& block : header.blocks()) {
            ASSERT_LE(block.begin, whole.size());
            ASSERT_LE(block.bytes, whole.size() - block.begin);
          }
          header.Attribute("a39");
          header.SingleChunk();
        } catch (const hdf5::Error&) {
        }
      }
}

}  // namespace
}  // namespace cdb::tests
