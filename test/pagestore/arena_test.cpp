#include "pagestore/arena.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <vector>

namespace atrium {
namespace {

std::unique_ptr<Arena> arena_of(std::uint64_t granules) {
  return Arena::make(granules * kGranule).value();
}

TEST(Arena, IsExact) {
  const auto arena = arena_of(10);
  EXPECT_EQ(arena->allocate(6), 0u);
  EXPECT_EQ(arena->allocate(5), std::nullopt);
  EXPECT_EQ(arena->allocate(4), 6u);
  EXPECT_EQ(arena->allocate(1), std::nullopt);
  EXPECT_EQ(arena->used_granules(), 10u);
  arena->free(0, 6);
  EXPECT_EQ(arena->used_granules(), 4u);
  EXPECT_EQ(arena->peak_granules(), 10u);
}

TEST(Arena, BytesThatMakeNoGranuleAreNotUsed) {
  EXPECT_EQ(Arena::make(3 * kGranule + 4095).value()->granules(), 3u);
  EXPECT_EQ(Arena::make(4095).status().code(), Code::kUsage);
}

std::size_t resident_pages(const Arena& arena, std::uint64_t granules) {
  std::vector<unsigned char> resident(granules);
  EXPECT_EQ(::mincore(arena.image(0, granules).data(), granules * kGranule, resident.data()), 0);
  return std::size_t(std::count_if(resident.begin(), resident.end(),
                                   [](unsigned char page) { return page & 1; }));
}

TEST(Arena, TakesMemoryAsItIsUsed) {
  for (const std::uint64_t granules : {std::uint64_t{1000}, (std::uint64_t{1} << 30) / kGranule})
    EXPECT_LT(resident_pages(*arena_of(granules), granules), granules / 2) << granules;
}

TEST(Arena, ResizeStaysInPlaceWhereItCan) {
  const auto arena = arena_of(10);
  const auto a = arena->allocate(3);
  EXPECT_EQ(arena->resize(*a, 3, 8), *a);
  EXPECT_EQ(arena->resize(*a, 8, 2), *a);
  EXPECT_EQ(arena->free_granules(), 8u);
  const auto b = arena->allocate(2);  // right behind
  EXPECT_EQ(*b, 2u);
  arena->image(*a, 2)[5] = std::byte{42};
  const auto moved = arena->resize(*a, 2, 3);
  EXPECT_EQ(moved, 4u);
  EXPECT_EQ(arena->image(*moved, 3)[5], std::byte{42});
  EXPECT_EQ(arena->resize(*moved, 3, 9), std::nullopt);
  EXPECT_EQ(arena->used_granules(), 5u);
}

}  // namespace
}  // namespace atrium
