#include "visibility/tube.h"

#include <algorithm>
#include <cmath>

namespace atrium {

namespace {

Tube settled(Variety variety) {
  Tube tube;
  tube.decided = true;
  tube.known = variety;
  return tube;
}

// The tube with this list, nothing if it had too many.
Tube with_list(std::optional<std::size_t> found, Tube tube) {
  tube.crowded = !found;
  tube.count = static_cast<std::uint8_t>(found.value_or(0));
  tube.decided = tube.crowded || tube.count == 0;
  tube.known = found == std::size_t{0} ? Variety::VISIBLE : Variety::PARTIAL;
  return tube;
}

}  // namespace

Tube make_tube(const Shaft& shaft, const BlockerIndex& index) {
  if (shaft.closed) return settled(Variety::INVISIBLE);
  Tube tube;
  const auto found = index.collect(shaft, tube.blockers);
  return with_list(found, tube);
}

Tube make_tube(const PolygonPair& ends, const BlockerIndex& index, double tolerance) {
  return make_tube(make_shaft(ends.p, ends.p_normal, ends.q, ends.q_normal, tolerance), index);
}

Tube undrawn(const Tube* parent) {
  Tube tube = parent ? *parent : with_list(std::nullopt, {});
  tube.decided = true;
  tube.known = Variety::PARTIAL;
  return tube;
}

Tube subdivide(const Tube& parent, const Shaft& child, const BlockerIndex& index) {
  if (inherits(parent)) return settled(parent.known);
  if (parent.crowded) return make_tube(child, index);
  if (child.closed) return settled(Variety::INVISIBLE);
  Tube tube;
  std::size_t found = 0;
  for (const std::uint32_t position : parent.list())
    if (may_block(child, index.blockers()[position].polygon)) tube.blockers[found++] = position;
  return with_list(found, tube);
}

Tube subdivide(const Tube& parent, const PolygonPair& child, const BlockerIndex& index,
               double tolerance) {
  if (inherits(parent)) return settled(parent.known);
  return subdivide(parent, make_shaft(child.p, child.p_normal, child.q, child.q_normal, tolerance),
                   index);
}

namespace {

// Do some of the list, all in one plane, hide p from q together? Each plane is asked about once, by
// the first blocker in it.
bool coplanar_block_all(std::span<const std::uint32_t> list, const PolygonPair& ends,
                        const BlockerIndex& index, double tolerance) {
  std::array<Plane, Tube::kCapacity> planes;
  std::array<bool, Tube::kCapacity> done{};
  for (std::size_t i = 0; i < list.size(); ++i) {
    planes[i] = plane_of(index.blockers()[list[i]].polygon);
    done[i] = !separates(planes[i], ends.p, ends.q, tolerance);
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (done[i]) continue;
    std::array<PolygonView, Tube::kCapacity> group;
    std::size_t count = 0;
    for (std::size_t j = i; j < list.size(); ++j) {
      const PolygonView other = index.blockers()[list[j]].polygon;
      const bool coplanar = !done[j] && std::all_of(other.begin(), other.end(), [&](const Vec3& x) {
        return std::abs(planes[i].distance(x)) <= tolerance;
      });
      if (!coplanar) continue;
      done[j] = true;
      group[count++] = other;
    }
    if (count > 1 && block_all_together(ends.p, ends.q, std::span(group).first(count), tolerance))
      return true;
  }
  return false;
}

}  // namespace

Variety variety(Tube& tube, const PolygonPair& ends, const BlockerIndex& index, double tolerance) {
  if (tube.decided) return tube.known;
  const auto list = tube.list();
  const bool by_one = std::any_of(list.begin(), list.end(), [&](std::uint32_t position) {
    return blocks_all(ends.p, ends.q, index.blockers()[position].polygon, tolerance);
  });
  const bool hidden = by_one || coplanar_block_all(list, ends, index, tolerance);
  tube.decided = true;
  tube.known = hidden ? Variety::INVISIBLE : Variety::PARTIAL;
  return tube.known;
}

}  // namespace atrium
