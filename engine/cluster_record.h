// The record of a cluster: what is read, gathered to and written back. One flat run of bytes, used
// in place where the arena holds it; the layout byte by byte is in pagestore/FORMAT.md.
//
//   ClusterHead | PatchHead × patches | Element × elements | vertices | contacts |
//   E: double[elements][K][3] | basis: double[elements][T] |
//   FaceGroup × groups | GroupMember × members
//
// Invariants:
//  1. A patch's elements, vertices and contacts are contiguous; indices inside are patch-local.
//  2. Element 0 of a patch is its root; children stand behind their parent, in pairs.
//  3. What groups hold of light is of the elements beside them (solver/face_groups.h).
//  4. A view never outlives the pin of the record it looks at.
// Views are read-only and may be shared by threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/element.h"
#include "engine/face_group.h"
#include "engine/geometry.h"
#include "engine/status.h"

namespace atrium {

struct ClusterHead {
  std::uint32_t cluster = 0;
  std::uint32_t order = 0;  // of the basis
  std::uint32_t patches = 0, elements = 0, vertices = 0, contacts = 0;
  std::uint32_t groups = 0, members = 0;
  Box bounds;
};
static_assert(std::is_trivially_copyable_v<ClusterHead> && sizeof(ClusterHead) == 80);

// One patch's tree, wherever it lives: in a pinned record or in a working set.
struct PatchView {
  const PatchHead* head = nullptr;
  std::span<const Element> elements;
  std::span<const Vec2> vertices;
  std::span<const double> e;      // elements × K × 3: irradiance, lm/m²
  std::span<const double> basis;  // elements × T
  int order = 1;

  int k() const { return coefficient_count(order); }
  std::span<const double> e_of(std::size_t i) const {
    return e.subspan(i * k() * kChannels, k() * kChannels);
  }
  std::span<const double> basis_of(std::size_t i) const {
    return basis.subspan(i * triangle_count(order), triangle_count(order));
  }
  std::span<const Vec2> polygon(const Element& x) const {
    return vertices.subspan(x.first_vertex, x.vertex_count);
  }
  Vec3 point(const Vec2& p) const { return head->frame.to_space(p); }
};

// A patch's tree taken out of its record: it can grow.
struct PatchTree {
  PatchHead head;
  int order = 1;
  std::vector<Element> elements;
  std::vector<Vec2> vertices;
  std::vector<Segment2> contacts;
  std::vector<double> e;
  std::vector<double> basis;

  PatchView view() const { return {&head, elements, vertices, e, basis, order}; }
  std::size_t bytes() const;  // in a record
};

class ClusterView {
 public:
  // Checks that the sections fit the bytes; `bytes` must be aligned to 8.
  static Result<ClusterView> parse(std::span<const std::byte> bytes);

  const ClusterHead& head() const { return *head_; }
  std::size_t size() const { return head_->patches; }
  const PatchHead& patch_head(std::size_t p) const { return patches_[p]; }
  PatchView patch(std::size_t p) const;
  std::span<const Segment2> contacts(std::size_t p) const;
  GroupView groups() const { return {groups_, members_}; }

 private:
  const ClusterHead* head_ = nullptr;
  std::span<const PatchHead> patches_;
  std::span<const Element> elements_;
  std::span<const Vec2> vertices_;
  std::span<const Segment2> contacts_;
  std::span<const double> e_, basis_;
  std::span<const FaceGroup> groups_;
  std::span<const GroupMember> members_;
};

// Bytes of a record with these trees and groups.
std::size_t record_bytes(std::span<const PatchTree> trees, const GroupTree& groups = {});
// Writes the record; `out` has record_bytes bytes. Sets the trees' first_* and counts.
void write_record(std::uint32_t cluster, std::span<PatchTree> trees, std::span<std::byte> out,
                  const GroupTree& groups = {});
// Takes the trees out of a record: the inverse of write_record.
std::vector<PatchTree> read_record(const ClusterView& view);
GroupTree read_groups(const ClusterView& view);

}  // namespace atrium
