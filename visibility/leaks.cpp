#include "visibility/leaks.h"

#include <algorithm>
#include <deque>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "engine/disjoint_sets.h"
#include "visibility/box_tree.h"
#include "visibility/contact.h"
#include "visibility/opening.h"

namespace atrium {

namespace {

// What a ball of this size passes is no doorway, but one room; and what is open to the outdoors so
// far, higher than a storey, is outdoors: a hall with large windows is none.
constexpr double kArch = 1.5, kGate = 3;  // m
// A ball of this size finds place in a room: more than a wall or a cupboard is deep.
constexpr double kStanding = 0.8;  // m
// It is tried at this many places along each side of a cell's box.
constexpr int kPlaces = 4;
// A passage belongs to the rooms that are nearest, counted in cells, and to those this much
// further.
constexpr std::uint32_t kFurtherCells = 2;

bool clear_of_surfaces(const Scene& scene, const BoxTree& tree, const Vec3& x, double radius) {
  bool clear = true;
  tree.visit({x - Vec3{radius}, x + Vec3{radius}}, [&](std::uint32_t i) {
    clear = clear && distance_to(scene.polygon(scene.surfaces[i]), x) >= radius;
  });
  return clear;
}

// Does a ball to stand in have its middle somewhere in the cell?
bool holds_standing(const Scene& scene, const BoxTree& tree, const Frame& frame,
                    const ConvexCell& cell) {
  Box box;
  for (const CellFace& face : cell.faces) box.extend(bounds(face.polygon, frame));
  const Vec3 step = box.extent() / double(kPlaces);
  for (int i = 0; i < kPlaces * kPlaces * kPlaces; ++i) {
    const Vec3 place{i % kPlaces + 0.5, i / kPlaces % kPlaces + 0.5, i / kPlaces / kPlaces + 0.5};
    const Vec3 x = frame.to_space(box.lo + place * step);
    const bool inside = std::all_of(cell.faces.begin(), cell.faces.end(),
                                    [&](const CellFace& f) { return f.plane.distance(x) >= 0; });
    if (inside && clear_of_surfaces(scene, tree, x, 0.5 * kStanding)) return true;
  }
  return false;
}

bool is_outer(const ConvexCell& cell) {
  return std::any_of(cell.faces.begin(), cell.faces.end(),
                     [](const CellFace& f) { return f.node == CellFace::kOutside; });
}

// The cells that a ball as high as a storey comes to from the subdivision's rim.
std::vector<bool> find_outdoors(const RoomPlan& plan) {
  const std::size_t cells = plan.bsp.cells.size();
  const std::vector<bool> gate = passable(plan.bsp, plan.portals, plan.groups, kGate);
  std::vector<CellPortal> gates;
  for (std::size_t i = 0; i < plan.portals.size(); ++i)
    if (gate[i]) gates.push_back(plan.portals[i]);
  std::vector<std::uint32_t> outer;
  for (std::uint32_t c = 0; c < cells; ++c)
    if (is_outer(plan.bsp.cells[c])) outer.push_back(c);
  return flood(cells, gates, outer);
}

// Cells that are not outdoors and that air or an arch joins.
DisjointSets join_rooms(const RoomPlan& plan, const std::vector<bool>& outdoors) {
  const std::size_t cells = plan.bsp.cells.size();
  std::vector<bool> indoors(outdoors);
  indoors.flip();
  const Rooms rooms = find_rooms(plan.bsp, plan.portals, indoors);
  DisjointSets sets(cells);
  std::vector<std::uint32_t> first(rooms.count, kNoSpace);
  for (std::uint32_t c = 0; c < cells; ++c) {
    if (outdoors[c]) continue;
    std::uint32_t& of_room = first[rooms.of_cell[c]];
    if (of_room == kNoSpace) of_room = c;
    sets.join(of_room, c);
  }
  const std::vector<bool> arch = passable(plan.bsp, plan.portals, plan.groups, kArch);
  for (std::size_t i = 0; i < plan.portals.size(); ++i) {
    const CellPortal& p = plan.portals[i];
    if (arch[i] && indoors[p.front] && indoors[p.back]) sets.join(p.front, p.back);
  }
  return sets;
}

void number_rooms(const Scene& scene, RoomPlan& plan) {
  const std::vector<bool> outdoors = find_outdoors(plan);
  DisjointSets sets = join_rooms(plan, outdoors);
  const std::size_t cells = plan.bsp.cells.size();
  std::vector<std::uint32_t> number(cells, kNoSpace);  // by set
  const BoxTree tree = surface_tree(scene);
  for (std::size_t c = 0; c < cells; ++c) {
    std::uint32_t& of_set = number[sets.find(c)];
    if (!outdoors[c] && of_set == kNoSpace &&
        holds_standing(scene, tree, plan.bsp.frame, plan.bsp.cells[c]))
      of_set = plan.rooms++;
  }
  for (std::size_t c = 0; c < cells; ++c)
    plan.space_of_cell.push_back(outdoors[c] ? kOutdoors : number[sets.find(c)]);
}

// The rooms that each cell belongs to: its own, or those that it is a passage of; none in a void.
class Belongings {
 public:
  Belongings(const RoomPlan& plan, const std::vector<bool>& wide)
      : plan_(plan),
        beside_(cells_beside(plan.bsp.cells.size(), plan.portals,
                             [&](std::size_t i) { return wide[i]; })),
        rows_(plan.bsp.cells.size()) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> cells_of;
    std::vector<std::uint32_t> all;
    for (std::uint32_t c = 0; c < rows_.size(); ++c) {
      if (plan.space_of_cell[c] == kNoSpace) continue;
      cells_of[plan.space_of_cell[c]].push_back(c);
      all.push_back(c);
    }
    nearest_.assign(rows_.size(), kFar);
    walk(all, [&](std::uint32_t c, std::uint32_t steps) {
      const bool nearer = steps < nearest_[c];
      if (nearer) nearest_[c] = steps;
      return nearer;
    });
    for (const auto& [space, cells] : cells_of) spread(space, cells);
  }

  const std::vector<std::uint32_t>& operator[](std::size_t cell) const { return rows_[cell]; }

 private:
  static constexpr std::uint32_t kFar = ~0u;

  // Breadth first through passages: reach(cell, steps) says whether to go on from there.
  template <class Reach>
  void walk(const std::vector<std::uint32_t>& from, Reach&& reach) const {
    std::deque<std::pair<std::uint32_t, std::uint32_t>> open;
    for (std::uint32_t c : from)
      if (reach(c, 0)) open.emplace_back(c, 0);
    while (!open.empty()) {
      const auto [cell, steps] = open.front();
      open.pop_front();
      for (std::uint32_t next : beside_[cell])
        if (plan_.space_of_cell[next] == kNoSpace && reach(next, steps + 1))
          open.emplace_back(next, steps + 1);
    }
  }

  void spread(std::uint32_t space, const std::vector<std::uint32_t>& cells) {
    walk(cells, [&](std::uint32_t c, std::uint32_t steps) {
      std::vector<std::uint32_t>& row = rows_[c];
      if (steps > nearest_[c] + kFurtherCells || (!row.empty() && row.back() == space))
        return false;
      row.push_back(space);
      return true;
    });
  }

  const RoomPlan& plan_;
  const Rows32 beside_;  // cells, through wide portals
  std::vector<std::uint32_t> nearest_;
  Rows32 rows_;
};

// Voids joined by wide portals, each named by a cell of it.
DisjointSets join_voids(const RoomPlan& plan, const std::vector<bool>& wide,
                        const Belongings& belongings) {
  DisjointSets sets(plan.bsp.cells.size());
  for (std::size_t i = 0; i < plan.portals.size(); ++i) {
    const CellPortal& p = plan.portals[i];
    if (wide[i] && belongings[p.front].empty() && belongings[p.back].empty())
      sets.join(p.front, p.back);
  }
  return sets;
}

// What an opening touches: voids, by name, and the rooms of passages, a row each.
struct Ends {
  std::vector<std::uint32_t> voids;
  Rows32 rooms;
};

Ends ends_of(const NarrowOpening& opening, const RoomPlan& plan, const Belongings& belongings,
             DisjointSets& voids) {
  std::set<std::uint32_t> cells, names;
  for (std::uint32_t p : opening.portals) {
    cells.insert(plan.portals[p].front);
    cells.insert(plan.portals[p].back);
  }
  Ends ends;
  for (std::uint32_t cell : cells)
    if (belongings[cell].empty())
      names.insert(static_cast<std::uint32_t>(voids.find(cell)));
    else
      ends.rooms.push_back(belongings[cell]);
  ends.voids.assign(names.begin(), names.end());
  return ends;
}

// Narrow openings and voids that hang together, with the rooms they lead to. Openings are added
// widest first; one that joins two parts which both lead to rooms is a leak: the narrowest place
// of the widest way between them. [Kruskal 56]
class Network {
 public:
  explicit Network(std::size_t most_parts) : sets_(most_parts), entries_(most_parts) {}

  // Two rooms that the opening joins, if it does; one hole is one leak, however many rooms a post
  // in it parts.
  std::optional<std::array<std::uint32_t, 2>> add(const Ends& ends, const Vec3& at) {
    std::vector<std::size_t> parts;
    for (std::uint32_t name : ends.voids) parts.push_back(part(Kind::kVoid, name));
    for (const auto& row : ends.rooms) {
      for (std::uint32_t space : row) join(room_part(row.front(), at), room_part(space, at));
      parts.push_back(room_part(row.front(), at));
    }
    std::optional<std::array<std::uint32_t, 2>> joined;
    for (std::size_t other : parts) {
      const std::size_t a = sets_.find(parts.front()), b = sets_.find(other);
      if (!joined && a != b && !entries_[a].empty() && !entries_[b].empty())
        joined = {nearest(a, at), nearest(b, at)};
      join(a, b);
    }
    return joined;
  }

 private:
  enum class Kind { kVoid, kRoom };
  struct Entry {
    std::uint32_t space = kNoSpace;
    Vec3 at{0};  // where it was first come to
  };

  std::size_t part(Kind kind, std::uint32_t name) {
    return parts_.try_emplace({kind, name}, parts_.size()).first->second;
  }

  std::size_t room_part(std::uint32_t space, const Vec3& at) {
    const std::size_t before = parts_.size(), found = part(Kind::kRoom, space);
    if (parts_.size() > before) entries_[found].push_back({space, at});
    return found;
  }

  void join(std::size_t i, std::size_t j) {
    const std::size_t a = sets_.find(i), b = sets_.find(j);
    if (a == b) return;
    sets_.join(a, b);
    std::vector<Entry> all = std::move(entries_[a]);
    all.insert(all.end(), entries_[b].begin(), entries_[b].end());
    entries_[b].clear();
    entries_[sets_.find(a)] = std::move(all);
  }

  std::uint32_t nearest(std::size_t of, const Vec3& at) const {
    return std::min_element(entries_[of].begin(), entries_[of].end(),
                            [&](const Entry& a, const Entry& b) {
                              return length(a.at - at) < length(b.at - at);
                            })
        ->space;
  }

  DisjointSets sets_;
  std::map<std::pair<Kind, std::uint32_t>, std::size_t> parts_;
  std::vector<std::vector<Entry>> entries_;  // by the set's name
};

// Openings by the network they are part of, widest first in each.
Rows32 networks(const std::vector<NarrowOpening>& openings, const std::vector<Ends>& ends,
                std::size_t cells) {
  DisjointSets sets(cells + openings.size());
  for (std::size_t i = 0; i < openings.size(); ++i)
    for (std::uint32_t name : ends[i].voids) sets.join(name, cells + i);
  std::vector<std::uint32_t> order(openings.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return openings[a].width > openings[b].width;
  });
  std::map<std::size_t, std::vector<std::uint32_t>> found;
  for (std::uint32_t i : order) found[sets.find(cells + i)].push_back(i);
  Rows32 rows;
  for (auto& [name, row] : found) rows.push_back(std::move(row));
  return rows;
}

std::size_t most_parts(const std::vector<std::uint32_t>& network, const std::vector<Ends>& ends) {
  std::size_t most = 0;
  for (std::uint32_t i : network) {
    most += ends[i].voids.size();
    for (const auto& row : ends[i].rooms) most += row.size();
  }
  return most;
}

}  // namespace

RoomPlan find_room_plan(const Scene& scene) {
  RoomPlan plan;
  plan.bsp = build_bsp(scene);
  plan.portals = find_portals(plan.bsp);
  plan.groups = group_portals(plan.bsp, plan.portals);
  number_rooms(scene, plan);
  return plan;
}

std::vector<Leak> find_leaks(const Scene& scene, const RoomPlan& plan, double size) {
  const Openings openings = find_openings(plan.bsp, plan.portals, plan.groups, size);
  const Belongings belongings(plan, openings.wide);
  DisjointSets voids = join_voids(plan, openings.wide, belongings);
  std::vector<Ends> ends;
  for (const NarrowOpening& opening : openings.narrow)
    ends.push_back(ends_of(opening, plan, belongings, voids));
  const BoxTree tree = surface_tree(scene);
  std::vector<Leak> leaks;
  for (const auto& row : networks(openings.narrow, ends, plan.bsp.cells.size())) {
    Network network(most_parts(row, ends));
    for (std::uint32_t i : row) {
      const NarrowOpening& opening = openings.narrow[i];
      const auto rooms = network.add(ends[i], opening.widest);
      if (!rooms) continue;
      leaks.push_back({opening.width,
                       opening.length,
                       {std::min((*rooms)[0], (*rooms)[1]), std::max((*rooms)[0], (*rooms)[1])},
                       objects_around(scene, tree, opening),
                       opening.widest,
                       opening.along});
    }
  }
  std::stable_sort(leaks.begin(), leaks.end(),
                   [](const Leak& a, const Leak& b) { return a.width > b.width; });
  return leaks;
}

}  // namespace atrium
