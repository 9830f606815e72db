#include "pagestore/policy.h"

#include <gtest/gtest.h>

namespace atrium {
namespace {

RecordId id(std::uint64_t i) { return record_id(RecordKind::kCluster, i); }

TEST(Lru, TheOneReleasedLongestAgoGoesFirst) {
  const auto lru = make_policy("lru", 0).value();
  EXPECT_EQ(lru->victim(), std::nullopt);
  for (std::uint64_t i = 0; i < 3; ++i) lru->on_insert(id(i), 1);
  EXPECT_EQ(lru->victim(), std::nullopt);  // all pinned
  for (const std::uint64_t i : {2, 0, 1}) lru->on_release(id(i));
  EXPECT_EQ(lru->victim(), id(2));
  lru->on_hit(id(2));  // pinned again
  EXPECT_EQ(lru->victim(), id(0));
  lru->on_evict(id(0));
  lru->on_release(id(2));
  EXPECT_EQ(lru->victim(), id(1));  // by release, not by request
  lru->on_evict(id(1));
  EXPECT_EQ(lru->victim(), id(2));
}

TEST(Policies, EveryNameInTheTableMakesOne) {
  for (const std::string& name : policy_names()) EXPECT_TRUE(make_policy(name, 1 << 20).ok());
  EXPECT_EQ(make_policy("", 1 << 20).status().code(), Code::kUsage);
}

}  // namespace
}  // namespace atrium
