#include "scheduler/order.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace atrium {

namespace {

using Sequence = std::vector<ClusterId>;

// "Model order gathers to clusters in the order in which they were instantiated by the modeler."
Sequence model_order(const Model& model, std::uint64_t) {
  Sequence s;
  for (std::size_t c = 0; c < model.clusters.size(); ++c) s.push_back(ClusterId(c));
  return s;
}

std::uint64_t split_mix(std::uint64_t& state) {  // [Steele, Lea, Flood 2014]
  std::uint64_t z = state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

Sequence random_order(const Model& model, std::uint64_t seed) {
  Sequence s = model_order(model, seed);
  std::uint64_t state = seed;
  for (std::size_t i = s.size(); i > 1; --i) std::swap(s[i - 1], s[split_mix(state) % i]);
  return s;
}

double distance2(const Box& a, const Box& b) {
  const Vec3 d = a.center() - b.center();
  return dot(d, d);
}

// "Source order gathers to that cluster which has most often acted as a source (ties are broken by
// proximity to the most recent gatherer)."
Sequence source_order(const Model& model, std::uint64_t) {
  const std::size_t n = model.clusters.size();
  std::vector<std::uint32_t> acted(n, 0);
  std::vector<char> done(n, 0);
  Sequence s;
  std::size_t last = 0;
  for (std::size_t step = 0; step < n; ++step) {
    std::size_t best = n;
    double best_distance = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < n; ++c) {
      if (done[c] || (best < n && acted[c] < acted[best])) continue;
      const double d = distance2(model.clusters[c].bounds, model.clusters[last].bounds);
      if (best == n || acted[c] > acted[best] || d < best_distance) {
        best = c;
        best_distance = d;
      }
    }
    done[best] = 1;
    s.push_back(ClusterId(best));
    for (const ClusterId source : model.visible[best]) ++acted[source.value];
    last = best;
  }
  return s;
}

// "Consecutive cells are chosen by selecting the neighbor cell whose intervening boundary has the
// largest transparent area", among those not visited yet; where there is none, the walk goes on
// from the most recent cell that still has one.
std::vector<CellId> walk_cells(const Model& model) {
  const std::size_t n = model.cells.size();
  struct Door {
    std::uint32_t to;
    double area;
  };
  std::vector<std::vector<Door>> doors(n);
  for (const Portal& p : model.portals) {
    doors[p.a.value].push_back({p.b.value, p.area});
    doors[p.b.value].push_back({p.a.value, p.area});
  }
  for (std::vector<Door>& d : doors)
    std::stable_sort(d.begin(), d.end(),
                     [](const Door& a, const Door& b) { return a.area > b.area; });
  std::vector<char> seen(n, 0);
  std::vector<CellId> walk;
  for (std::size_t start = 0; start < n; ++start) {
    if (seen[start] || !model.cells[start].lit) continue;
    std::vector<std::uint32_t> path{std::uint32_t(start)};
    seen[start] = 1;
    walk.push_back(CellId(start));
    while (!path.empty()) {
      const auto& here = doors[path.back()];
      const auto next =
          std::find_if(here.begin(), here.end(), [&](const Door& d) { return !seen[d.to]; });
      if (next == here.end()) {
        path.pop_back();
        continue;
      }
      seen[next->to] = 1;
      walk.push_back(CellId(next->to));
      path.push_back(next->to);
    }
  }
  return walk;
}

// "Cell order schedules clusters by traversing cells of the wall-aligned BSP-tree."
Sequence cell_order(const Model& model, std::uint64_t) {
  std::vector<std::vector<ClusterId>> in_cell(model.cells.size());
  for (std::size_t c = 0; c < model.clusters.size(); ++c)
    for (const CellId cell : model.cells_of_cluster[c]) in_cell[cell.value].push_back(ClusterId(c));
  std::vector<char> done(model.clusters.size(), 0);
  Sequence s;
  const auto take = [&](ClusterId c) {
    if (done[c.value]) return;
    done[c.value] = 1;
    s.push_back(c);
  };
  for (const CellId cell : walk_cells(model))
    for (const ClusterId c : in_cell[cell.value]) take(c);
  for (const ClusterId c : model_order(model, 0)) take(c);
  return s;
}

struct Named {
  const char* name;
  Sequence (*make)(const Model&, std::uint64_t seed);
};
constexpr std::array<Named, 4> kOrders{{{"random", random_order},
                                        {"model", model_order},
                                        {"source", source_order},
                                        {"cell", cell_order}}};

}  // namespace

std::vector<std::string> order_names() {
  std::vector<std::string> names;
  for (const Named& o : kOrders) names.push_back(o.name);
  return names;
}

Result<std::vector<ClusterId>> make_order(const std::string& name, const Model& model,
                                          std::uint64_t seed) {
  for (const Named& o : kOrders)
    if (name == o.name) return o.make(model, seed);
  std::string known;
  for (const Named& o : kOrders) known += std::string(known.empty() ? "" : ", ") + o.name;
  return Status(Code::kUsage, "", "--order " + name, "unknown order", "use one of: " + known);
}

}  // namespace atrium
