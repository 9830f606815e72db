#include "engine/cluster_record.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace atrium {

namespace {

// Cuts typed sections off a run of bytes, front to back.
class Sections {
 public:
  explicit Sections(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  std::span<const T> take(std::size_t count) {
    const std::size_t size = count * sizeof(T);
    if (size > bytes_.size()) {
      ok_ = false;
      return {};
    }
    std::span<const T> section(reinterpret_cast<const T*>(bytes_.data()), count);
    bytes_ = bytes_.subspan(size);
    return section;
  }
  bool ok() const { return ok_; }

 private:
  std::span<const std::byte> bytes_;
  bool ok_ = true;
};

struct Counts {
  std::size_t elements = 0, vertices = 0, contacts = 0;
};

Counts count(std::span<const PatchTree> trees) {
  Counts c;
  for (const PatchTree& t : trees) {
    c.elements += t.elements.size();
    c.vertices += t.vertices.size();
    c.contacts += t.contacts.size();
  }
  return c;
}

std::size_t bytes_of_element(int order) {
  return sizeof(Element) +
         sizeof(double) * (coefficient_count(order) * kChannels + triangle_count(order));
}

class Writer {
 public:
  explicit Writer(std::span<std::byte> out) : out_(out) {}
  template <class T>
  void put(std::span<const T> items) {
    const std::size_t size = items.size_bytes();
    ATRIUM_CHECK(size <= out_.size());
    if (size > 0) std::memcpy(out_.data(), items.data(), size);
    out_ = out_.subspan(size);
  }
  bool full() const { return out_.empty(); }

 private:
  std::span<std::byte> out_;
};

// Do groups hold groups that come after them, and members and patches that there are?
bool whole(const GroupView& v, std::size_t patches) {
  for (std::size_t i = 0; i < v.groups.size(); ++i) {
    const FaceGroup& g = v.groups[i];
    if (g.member_count < 2 || std::size_t(g.first_member) + g.member_count > v.members.size())
      return false;
    for (const std::int32_t c : g.child)
      if (c < 0 ? std::size_t(~c) >= patches
                : std::size_t(c) <= i || std::size_t(c) >= v.groups.size())
        return false;
  }
  return std::ranges::all_of(v.members,
                             [&](const GroupMember& m) { return m.patch < patches; });
}

template <class T>
std::vector<T> copy(std::span<const T> s) {
  return std::vector<T>(s.begin(), s.end());
}

}  // namespace

std::size_t PatchTree::bytes() const {
  return sizeof(PatchHead) + elements.size() * bytes_of_element(order) +
         vertices.size() * sizeof(Vec2) + contacts.size() * sizeof(Segment2);
}

Result<ClusterView> ClusterView::parse(std::span<const std::byte> bytes) {
  const auto broken = [](const char* what) {
    return Status(Code::kStore, "", "cluster record", what, "run atrium check on the run");
  };
  if (reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(double) != 0)
    return broken("not aligned");
  Sections sections(bytes);
  ClusterView v;
  std::span<const ClusterHead> head = sections.take<ClusterHead>(1);
  if (!sections.ok()) return broken("shorter than its head");
  v.head_ = &head[0];
  const ClusterHead& h = head[0];
  if (h.order < 1 || h.order > kMaxOrder) return broken("basis order out of range");
  const int order = static_cast<int>(h.order);
  v.patches_ = sections.take<PatchHead>(h.patches);
  v.elements_ = sections.take<Element>(h.elements);
  v.vertices_ = sections.take<Vec2>(h.vertices);
  v.contacts_ = sections.take<Segment2>(h.contacts);
  v.e_ = sections.take<double>(std::size_t(h.elements) * coefficient_count(order) * kChannels);
  v.basis_ = sections.take<double>(std::size_t(h.elements) * triangle_count(order));
  v.groups_ = sections.take<FaceGroup>(h.groups);
  v.members_ = sections.take<GroupMember>(h.members);
  if (!sections.ok()) return broken("shorter than its sections");
  for (const PatchHead& p : v.patches_)
    if (std::size_t(p.first_element) + p.element_count > h.elements ||
        std::size_t(p.first_vertex) + p.vertex_count > h.vertices ||
        std::size_t(p.first_contact) + p.contact_count > h.contacts || p.element_count == 0)
      return broken("a patch reaches out of it");
  if (!whole(v.groups(), h.patches)) return broken("a group reaches out of it");
  return v;
}

PatchView ClusterView::patch(std::size_t p) const {
  const PatchHead& h = patches_[p];
  const int order = static_cast<int>(head_->order);
  const std::size_t k = coefficient_count(order) * kChannels, t = triangle_count(order);
  return {&h,
          elements_.subspan(h.first_element, h.element_count),
          vertices_.subspan(h.first_vertex, h.vertex_count),
          e_.subspan(h.first_element * k, h.element_count * k),
          basis_.subspan(h.first_element * t, h.element_count * t),
          order};
}

std::span<const Segment2> ClusterView::contacts(std::size_t p) const {
  return contacts_.subspan(patches_[p].first_contact, patches_[p].contact_count);
}

std::size_t record_bytes(std::span<const PatchTree> trees, const GroupTree& groups) {
  std::size_t bytes = sizeof(ClusterHead) + groups.bytes();
  for (const PatchTree& t : trees) bytes += t.bytes();
  return bytes;
}

void write_record(std::uint32_t cluster, std::span<PatchTree> trees, std::span<std::byte> out,
                  const GroupTree& groups) {
  const Counts total = count(trees);
  ClusterHead head;
  head.cluster = cluster;
  head.order = static_cast<std::uint32_t>(trees.empty() ? 1 : trees[0].order);
  head.patches = static_cast<std::uint32_t>(trees.size());
  head.elements = static_cast<std::uint32_t>(total.elements);
  head.vertices = static_cast<std::uint32_t>(total.vertices);
  head.contacts = static_cast<std::uint32_t>(total.contacts);
  head.groups = static_cast<std::uint32_t>(groups.groups.size());
  head.members = static_cast<std::uint32_t>(groups.members.size());
  Counts at;
  for (PatchTree& t : trees) {
    t.head.first_element = static_cast<std::uint32_t>(at.elements);
    t.head.element_count = static_cast<std::uint32_t>(t.elements.size());
    t.head.first_vertex = static_cast<std::uint32_t>(at.vertices);
    t.head.vertex_count = static_cast<std::uint32_t>(t.vertices.size());
    t.head.first_contact = static_cast<std::uint32_t>(at.contacts);
    t.head.contact_count = static_cast<std::uint32_t>(t.contacts.size());
    at.elements += t.elements.size();
    at.vertices += t.vertices.size();
    at.contacts += t.contacts.size();
    const Element& root = t.elements[0];
    for (std::uint32_t i = 0; i < root.vertex_count; ++i)
      head.bounds.extend(t.head.frame.to_space(t.vertices[root.first_vertex + i]));
  }
  Writer w(out);
  w.put(std::span<const ClusterHead>(&head, 1));
  for (const PatchTree& t : trees) w.put(std::span<const PatchHead>(&t.head, 1));
  for (const PatchTree& t : trees) w.put(std::span<const Element>(t.elements));
  for (const PatchTree& t : trees) w.put(std::span<const Vec2>(t.vertices));
  for (const PatchTree& t : trees) w.put(std::span<const Segment2>(t.contacts));
  for (const PatchTree& t : trees) w.put(std::span<const double>(t.e));
  for (const PatchTree& t : trees) w.put(std::span<const double>(t.basis));
  w.put(std::span<const FaceGroup>(groups.groups));
  w.put(std::span<const GroupMember>(groups.members));
  ATRIUM_CHECK(w.full());
}

std::vector<PatchTree> read_record(const ClusterView& view) {
  std::vector<PatchTree> trees(view.size());
  for (std::size_t p = 0; p < trees.size(); ++p) {
    const PatchView v = view.patch(p);
    trees[p] = {*v.head,       v.order,
                copy(v.elements), copy(v.vertices), copy(view.contacts(p)), copy(v.e), copy(v.basis)};
  }
  return trees;
}

GroupTree read_groups(const ClusterView& view) {
  return {copy(view.groups().groups), copy(view.groups().members)};
}

}  // namespace atrium
