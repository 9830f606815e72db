#include "scheduler/braid_record.h"

#include <array>
#include <cstring>

namespace atrium {

namespace {

struct Head {
  std::uint32_t source = 0, strands = 0, links = 0, couplings = 0, thin = 0, doubts = 0;
};

class Out {
 public:
  explicit Out(std::size_t bytes) { bytes_.reserve(bytes); }
  template <class T>
  void put(std::span<const T> items) {
    const auto bytes = std::as_bytes(items);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class In {
 public:
  explicit In(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  bool get(std::vector<T>& items, std::size_t count) {
    if (count > bytes_.size() / sizeof(T)) return false;
    items.resize(count);
    if (count > 0) std::memcpy(items.data(), bytes_.data(), count * sizeof(T));
    bytes_ = bytes_.subspan(count * sizeof(T));
    return true;
  }
  bool empty() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

bool get_braid(In& in, const Head& head, Braid& b) {
  b.source = ClusterId(head.source);
  return in.get(b.strands, head.strands) && in.get(b.links, head.links) &&
         in.get(b.couplings, head.couplings) && in.get(b.thin, head.thin) &&
         in.get(b.doubts, head.doubts);
}

}  // namespace

std::uint64_t bytes_of(std::span<const Braid> braids) {
  std::uint64_t bytes = 0;
  for (const Braid& b : braids) bytes += b.bytes();
  return bytes;
}

std::vector<std::byte> write_braids(std::span<const Braid> braids) {
  Out out(bytes_of(braids) + sizeof(Head));
  const std::array<std::uint32_t, 1> count{static_cast<std::uint32_t>(braids.size())};
  out.put(std::span<const std::uint32_t>(count));
  for (const Braid& b : braids) {
    const auto n = [](const auto& items) { return static_cast<std::uint32_t>(items.size()); };
    const std::array<Head, 1> head{{{b.source.value, n(b.strands), n(b.links), n(b.couplings),
                                     n(b.thin), n(b.doubts)}}};
    out.put(std::span<const Head>(head));
  }
  for (const Braid& b : braids) {
    out.put(std::span<const Braid::Strand>(b.strands));
    out.put(std::span<const LinkHead>(b.links));
    out.put(std::span<const float>(b.couplings));
    out.put(std::span<const ThinLink>(b.thin));
    out.put(std::span<const Doubt>(b.doubts));
  }
  return out.take();
}

Result<std::vector<Braid>> read_braids(std::span<const std::byte> record) {
  const Status broken(Code::kStore, "", "braid record", "its length is not what it says it holds",
                      "run atrium check on the run");
  In in(record);
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
