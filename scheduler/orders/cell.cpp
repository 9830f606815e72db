// "Cell order schedules clusters by traversing cells of the wall-aligned BSP-tree. Consecutive
// cells are chosen by selecting the neighbor cell whose intervening boundary has the largest
// transparent area." [THFH94 §6] Among those not visited yet; where there is none, the walk goes on
// from the most recent cell that still has one.
//
// Of one cell's clusters, each is followed by the one whose gather reads most nearly the same: a
// corridor's are as far apart as its ends are, and in the modeller's order the arena lost between
// them what the next but one asked for. gen floor, an arena of a third: 95.2 instead of 94.1% hits.
#include <algorithm>
#include <utility>

#include "scheduler/orders/cells.h"

namespace atrium {

namespace {

struct Door {
  std::uint32_t to;
  double area;
};

std::vector<std::vector<Door>> doors_of(const Model& model) {
  std::vector<std::vector<Door>> doors(model.cells.size());
  for (const Portal& p : model.portals) {
    doors[p.a.value].push_back({p.b.value, p.area});
    doors[p.b.value].push_back({p.a.value, p.area});
  }
  for (std::vector<Door>& d : doors)
    std::stable_sort(d.begin(), d.end(),
                     [](const Door& a, const Door& b) { return a.area > b.area; });
  return doors;
}

// Gathers to what is left of a cell's clusters.
class CellByCell {
 public:
  explicit CellByCell(const GatherSets& gathers) : gathers_(gathers), left_(gathers.size(), 1) {}

  void gather_to(std::span<const ClusterId> clusters) {
    std::vector<ClusterId> left;
    for (const ClusterId c : clusters)
      if (left_[c.value]) left.push_back(c);
    while (!left.empty()) {
      const auto next = nearest(left);
      left_[next->value] = 0;
      sequence_.push_back(*next);
      left.erase(next);
    }
  }
  Sequence sequence() && { return std::move(sequence_); }

 private:
  // To the last gather.
  std::vector<ClusterId>::iterator nearest(std::vector<ClusterId>& left) const {
    if (sequence_.empty()) return left.begin();
    return std::ranges::min_element(left, {}, [&](ClusterId c) {
      return distance(gathers_, sequence_.back().value, c.value);
    });
  }

  const GatherSets& gathers_;
  std::vector<char> left_;
  Sequence sequence_;
};

}  // namespace

CellWalk walk_cells(const Model& model) {
  const std::vector<std::vector<Door>> doors = doors_of(model);
  std::vector<char> seen(model.cells.size(), 0);
  CellWalk walk;
  std::vector<CellId> path;
  const auto enter = [&](CellId cell) {
    seen[cell.value] = 1;
    walk.entered.push_back(cell);
    path.push_back(cell);
  };
  for (std::size_t start = 0; start < seen.size(); ++start) {
    if (seen[start] || !model.cells[start].lit) continue;
    enter(CellId(start));
    while (!path.empty()) {
      const auto& here = doors[path.back().value];
      const auto next =
          std::find_if(here.begin(), here.end(), [&](const Door& d) { return !seen[d.to]; });
      if (next != here.end()) {
        enter(CellId(next->to));
        continue;
      }
      walk.left.push_back(path.back());
      path.pop_back();
    }
  }
  return walk;
}

Sequence cell_by_cell(const Model& model, const GatherSets& gathers,
                      std::span<const CellId> cells) {
  std::vector<std::vector<ClusterId>> in_cell(model.cells.size());
  std::vector<ClusterId> all;
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    all.push_back(ClusterId(c));
    for (const CellId cell : model.cells_of_cluster[c]) in_cell[cell.value].push_back(ClusterId(c));
  }
  CellByCell gather(gathers);
  for (const CellId cell : cells) gather.gather_to(in_cell[cell.value]);
  gather.gather_to(all);  // what borders no lit cell
  return std::move(gather).sequence();
}

Sequence cell_order(const OrderTask& task) {
  constexpr bool kWithNeighbors = false;  // only those of a cell are compared
  return cell_by_cell(task.model, find_gather_sets(task.model, kWithNeighbors),
                      walk_cells(task.model).entered);
}

}  // namespace atrium
