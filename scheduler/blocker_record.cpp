#include "scheduler/blocker_record.h"

#include <cstring>

namespace atrium {

namespace {

struct Head {
  std::uint32_t polygons = 0, vertices = 0;
};
struct Entry {
  std::uint32_t patch = 0, vertex_count = 0;
};

}  // namespace

std::vector<std::byte> write_blockers(const Model& model, const Cluster& cluster) {
  Head head{cluster.patch_count, 0};
  for (std::uint32_t i = 0; i < cluster.patch_count; ++i)
    head.vertices += model.patches[cluster.first_patch + i].vertex_count;
  std::vector<std::byte> out(sizeof(Head) + head.polygons * sizeof(Entry) +
                             head.vertices * sizeof(Vec3));
  std::memcpy(out.data(), &head, sizeof head);
  std::byte* entries = out.data() + sizeof head;
  std::byte* vertices = entries + head.polygons * sizeof(Entry);
  for (std::uint32_t i = 0; i < cluster.patch_count; ++i) {
    const std::uint32_t id = cluster.first_patch + i;
    const PolygonView polygon = model.polygon(model.patches[id]);
    const Entry entry{id, static_cast<std::uint32_t>(polygon.size())};
    std::memcpy(entries, &entry, sizeof entry);
    entries += sizeof entry;
    std::memcpy(vertices, polygon.data(), polygon.size_bytes());
    vertices += polygon.size_bytes();
  }
  return out;
}

Status append_blockers(std::span<const std::byte> record, BlockerSet& set) {
  const auto broken = [] {
    return Status(Code::kStore, "", "blocker record", "shorter than what it says it holds",
                  "run atrium check on the run");
  };
  Head head;
  if (record.size() < sizeof head) return broken();
  std::memcpy(&head, record.data(), sizeof head);
  const std::size_t entries = std::size_t(head.polygons) * sizeof(Entry);
  const std::size_t vertices = std::size_t(head.vertices) * sizeof(Vec3);
  if (record.size() < sizeof head + entries + vertices) return broken();
  std::uint32_t at = static_cast<std::uint32_t>(set.vertices.size());
  const std::uint32_t end = at + head.vertices;
  for (std::uint32_t i = 0; i < head.polygons; ++i) {
    Entry entry;
    std::memcpy(&entry, record.data() + sizeof head + i * sizeof entry, sizeof entry);
    if (entry.vertex_count > end - at) return broken();
    set.items.push_back({entry.patch, at, entry.vertex_count});
    at += entry.vertex_count;
  }
  set.vertices.resize(end);
  std::memcpy(set.vertices.data() + end - head.vertices, record.data() + sizeof head + entries,
              vertices);
  return {};
}

}  // namespace atrium
