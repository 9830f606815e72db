// Policy: which record leaves the arena next. A policy sees every request and release of a record
// in the arena and names the victim; it never sees bytes, and pinned records never leave.
//
// A record's life, as told to the policy:
//   on_insert            brought in or made; pinned
//   on_hit               requested while in the arena; pinned until the next on_release
//   on_release           its last pin is gone: may be a victim from now on
//   on_resize            its size changed, while pinned
//   on_evict             gone from the arena; it was the victim
// Not thread safe.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/status.h"
#include "pagestore/record.h"

namespace atrium {

class Policy {
 public:
  virtual ~Policy() = default;
  virtual void on_insert(RecordId id, std::size_t bytes) = 0;  // of the arena
  virtual void on_hit(RecordId id) = 0;
  virtual void on_release(RecordId id) = 0;
  virtual void on_resize(RecordId id, std::size_t bytes) = 0;
  virtual void on_evict(RecordId id) = 0;
  // The record to go next among those that are not pinned; none if all are.
  virtual std::optional<RecordId> victim() = 0;
};

// kUsage, naming those there are, if `name` is not in policies/table.inc. capacity: bytes of the
// arena.
Result<std::unique_ptr<Policy>> make_policy(const std::string& name, std::size_t capacity);
std::vector<std::string> policy_names();

}  // namespace atrium
