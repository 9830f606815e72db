// Policy: which record leaves the arena next. The live store and the simulator drive the same
// object, so that what one counts the other counts too. A policy hears of every request and every
// release of a record and names the victim; it never sees bytes, and a pinned record never leaves.
//
// Records go by small numbers given out by the caller, from 0 up, so that a policy can keep what it
// knows in plain arrays. The calls of a record's life, in this order:
//
//   on_miss       requested while not in the arena; room is not made yet: look into ghosts here
//   admits        false: this request had better go past the arena (asked right after on_miss)
//   victim,       as often as it takes to make room; each victim named is evicted at once, and
//     on_evict    on_evict hears of it
//   on_insert     in the arena now; pinned
//   on_hit        requested while in the arena; pinned until its next on_release
//   on_foreseen   its next request, after the one just heard of, is known to be number `when`
//   on_resize     its size changed, while pinned
//   on_release    its last pin is gone: may be a victim from now on
//
// A record made by the caller comes in by on_insert and on_release alone; one whose bringing in
// failed after on_miss stays out. A record that is not admitted but has to be in the arena all the
// same (the live store pins what it hands out) is told by on_insert as ever.
// Not thread safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/status.h"

namespace atrium {

using RecordNumber = std::uint32_t;

class Policy {
 public:
  virtual ~Policy() = default;
  virtual void on_miss(RecordNumber, std::uint64_t /*bytes*/) {}
  virtual bool admits(RecordNumber, std::uint64_t /*bytes*/) { return true; }
  virtual void on_insert(RecordNumber record, std::uint64_t bytes) = 0;  // bytes: of the arena
  virtual void on_hit(RecordNumber record) = 0;
  virtual void on_foreseen(RecordNumber, std::uint64_t /*when*/) {}
  virtual void on_resize(RecordNumber record, std::uint64_t bytes) = 0;
  virtual void on_release(RecordNumber record) = 0;
  virtual void on_evict(RecordNumber record) = 0;
  // The record to go next among those that are not pinned; none if all are. `now`: the number of
  // the request that room is made for, counted as `when` is.
  virtual std::optional<RecordNumber> victim(std::uint64_t now) = 0;
};

// A policy as named on the command line: "lru", "lookahead:5000".
struct PolicyChoice {
  std::string name;             // as given
  std::string algorithm;        // a name of policies/table.inc
  std::uint64_t foresight = 0;  // requests ahead that its caller tells of by on_foreseen; kAll: all
  static constexpr std::uint64_t kAll = ~std::uint64_t{0};
};

// kUsage, naming those there are, if there is no such policy.
Result<PolicyChoice> parse_policy(const std::string& name);
// capacity: bytes of the arena.
std::unique_ptr<Policy> make_policy(const PolicyChoice& choice, std::uint64_t capacity);
std::vector<std::string> policy_names();  // as parse_policy takes them; "lookahead:W"

}  // namespace atrium
