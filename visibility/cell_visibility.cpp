#include "visibility/cell_visibility.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace atrium {

namespace {
// Windows that all flows from cells together, or from clusters, may look at; each has its share of
// them before it is only flooded. A count, not a clock: the same on every machine.
constexpr std::size_t kMostSteps = 50'000'000;
constexpr std::size_t kLeastSteps = 1000;
// Portals that expected_steps tries.
constexpr std::size_t kSample = 128;

std::size_t steps_each(std::size_t flows) {
  return std::max(kLeastSteps, kMostSteps / std::max<std::size_t>(flows, 1));
}
}  // namespace

double expected_steps(const PortalGraph& graph) {
  const std::size_t n = graph.portals.size();
  const std::size_t stride = std::max<std::size_t>(1, n / kSample);
  PortalFlow flow(graph);
  double steps = 0, tried = 0;
  for (std::size_t p = 0; p < n; p += stride, ++tried) {
    flow.run_through(static_cast<std::uint32_t>(p), steps_each(n));
    steps += double(flow.steps());
  }
  return tried > 0 ? steps / tried * double(n) : 0;
}

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
  ClusterRow row() {
    std::sort(found.begin(), found.end());
    return found;
  }

  PortalFlow flow;
  std::uint32_t run = 0;
  std::vector<std::uint32_t> found_in;
  ClusterRow found;
};

CellVisibility::CellVisibility(const PortalGraph& graph, const Frame& frame,
                               std::vector<ClusterInCell> places, std::size_t clusters)
    : graph_(graph),
      frame_(frame),
      places_(std::move(places)),
      places_in_(graph.out_of.size()),
      clusters_(clusters) {
  for (std::uint32_t i = 0; i < places_.size(); ++i) places_in_[places_[i].cell].push_back(i);
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

void CellVisibility::collect_cell(std::uint32_t cell, Worker& worker) const {
  for (std::uint32_t i : places_in_[cell]) worker.add(places_[i].cluster);
}

void CellVisibility::collect_flow(Worker& worker) const {
  worker.flow.each_seen([&](const SeenSpace& space) {
    for (std::uint32_t i : places_in_[space.cell])
      if (!worker.has(places_[i].cluster) && seen(places_[i], space.planes))
        worker.add(places_[i].cluster);
  });
}

std::vector<CellVisibility::ClusterRow> CellVisibility::from_cells() const {
  tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(graph_, clusters_); });
  std::vector<ClusterRow> through(graph_.portals.size());
  const std::size_t steps = steps_each(through.size());
  tbb::parallel_for(std::size_t{0}, through.size(), [&](std::size_t p) {
    Worker& worker = workers.local();
    worker.begin();
    const DirectedPortal& portal = graph_.portals[p];
    for (std::uint32_t i : places_in_[portal.to])
      if (seen(places_[i], {&portal.plane, 1})) worker.add(places_[i].cluster);
    worker.flow.run_through(static_cast<std::uint32_t>(p), steps);
    collect_flow(worker);
    through[p] = worker.row();
  });
  std::vector<ClusterRow> rows(graph_.out_of.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t c) {
    if (places_in_[c].empty()) return;
    Worker& worker = workers.local();
    worker.begin();
    collect_cell(static_cast<std::uint32_t>(c), worker);
    for (std::uint32_t p : graph_.out_of[c])
      for (std::uint32_t cluster : through[p]) worker.add(cluster);
    rows[c] = worker.row();
  });
  return rows;
}

std::vector<CellVisibility::ClusterRow> CellVisibility::from_clusters(
    const std::vector<ClusterRow>& allowed) const {
  tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(graph_, clusters_); });
  std::vector<std::vector<std::uint32_t>> places_of(clusters_);
  for (std::uint32_t i = 0; i < places_.size(); ++i) places_of[places_[i].cluster].push_back(i);
  std::vector<ClusterRow> rows(clusters_);
  const std::size_t steps = steps_each(places_.size());
  tbb::parallel_for(std::size_t{0}, clusters_, [&](std::size_t c) {
    Worker& worker = workers.local();
    worker.begin();
    for (std::uint32_t i : places_of[c]) {
      const ClusterInCell& place = places_[i];
      collect_cell(place.cell, worker);
      worker.flow.run_from_cell(corners_of(frame_, place.box, graph_.tolerance), place.cell, steps);
      collect_flow(worker);
    }
    const ClusterRow row = worker.row();
    std::set_intersection(row.begin(), row.end(), allowed[c].begin(), allowed[c].end(),
                          std::back_inserter(rows[c]));
  });
  return rows;
}

}  // namespace atrium
