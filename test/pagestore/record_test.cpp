#include "pagestore/record.h"

#include "pagestore/directory.h"
#include "pagestore/root.h"
#include "test/pagestore/store_fixture.h"

namespace atrium {
namespace {

constexpr StoreUuid kUuid{std::byte{1}, std::byte{2}};

struct Sealed {
  Bytes image;
  StoredExtent extent;
};

Sealed sealed(std::size_t length) {
  Sealed s;
  s.extent.length = length;
  s.extent.epoch = 5;
  s.extent.version = 3;
  s.image = filled(s.extent.granules() * kGranule, 1);
  s.extent.header_hash = seal_record(s.image, cluster(9), s.extent, kUuid);
  return s;
}

TEST(Record, WholeGranulesHoldHeaderAndPayload) {
  EXPECT_EQ(granules_of(0), 1u);
  EXPECT_EQ(granules_of(4096 - 64), 1u);
  EXPECT_EQ(granules_of(4096 - 63), 2u);
}

TEST(Record, NamesAreReadable) {
  EXPECT_EQ(to_string(cluster(12)), "cluster 12");
  EXPECT_EQ(to_string(record_id(RecordKind::kModel, 3)), "model 3");
  EXPECT_EQ(index_of(cluster(12)), 12u);
  EXPECT_EQ(kind_of(cluster(12)), RecordKind::kCluster);
}

// Whichever bit of an image is flipped, header, payload or padding, it is found out.
TEST(Record, EveryFlippedBitIsFoundOut) {
  Sealed s = sealed(1000);
  ASSERT_EQ(record_fault(s.image, cluster(9), s.extent, kUuid), "");
  for (std::size_t bit = 0; bit < 8 * s.image.size(); ++bit) {
    const auto mask = static_cast<std::byte>(1u << (bit % 8));
    s.image[bit / 8] ^= mask;
    ASSERT_NE(record_fault(s.image, cluster(9), s.extent, kUuid), "") << "bit " << bit;
    s.image[bit / 8] ^= mask;
  }
}

TEST(Record, AWholeImageThatIsNotTheOneExpectedIsFoundOut) {
  const Sealed s = sealed(1000);
  EXPECT_NE(record_fault(s.image, cluster(8), s.extent, kUuid), "");
  EXPECT_NE(record_fault(s.image, cluster(9), s.extent, StoreUuid{}), "");
  StoredExtent later = s.extent;
  later.version = 4;
  Bytes image = s.image;
  later.header_hash = seal_record(image, cluster(9), later, kUuid);
  EXPECT_NE(record_fault(s.image, cluster(9), later, kUuid), "");  // stale
}

TEST(Root, ComesBackAndEveryFlippedBitIsFoundOut) {
  Root root;
  root.epoch = 7;
  root.uuid = kUuid;
  root.directory = {.first = 3, .length = 96, .epoch = 7, .header_hash = 11, .version = 6};
  root.state = {.first = 4, .length = 10, .epoch = 7, .header_hash = 12, .version = 5};
  Bytes image = encode_root(root);
  const RootSlot slot = decode_root(image, 1);
  ASSERT_TRUE(slot.root.has_value()) << slot.fault;
  EXPECT_EQ(slot.root->epoch, 7u);
  EXPECT_EQ(slot.root->uuid, kUuid);
  EXPECT_EQ(slot.root->directory.header_hash, 11u);
  EXPECT_EQ(slot.root->state.version, 5u);
  EXPECT_FALSE(decode_root(image, 0).fault.empty());  // the other slot's
  for (std::size_t bit = 0; bit < 8 * image.size(); ++bit) {
    const auto mask = static_cast<std::byte>(1u << (bit % 8));
    image[bit / 8] ^= mask;
    ASSERT_FALSE(decode_root(image, 1).fault.empty()) << "bit " << bit;
    image[bit / 8] ^= mask;
  }
  EXPECT_TRUE(decode_root(Bytes(kGranule), 0).empty());
}

TEST(Directory, RefusesWhatIsNotARowOfEntriesInOrder) {
  const std::vector<DirectoryEntry> rows{entry_of(cluster(1), {.first = 0}),
                                         entry_of(cluster(2), {.first = 1})};
  const auto payload = std::as_bytes(std::span(rows));
  EXPECT_EQ(decode_directory(payload, "f").value().size(), 2u);
  EXPECT_FALSE(decode_directory(payload.first(payload.size() - 1), "f").ok());
  const std::vector<DirectoryEntry> twice{rows[1], rows[1]};
  EXPECT_FALSE(decode_directory(std::as_bytes(std::span(twice)), "f").ok());
}

}  // namespace
}  // namespace atrium
