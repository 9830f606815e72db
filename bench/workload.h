// What the benchmark of stores keeps and asks for: records of 8 to 400 KiB, two orders of reading
// them, and payloads that show by themselves whether they are whole. The same on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atrium {

using RecordIndex = std::uint32_t;

inline constexpr RecordIndex kRecords = 20'000;
inline constexpr std::size_t kReads = 40'000;
inline constexpr std::size_t kArenaBytes = std::size_t{80} << 20;  // what each contender may cache
inline constexpr std::size_t kLargestRecord = std::size_t{400} << 10;

// Bytes of each record; log-uniform, 2.05 GB in all.
const std::vector<std::size_t>& record_sizes();

// The requests. A: much jumping about, like random order of gathers; B: little, like model order.
// Gathers follow each other through rooms; each reads some of what its room sees.
enum class Order { kA, kB };
std::vector<RecordIndex> requests(Order order);

// Makes payloads of records. What it returns is good until the next call.
class Payloads {
 public:
  Payloads();
  std::span<const std::byte> make(RecordIndex record, std::uint64_t version, std::size_t size);

 private:
  std::vector<std::byte> noise_, payload_;
};

// Is this `record`, of this size? Looks at its head only.
bool is_record(std::span<const std::byte> payload, RecordIndex record, std::size_t size);
// Is it whole? By XXH3 of all of it, as the page store does when it brings a record in.
bool is_whole(std::span<const std::byte> payload);

}  // namespace atrium
