// What the page store's tests share: records filled from a seed, and a directory of one's own.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "pagestore/cluster_store.h"

namespace atrium {

using Bytes = std::vector<std::byte>;

inline Bytes filled(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Bytes bytes(size);
  for (std::size_t at = 0; at < size; at += sizeof(std::uint64_t)) {
    const std::uint64_t word = random();
    std::memcpy(bytes.data() + at, &word, std::min(sizeof word, size - at));
  }
  return bytes;
}

inline Bytes copy_of(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }
inline Bytes bytes_of(const std::string& text) {
  return copy_of(std::as_bytes(std::span(text.data(), text.size())));
}

inline RecordId cluster(std::uint64_t i) { return record_id(RecordKind::kCluster, i); }

// Fails the test with the whole message.
#define ASSERT_OK(expression)                                       \
  do {                                                              \
    const ::atrium::Status asserted_status = (expression);          \
    ASSERT_TRUE(asserted_status.ok()) << asserted_status.message(); \
  } while (false)
#define EXPECT_OK(expression)                                       \
  do {                                                              \
    const ::atrium::Status expected_status = (expression);          \
    EXPECT_TRUE(expected_status.ok()) << expected_status.message(); \
  } while (false)

class StoreTest : public ::testing::Test {
 protected:
  StoreTest() {
    std::string name = (std::filesystem::temp_directory_path() / "atrium-store-XXXXXX").string();
    dir_ = ::mkdtemp(name.data());
  }
  ~StoreTest() override { std::filesystem::remove_all(dir_); }

  static StoreOptions arena_of(std::size_t granules) {
    return {.arena_bytes = granules * kGranule};
  }
  std::unique_ptr<ClusterStore> make(std::size_t arena_granules) {
    auto store = ClusterStore::create(dir_, arena_of(arena_granules));
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }
  std::unique_ptr<ClusterStore> reopen(std::size_t arena_granules,
                                       OpenMode mode = OpenMode::kReadWrite) {
    auto store = ClusterStore::open(dir_, arena_of(arena_granules), mode);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }

  std::string dir_;
};

inline Bytes contents(ClusterStore& store, RecordId id) {
  auto pin = store.read(id);
  EXPECT_TRUE(pin.ok()) << pin.status().message();
  return pin.ok() ? copy_of((*pin).bytes()) : Bytes{};
}

}  // namespace atrium
