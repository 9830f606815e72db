#include "scheduler/braid_record.h"

#include <array>

#include "scheduler/record_bytes.h"

namespace atrium {

namespace {

struct Head {
  std::uint32_t source = 0, strands = 0, links = 0, couplings = 0;
  std::uint32_t thin = 0, doubts = 0, verdicts = 0;
};

bool get_braid(RecordIn& in, const Head& head, Braid& b) {
  b.source = ClusterId(head.source);
  return in.get(b.strands, head.strands) && in.get(b.links, head.links) &&
         in.get(b.couplings, head.couplings) && in.get(b.thin, head.thin) &&
         in.get(b.doubts, head.doubts) && in.get(b.verdicts, head.verdicts);
}

}  // namespace

std::uint64_t bytes_of(std::span<const Braid> braids) {
  constexpr std::uint64_t kArrays = 6, kHeapsOwn = 24;  // bytes of the heap's about each
  std::uint64_t bytes = braids.size() * kArrays * kHeapsOwn;
  for (const Braid& b : braids) bytes += b.bytes();
  return bytes;
}

std::vector<std::byte> write_braids(std::span<const Braid> braids) {
  RecordOut out(bytes_of(braids) + sizeof(Head));
  const std::array<std::uint32_t, 1> count{static_cast<std::uint32_t>(braids.size())};
  out.put(std::span<const std::uint32_t>(count));
  for (const Braid& b : braids) {
    const auto n = [](const auto& items) { return static_cast<std::uint32_t>(items.size()); };
    const std::array<Head, 1> head{{{b.source.value, n(b.strands), n(b.links), n(b.couplings),
                                     n(b.thin), n(b.doubts), n(b.verdicts)}}};
    out.put(std::span<const Head>(head));
  }
  for (const Braid& b : braids) {
    out.put(std::span<const Braid::Strand>(b.strands));
    out.put(std::span<const LinkHead>(b.links));
    out.put(std::span<const float>(b.couplings));
    out.put(std::span<const ThinLink>(b.thin));
    out.put(std::span<const Doubt>(b.doubts));
    out.put(std::span<const Verdict>(b.verdicts));
  }
  return out.take();
}

Result<std::vector<Braid>> read_braids(std::span<const std::byte> record) {
  const Status broken(Code::kStore, "", "braid record", "its length is not what it says it holds",
                      "run atrium check on the run");
  RecordIn in(record);
  std::vector<std::uint32_t> count;
  std::vector<Head> heads;
  if (!in.get(count, 1) || !in.get(heads, count[0])) return broken;
  std::vector<Braid> braids(heads.size());
  for (std::size_t i = 0; i < heads.size(); ++i)
    if (!get_braid(in, heads[i], braids[i])) return broken;
  if (!in.empty()) return broken;
  return braids;
}

}  // namespace atrium
