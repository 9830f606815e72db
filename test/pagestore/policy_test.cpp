#include "pagestore/policy.h"

#include <gtest/gtest.h>

namespace atrium {
namespace {

TEST(Lru, TheOneReleasedLongestAgoGoesFirst) {
  const auto lru = make_policy(parse_policy("lru").value(), 0);
  EXPECT_EQ(lru->victim(0), std::nullopt);
  for (RecordNumber i = 0; i < 3; ++i) lru->on_insert(i, 1);
  EXPECT_EQ(lru->victim(0), std::nullopt);  // all pinned
  for (const RecordNumber i : {2, 0, 1}) lru->on_release(i);
  EXPECT_EQ(lru->victim(0), 2u);
  lru->on_hit(2);  // pinned again
  EXPECT_EQ(lru->victim(0), 0u);
  lru->on_evict(0);
  lru->on_release(2);
  EXPECT_EQ(lru->victim(0), 1u);  // by release, not by request
  lru->on_evict(1);
  EXPECT_EQ(lru->victim(0), 2u);
}

TEST(Policies, EveryNameInTheTableMakesOne) {
  for (std::string name : policy_names()) {
    if (name.ends_with(":W")) name.back() = '9';
    const auto choice = parse_policy(name);
    ASSERT_TRUE(choice.ok()) << name;
    EXPECT_NE(make_policy(*choice, 1 << 20), nullptr);
  }
  for (const char* wrong : {"", "lru:5", "nosuch"})
    EXPECT_EQ(parse_policy(wrong).status().code(), Code::kUsage);
}

}  // namespace
}  // namespace atrium
