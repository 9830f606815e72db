#include "bench/workload.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "engine/check.h"

namespace atrium {

namespace {

constexpr double kSmallestRecord = 8 << 10;
constexpr std::size_t kNoiseBytes = std::size_t{4} << 20;  // of it each payload is a slice

constexpr RecordIndex kRoom = 100;  // records
constexpr RecordIndex kRooms = kRecords / kRoom;
constexpr std::size_t kGather = 50;  // requests

// What a room sees are the rooms from it on. After a gather one leaves for any room, or goes on to
// the next, or stays.
struct Tour {
  RecordIndex visible_rooms;
  double leave, go_on;
};
// An LRU of kArenaBytes hits .33 in A, as in the paper's random order, and .65 in B, much as in its
// model order.
constexpr Tour kTourA{18, .02, .1};
constexpr Tour kTourB{8, .02, .05};

// The standard's distributions differ between libraries; its generators do not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : next_(seed) {}
  double share() { return std::ldexp(static_cast<double>(next_() >> 11), -53); }  // [0, 1)
  RecordIndex below(RecordIndex n) { return static_cast<RecordIndex>(share() * n); }
  std::uint64_t bits() { return next_(); }

 private:
  std::mt19937_64 next_;
};

struct Head {
  std::uint64_t hash;  // of all after it
  std::uint64_t record, version;
};

Head head_of(std::span<const std::byte> payload) {
  Head head;
  ATRIUM_CHECK(payload.size() >= sizeof head);
  std::memcpy(&head, payload.data(), sizeof head);
  return head;
}

std::uint64_t hash_of(std::span<const std::byte> payload) {
  const auto hashed = payload.subspan(sizeof(Head::hash));
  return XXH3_64bits(hashed.data(), hashed.size());
}

}  // namespace

const std::vector<std::size_t>& record_sizes() {
  static const std::vector<std::size_t> kSizes = [] {
    std::vector<std::size_t> sizes(kRecords);
    Dice dice(1);
    for (std::size_t& size : sizes)
      size = static_cast<std::size_t>(kSmallestRecord *
                                      std::pow(kLargestRecord / kSmallestRecord, dice.share()));
    return sizes;
  }();
  return kSizes;
}

std::vector<RecordIndex> requests(Order order) {
  const Tour tour = order == Order::kA ? kTourA : kTourB;
  Dice dice(2);
  std::vector<RecordIndex> visible(tour.visible_rooms * kRoom), asked;
  RecordIndex room = 0;
  while (asked.size() < kReads) {
    std::iota(visible.begin(), visible.end(), room * kRoom);
    for (std::size_t i = 0; i < kGather; ++i) {
      std::swap(visible[i], visible[i + dice.below(static_cast<RecordIndex>(visible.size() - i))]);
      asked.push_back(visible[i] % kRecords);
    }
    if (dice.share() < tour.leave)
      room = dice.below(kRooms);
    else if (dice.share() < tour.go_on)
      room = (room + 1) % kRooms;
  }
  return asked;
}

Payloads::Payloads() : noise_(kNoiseBytes) {
  Dice dice(3);
  for (std::size_t at = 0; at < noise_.size(); at += sizeof(std::uint64_t)) {
    const std::uint64_t bits = dice.bits();
    std::memcpy(&noise_[at], &bits, sizeof bits);
  }
  payload_.reserve(kLargestRecord);
}

std::span<const std::byte> Payloads::make(RecordIndex record, std::uint64_t version,
                                          std::size_t size) {
  constexpr std::size_t kSliceStep =
      4099;  // prime: slices of one record differ from version to version
  const std::size_t first = (record + version * kRecords) * kSliceStep % (noise_.size() - size);
  const std::span<const std::byte> slice = std::span(noise_).subspan(first, size);
  payload_.assign(slice.begin(), slice.end());
  Head head{0, record, version};
  std::memcpy(payload_.data(), &head, sizeof head);
  head.hash = hash_of(payload_);
  std::memcpy(payload_.data(), &head, sizeof head);
  return payload_;
}

bool is_record(std::span<const std::byte> payload, RecordIndex record, std::size_t size) {
  return payload.size() == size && head_of(payload).record == record;
}

bool is_whole(std::span<const std::byte> payload) {
  return head_of(payload).hash == hash_of(payload);
}

}  // namespace atrium
