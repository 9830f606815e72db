// The worked example of pagestore/FORMAT.md, byte by byte.
#include <fstream>

#include "test/pagestore/store_fixture.h"

namespace atrium {
namespace {

class FormatExample : public StoreTest {
 protected:
  FormatExample() {
    auto store = make(4);
    EXPECT_OK(store->create_record(cluster(7), bytes_of("light")));
    EXPECT_OK(store->checkpoint(bytes_of("it=1")));
    roots_ = file("roots");
    pages_ = file("pages.0000");
  }

  std::string file(const std::string& name) const {
    std::ifstream in(dir_ + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static std::string le(std::uint64_t value, std::size_t bytes = 8) {
    std::string text;
    for (std::size_t i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
  }
  static std::string xxh3(const std::string& text) { return le(hash_bytes(bytes_of(text))); }

  std::string roots_, pages_;
};

TEST_F(FormatExample, Extents) {
  ASSERT_EQ(pages_.size(), 1048576u);
  const std::string uuid = pages_.substr(0x7020, 16);
  const std::string header = "ATR1" + le(0, 4) + le(0x0100000000000007) + le(5) + le(2) + uuid +
                             std::string("\x19\x2a\xca\x8d\xfa\x13\xb0\x25", 8);
  EXPECT_EQ(pages_.substr(0x7000, 56), header);
  EXPECT_EQ(pages_.substr(0x7038, 8), xxh3(header));
  EXPECT_EQ(pages_.substr(0x7040, 4096 - 64), "light" + std::string(4096 - 64 - 5, '\0'));

  const std::string directory_header = "ATR1" + le(1, 4) + le(0) + le(48) + le(2) + uuid;
  EXPECT_EQ(pages_.substr(0x2000, 48), directory_header);
  const std::string entry = le(0x0100000000000007) + le(5) + le(2) + xxh3(header) + le(7) + le(0);
  EXPECT_EQ(pages_.substr(0x2040, 48), entry);
  EXPECT_EQ(pages_.substr(0x3040, 5), std::string("it=1\0", 5));
}

TEST_F(FormatExample, Roots) {
  ASSERT_EQ(roots_.size(), 8192u);
  const std::string root = "ATRIUMRT" + le(1, 4) + le(4096, 4) + pages_.substr(0x7020, 16) + le(2) +
                           le(2) + le(48) + le(2) + pages_.substr(0x2038, 8) + le(1) +  //
                           le(3) + le(4) + le(2) + pages_.substr(0x3038, 8) + le(1) +
                           std::string(3968, '\0');
  EXPECT_EQ(roots_.substr(0, 4088), root);
  EXPECT_EQ(roots_.substr(4088, 8), xxh3(root));
  EXPECT_EQ(roots_.substr(4096, 8), "ATRIUMRT");
  EXPECT_EQ(roots_.substr(4096 + 32, 8), le(1));
}

}  // namespace
}  // namespace atrium
