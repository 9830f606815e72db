#include "pagestore/policy.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "pagestore/policies/frequency_sketch.h"

namespace atrium {
namespace {

std::unique_ptr<Policy> policy_named(const std::string& name, std::uint64_t capacity) {
  return make_policy(parse_policy(name).value(), capacity);
}

// An arena in front of a policy: requests by letters, each released at once.
class LetterArena {
 public:
  LetterArena(const std::string& policy, std::uint64_t capacity)
      : capacity_(capacity), policy_(policy_named(policy, capacity)) {}

  void size(char letter, std::uint64_t bytes) { sizes_[letter] = bytes; }

  // Returns those that left, in order.
  std::string request(const std::string& letters) {
    std::string left;
    for (const char letter : letters) left += request(letter);
    return left;
  }
  bool holds(char letter) const { return in_.contains(letter); }

 private:
  std::string request(char letter) {
    const RecordNumber record = number(letter);
    if (holds(letter)) {
      policy_->on_hit(record);
      policy_->on_release(record);
      return "";
    }
    const std::uint64_t bytes = sizes_.contains(letter) ? sizes_[letter] : 1;
    policy_->on_miss(record, bytes);
    if (!policy_->admits(record, bytes)) return "";
    std::string left;
    while (used_ + bytes > capacity_) left += evict();
    policy_->on_insert(record, bytes);
    policy_->on_release(record);
    in_[letter] = bytes;
    used_ += bytes;
    return left;
  }
  char evict() {
    const RecordNumber record = policy_->victim(0).value();
    const char letter = letters_[record];
    used_ -= in_.at(letter);
    in_.erase(letter);
    policy_->on_evict(record);
    return letter;
  }
  RecordNumber number(char letter) {
    if (letters_.find(letter) == letters_.npos) letters_ += letter;
    return static_cast<RecordNumber>(letters_.find(letter));
  }

  std::uint64_t capacity_, used_ = 0;
  std::unique_ptr<Policy> policy_;
  std::map<char, std::uint64_t> sizes_, in_;
  std::string letters_;  // by record number
};

TEST(Lru, TheOneReleasedLongestAgoGoesFirst) {
  const auto lru = policy_named("lru", 0);
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

TEST(Fifo, HitsDoNotHelp) { EXPECT_EQ(LetterArena("fifo", 3).request("abcadbe"), "ab"); }

TEST(Fifo, APinnedRecordKeepsItsPlace) {
  const auto fifo = policy_named("fifo", 0);
  for (RecordNumber i = 0; i < 2; ++i) fifo->on_insert(i, 1);
  fifo->on_release(1);
  EXPECT_EQ(fifo->victim(0), 1u);
  fifo->on_release(0);  // later than 1, but in before it
  EXPECT_EQ(fifo->victim(0), 0u);
}

// a, requested again, goes round: b leaves for d, c for e; at f it is a's turn, its bit cleared.
TEST(Clock, ARequestedRecordGoesRoundOnce) {
  EXPECT_EQ(LetterArena("clock", 3).request("abcadef"), "bca");
}

// The hand clears a's bit, takes b for d, c for e and then, never back at a, d for f.
TEST(Sieve, TheHandGoesOnPastARequestedRecord) {
  EXPECT_EQ(LetterArena("sieve", 3).request("abcadef"), "bcd");
}

// b left, the newest then; c came in behind the hand, which for d starts again at a, clears both
// bits and, past c, takes a.
TEST(Sieve, PastTheNewestTheHandStartsAtTheOldest) {
  EXPECT_EQ(LetterArena("sieve", 2).request("abacacd"), "ba");
}

// d leaves for e though it came last: it was requested once. Then all have two: a is oldest.
TEST(Lfu, OfTheLeastRequestedTheOneReleasedLongestAgo) {
  EXPECT_EQ(LetterArena("lfu", 3).request("aabbcdeef"), "cda");
}

// A1in 1, A1out 2 of 4. Misses alone empty A1in in order; a, d, e come back from A1out to Am while
// A1in is over its share; at f A1in has b alone, and the oldest of Am, a, leaves.
TEST(TwoQ, WhatComesBackFromA1outLivesInAm) {
  EXPECT_EQ(LetterArena("2q", 4).request("abcdefagbdef"), "abcdefga");
}

// A1out holds two names: when a asks again after three more left, it is as new as any.
TEST(TwoQ, A1outForgets) {
  EXPECT_EQ(LetterArena("2q", 4).request("abcdefg"), "abc");
  EXPECT_EQ(LetterArena("2q", 4).request("abcdefgahijk"), "abcdefga");
  EXPECT_EQ(LetterArena("2q", 4).request("abcdefbhijkl"), "abcdefhi");  // b stays: it is in Am
}

// Small 1, main 9, ghosts 9 of 10. At k, a (two hits) goes on to main, b (one) leaves; b comes back
// from the ghosts to main, for c. l to s push out d to k; these come back from the ghosts one by
// one until main has ten. a is requested once more, so that for t, with main over its share, it
// goes round and b leaves.
TEST(S3Fifo, TwiceRequestedOrRememberedGoesToMain) {
  LetterArena arena("s3fifo", 10);
  EXPECT_EQ(arena.request("abcdefghijaabkb"), "bc");
  EXPECT_EQ(arena.request("lmnopqrs"), "defghijk");
  EXPECT_EQ(arena.request("defghijk"), "lmnopqrs");
  EXPECT_EQ(arena.request("at"), "b");
}

TEST(S3Fifo, WhatIsLargerThanTheSmallQueueIsNotAdmitted) {
  const auto s3fifo = policy_named("s3fifo", 109);  // small: 10
  EXPECT_TRUE(s3fifo->admits(0, 10));
  EXPECT_FALSE(s3fifo->admits(0, 11));
}

TEST(TwoQ, WhatIsLargerThanA1inIsNotAdmitted) {
  const auto two_q = policy_named("2q", 43);  // A1in: 10
  EXPECT_TRUE(two_q->admits(0, 10));
  EXPECT_FALSE(two_q->admits(0, 11));
}

// Forced in nevertheless, such a record is the first to leave.
TEST(TwoQ, ARecordThatWasNotAdmittedLeavesFirst) {
  const auto two_q = policy_named("2q", 40);
  for (RecordNumber i = 0; i < 3; ++i) {
    two_q->on_insert(i, i == 1 ? 15 : 6);
    two_q->on_release(i);
  }
  EXPECT_EQ(two_q->victim(0), 1u);
}

// T1 abc, a hit: T2 a. For d, b leaves to B1. For e, L1 is full: b is forgotten, c leaves. c is in
// B1: p = 1, d leaves to B1, c to T2. For f, T1 (e) has p: a leaves from T2. a is in B2: p = 0, and
// e leaves.
TEST(Arc, GhostsMoveTheShares) {
  for (const char* name : {"arc", "arc-compat"})
    EXPECT_EQ(LetterArena(name, 3).request("abcadecfa"), "bcdae") << name;
}

// The same ten times as large: `arc` moves p by 10, a record's size, `arc-compat` by 1, which
// leaves e, of 10 bytes in T1, over its share.
TEST(Arc, TheStepIsTheRecordsSize) {
  for (const char* name : {"arc", "arc-compat"}) {
    LetterArena arena(name, 30);
    for (const char letter : std::string("abcdef")) arena.size(letter, 10);
    EXPECT_EQ(arena.request("abcadecf"), name == std::string("arc") ? "bcda" : "bcde") << name;
  }
}

// T1 alone fills the arena, B1 is empty: a leaves without a ghost, so it comes back to T1 and, for
// d, T1's oldest is b, again without one.
TEST(Arc, AFullT1LeavesNoGhost) { EXPECT_EQ(LetterArena("arc", 2).request("abcabc"), "abca"); }

// a 1/4, b 1/5: for c b leaves and L = 1/5, so c has 1/5 + 1/3. For d a leaves, L = 1/4, d has 1/4
// + 1/5 and leaves for e before c though it is newer.
TEST(Gdsf, TheLeastPriorityGoesAndAgesTheArena) {
  LetterArena arena("gdsf", 10);
  for (const auto& [letter, bytes] : {std::pair{'a', 4}, {'b', 5}, {'c', 3}, {'d', 5}, {'e', 5}})
    arena.size(letter, static_cast<std::uint64_t>(bytes));
  EXPECT_EQ(arena.request("abcde"), "bad");
}

TEST(Gdsf, TwoRequestsOutweighTwiceTheSize) {
  LetterArena arena("gdsf", 10);
  for (const auto& [letter, bytes] : {std::pair{'a', 4}, {'b', 5}, {'c', 3}})
    arena.size(letter, static_cast<std::uint64_t>(bytes));
  EXPECT_EQ(arena.request("abbc"), "a");
}

TEST(Lookahead, FirstTheUnknownByReleaseThenTheFarthest) {
  const auto policy = policy_named("lookahead:9", 0);
  for (RecordNumber i = 0; i < 4; ++i) policy->on_insert(i, 1);
  policy->on_foreseen(1, 5);
  for (const RecordNumber i : {3, 1, 0, 2}) policy->on_release(i);
  EXPECT_EQ(policy->victim(0), 3u);
  policy->on_foreseen(3, 4);  // comes within reach
  EXPECT_EQ(policy->victim(0), 0u);
  policy->on_evict(0);
  EXPECT_EQ(policy->victim(0), 2u);
  policy->on_evict(2);
  EXPECT_EQ(policy->victim(0), 1u);  // 5 is farther than 4
  policy->on_hit(1);
  policy->on_release(1);  // what it was requested for is past: unknown again
  EXPECT_EQ(policy->victim(6), 1u);
}

// At 0: 4 bytes × 5 requests against 1 × 10. At 4, 4 × 1 against 1 × 6.
TEST(BeladySize, TheLargestSizeTimesDistanceFromNowGoesFirst) {
  const auto policy = policy_named("belady-size", 0);
  policy->on_insert(0, 4);
  policy->on_foreseen(0, 5);
  policy->on_insert(1, 1);
  policy->on_foreseen(1, 10);
  for (const RecordNumber i : {0, 1}) policy->on_release(i);
  EXPECT_EQ(policy->victim(0), 0u);
  EXPECT_EQ(policy->victim(4), 1u);
  policy->on_insert(2, 1);
  policy->on_release(2);
  EXPECT_EQ(policy->victim(0), 2u);  // never again
}

// A schedule that is given up and told anew finds what is held where it was last filed.
TEST(BeladyAndBeladySize, WhatIsForeseenAnewIsFiledAnew) {
  for (const char* name : {"belady", "belady-size"}) {
    SCOPED_TRACE(name);
    const auto policy = policy_named(name, 0);
    for (const RecordNumber i : {0, 1}) {
      policy->on_insert(i, 1);
      policy->on_foreseen(i, 5 + i);
      policy->on_release(i);
    }
    policy->on_foreseen(0, 9);
    EXPECT_EQ(policy->victim(0), 0u);
    policy->on_evict(0);
    EXPECT_EQ(policy->victim(0), 1u);
    policy->on_evict(1);
    EXPECT_FALSE(policy->victim(0).has_value());
  }
}

// Window 1, main 99 of 100 records, each requested twice. Of fifty that are requested once each the
// first pushes the last of the hundred out of the window, which is no better than main's oldest;
// then each pushes out the one before it. One requested three times gets in, for main's oldest.
TEST(WTinyLfu, WhatIsRequestedOnceStaysOutOfTheMainPart) {
  constexpr RecordNumber kArena = 100, kFresh = 50;
  const auto policy = policy_named("wtinylfu", kArena);
  for (RecordNumber i = 0; i < kArena; ++i) {
    policy->on_miss(i, 1);
    policy->on_insert(i, 1);
    policy->on_release(i);
    policy->on_hit(i);
    policy->on_release(i);
  }
  const auto miss = [&](RecordNumber record) {
    policy->on_miss(record, 1);
    const RecordNumber left = policy->victim(0).value();
    policy->on_evict(left);
    policy->on_insert(record, 1);
    policy->on_release(record);
    return left;
  };
  for (RecordNumber i = kArena; i < kArena + kFresh; ++i) EXPECT_EQ(miss(i), i - 1);
  for (int hit = 0; hit < 2; ++hit) {
    policy->on_hit(kArena + kFresh - 1);
    policy->on_release(kArena + kFresh - 1);
  }
  EXPECT_LT(miss(kArena + kFresh), kArena);
}

TEST(FrequencySketch, CountsUpToFifteen) {
  FrequencySketch sketch;
  for (std::uint32_t n = 0; n < 20; ++n) {
    EXPECT_EQ(sketch.estimate(7), std::min(n, 15u));
    sketch.count(7);
  }
  EXPECT_EQ(sketch.estimate(8), 0u);
}

// Nothing is halved in the first ten times 1024 requests.
TEST(FrequencySketch, NeverTooFewAndTheSameAfterWidening) {
  FrequencySketch sketch;
  std::mt19937_64 draw(1);
  constexpr RecordNumber kRecords = 1500;
  std::vector<std::uint32_t> requests(kRecords), estimates(kRecords);
  for (int i = 0; i < 10'000; ++i) {
    const auto record = static_cast<RecordNumber>(std::min(draw() % kRecords, draw() % kRecords));
    ++requests[record];
    sketch.count(record);
  }
  for (RecordNumber r = 0; r < kRecords; ++r) {
    estimates[r] = sketch.estimate(r);
    EXPECT_GE(estimates[r], std::min(requests[r], 15u));
  }
  sketch.fit(5000);
  for (RecordNumber r = 0; r < kRecords; ++r) EXPECT_EQ(sketch.estimate(r), estimates[r]);
}

TEST(FrequencySketch, TenRequestsARecordHalveIt) {
  FrequencySketch sketch;
  for (int i = 0; i < 12; ++i) sketch.count(0);
  for (int i = 12; i < 10 * 1024 - 1; ++i) sketch.count(1);
  EXPECT_EQ(sketch.estimate(0), 12u);
  sketch.count(1);
  EXPECT_EQ(sketch.estimate(0), 6u);
  EXPECT_EQ(sketch.estimate(1), 7u);  // of 15
}

std::vector<std::string> all_policies() {
  std::vector<std::string> names = policy_names();
  for (std::string& name : names)
    if (name.ends_with(":W")) name.back() = '9';
  return names;
}

TEST(Policies, EveryNameInTheTableMakesOne) {
  for (const std::string& name : all_policies()) {
    const auto choice = parse_policy(name);
    ASSERT_TRUE(choice.ok()) << name;
    EXPECT_NE(make_policy(*choice, 1 << 20), nullptr);
  }
  for (const char* wrong : {"", "lru:5", "nosuch", "lookahead", "lookahead:0", "lookahead:x"})
    EXPECT_EQ(parse_policy(wrong).status().code(), Code::kUsage) << wrong;
}

// A store that does at random whatever a store may do, and checks what it is told to evict.
class RandomStore {
 public:
  RandomStore(const std::string& policy, std::uint64_t seed)
      : draw_(seed),
        foretells_(parse_policy(policy)->foresight > 0),
        policy_(policy_named(policy, kCapacity)) {}

  void step() {
    const auto record = static_cast<RecordNumber>(below(kRecords));
    const bool in = held_.contains(record);
    switch (below(5)) {
      case 0:
      case 1:
        return request(record);
      case 2:
        return in && held_[record].pins > 0 ? resize(record) : request(record);
      default:
        for (auto& [r, held] : held_)
          if (held.pins > 0 && below(2) == 0 && --held.pins == 0) policy_->on_release(r);
    }
  }
  std::uint64_t evictions() const { return evictions_; }

 private:
  static constexpr std::uint64_t kCapacity = 100, kRecords = 40, kLargest = 30, kMostPinned = 60;
  struct Held {
    std::uint64_t bytes = 0;
    int pins = 0;
  };

  std::uint64_t below(std::uint64_t n) { return draw_() % n; }
  std::uint64_t sum(bool pinned_only) const {
    std::uint64_t bytes = 0;
    for (const auto& [r, held] : held_) bytes += !pinned_only || held.pins > 0 ? held.bytes : 0;
    return bytes;
  }

  void request(RecordNumber record) {
    ++now_;
    if (held_.contains(record)) {
      policy_->on_hit(record);
    } else {
      const std::uint64_t bytes = 1 + below(kLargest);
      if (sum(true) + bytes > kMostPinned) return;
      policy_->on_miss(record, bytes);
      if (below(20) == 0) return;  // its bringing in fails
      make_room(sum(false), bytes);
      policy_->on_insert(record, bytes);
      held_[record].bytes = bytes;
    }
    ++held_[record].pins;
    if (foretells_ && below(2) == 0) policy_->on_foreseen(record, now_ + below(50));
  }

  void resize(RecordNumber record) {
    const std::uint64_t bytes = 1 + below(kLargest);
    const std::uint64_t own = held_[record].bytes;
    if (sum(true) - own + bytes > kMostPinned) return;
    make_room(sum(false) - own, bytes);
    held_[record].bytes = bytes;
    policy_->on_resize(record, bytes);
  }

  void make_room(std::uint64_t others, std::uint64_t bytes) {
    for (; others + bytes > kCapacity; ++evictions_) {
      const auto victim = policy_->victim(now_);
      ASSERT_TRUE(victim) << "what is pinned leaves room, so something else is in";
      ASSERT_TRUE(held_.contains(*victim));
      ASSERT_EQ(held_[*victim].pins, 0);
      others -= held_[*victim].bytes;
      held_.erase(*victim);
      policy_->on_evict(*victim);
    }
    bool all_pinned = true;
    for (const auto& [r, held] : held_) all_pinned = all_pinned && held.pins > 0;
    ASSERT_EQ(policy_->victim(now_).has_value(), !all_pinned);
  }

  std::mt19937_64 draw_;
  bool foretells_;
  std::unique_ptr<Policy> policy_;
  std::map<RecordNumber, Held> held_;
  std::uint64_t now_ = 0, evictions_ = 0;
};

TEST(Policies, NoneNamesAPinnedRecordAndAllNameOneWhileThereIsOne) {
  for (const std::string& name : all_policies()) {
    SCOPED_TRACE(name);
    for (std::uint64_t seed = 0; seed < 20 && !testing::Test::HasFatalFailure(); ++seed) {
      RandomStore store(name, seed);
      for (int i = 0; i < 1000 && !testing::Test::HasFatalFailure(); ++i) store.step();
      EXPECT_GT(store.evictions(), 100u);
    }
  }
}

}  // namespace
}  // namespace atrium
