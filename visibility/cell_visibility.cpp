#include "visibility/cell_visibility.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "visibility/shaft.h"

namespace atrium {

namespace {
// Windows that all flows together may look at; each has its share of them before it is only
// flooded. A count, not a clock: the same on every machine.
constexpr std::size_t kMostSteps = 2'000'000'000;
constexpr std::size_t kLeastSteps = 1000;
// The same of pairs, of which each has its cluster's share of these left, and the limit of each. A
// pair that comes to its limit counts as seeing each other.
constexpr std::size_t kMostPairSteps = 50'000'000;
constexpr std::size_t kStepsOfPair = 256;
}  // namespace

// Scratch of one thread: a flow, and the clusters found so far, each once.
struct CellVisibility::Worker {
  Worker(const PortalGraph& graph, std::size_t clusters) : flow(graph), found_in(clusters, 0) {}

  void begin() {
    ++run;
    found.clear();
  }
  bool has(std::uint32_t cluster) const { return found_in[cluster] == run; }
  void add(std::uint32_t cluster) {
    if (has(cluster)) return;
    found_in[cluster] = run;
    found.push_back(cluster);
  }

  PortalFlow flow;
  std::uint32_t run = 0;
  std::vector<std::uint32_t> found_in;
  std::vector<std::uint32_t> found;
};

CellVisibility::CellVisibility(const PortalGraph& graph, const Frame& frame,
                               std::vector<ClusterInCell> places, std::size_t clusters)
    : graph_(graph),
      frame_(frame),
      places_(std::move(places)),
      places_in_(graph.cells()),
      places_of_(clusters) {
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    places_in_[places_[i].cell].push_back(i);
    places_of_[places_[i].cluster].push_back(i);
  }
}

bool CellVisibility::seen(const ClusterInCell& place, std::span<const Plane> planes) const {
  const Vec3 c = place.box.center(), half = 0.5 * place.box.extent();
  const Vec3 center = frame_.origin + c.x * frame_.u + c.y * frame_.v + c.z * frame_.n;
  return std::all_of(planes.begin(), planes.end(), [&](const Plane& plane) {
    const double reach = half.x * std::abs(dot(plane.normal, frame_.u)) +
                         half.y * std::abs(dot(plane.normal, frame_.v)) +
                         half.z * std::abs(dot(plane.normal, frame_.n));
    return plane.distance(center) + reach > graph_.tolerance;
  });
}

// All that is seen from the cluster's places.
void CellVisibility::collect(std::uint32_t cluster, Worker& worker) const {
  const std::size_t steps = std::max(kLeastSteps, kMostSteps / places_.size());
  for (std::uint32_t from : places_of_[cluster]) {
    const ClusterInCell& place = places_[from];
    for (std::uint32_t i : places_in_[place.cell]) worker.add(places_[i].cluster);
    worker.flow.run(corners_of(frame_, place.box, graph_.tolerance), place.cell, steps);
    worker.flow.each_seen([&](const SeenSpace& space) {
      for (std::uint32_t i : places_in_[space.cell])
        if (!worker.has(places_[i].cluster) && seen(places_[i], space.planes))
          worker.add(places_[i].cluster);
    });
  }
}

PairRows CellVisibility::seen_pairs() const {
  const std::size_t n = places_of_.size();
  tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(graph_, n); });
  PairRows rows(n);
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t c) {
    Worker& worker = workers.local();
    worker.begin();
    collect(static_cast<std::uint32_t>(c), worker);
    std::sort(worker.found.begin(), worker.found.end());
    rows[c].assign(worker.found.begin(), worker.found.end());
  });
  // Sight goes both ways: a pair that one of the two does not see is none.
  PairRows pairs(n);
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t c) {
    const auto self = static_cast<std::uint32_t>(c);
    const auto later = std::lower_bound(rows[c].begin(), rows[c].end(), self);
    std::copy_if(later, rows[c].end(), std::back_inserter(pairs[c]), [&](std::uint32_t d) {
      return std::binary_search(rows[d].begin(), rows[d].end(), self);
    });
  });
  return pairs;
}

// In the frame both are boxes along the axes.
std::vector<Plane> CellVisibility::shaft_of(const Box& a, const Box& b) const {
  const Shaft shaft = make_shaft(a, b, graph_.tolerance);
  std::vector<Plane> planes(shaft.planes.begin(), shaft.planes.begin() + shaft.plane_count);
  for (int k = 0; k < 3; ++k) {
    Vec3 axis{0};
    axis[k] = 1;
    planes.push_back({axis, shaft.box.lo[k]});
    planes.push_back({-axis, -shaft.box.hi[k]});
  }
  for (Plane& p : planes) {
    p.normal = p.normal.x * frame_.u + p.normal.y * frame_.v + p.normal.z * frame_.n;
    p.offset += dot(p.normal, frame_.origin);
  }
  return planes;
}

bool CellVisibility::PairJudge::joined(const ClusterInCell& a, const ClusterInCell& b) {
  if (steps_left_ == 0) return true;
  const std::vector<Vec3> source = corners_of(sight_.frame_, a.box, sight_.graph_.tolerance);
  const bool reached = flow_.run_within(
      source, a.cell, sight_.shaft_of(a.box, b.box), std::min(steps_left_, kStepsOfPair),
      [&](const SeenSpace& space) { return space.cell == b.cell && sight_.seen(b, space.planes); });
  steps_left_ -= std::min(steps_left_, flow_.steps());
  return reached;
}

void CellVisibility::PairJudge::keep_joined(std::uint32_t c, std::vector<std::uint32_t>& partners) {
  steps_left_ = kMostPairSteps / sight_.places_of_.size();
  std::erase_if(partners, [&](std::uint32_t d) { return !joined(c, d); });
}

bool CellVisibility::PairJudge::joined(std::uint32_t c, std::uint32_t d) {
  const auto &from = sight_.places_of_[c], &to = sight_.places_of_[d];
  const auto any = [&](auto&& holds) {
    return std::any_of(from.begin(), from.end(), [&](std::uint32_t i) {
      return std::any_of(to.begin(), to.end(), [&](std::uint32_t j) {
        return holds(sight_.places_[i], sight_.places_[j]);
      });
    });
  };
  return any([](const ClusterInCell& a, const ClusterInCell& b) { return a.cell == b.cell; }) ||
         any([this](const ClusterInCell& a, const ClusterInCell& b) { return joined(a, b); });
}

}  // namespace atrium
