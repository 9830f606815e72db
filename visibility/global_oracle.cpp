#include "visibility/global_oracle.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "visibility/facing.h"

namespace atrium {

namespace {

Rows<ClusterId> both_ways(const PairRows& pairs) {
  Rows<ClusterId> rows;
  std::vector<std::uint32_t> length(pairs.size(), 0);
  for (std::uint32_t c = 0; c < pairs.size(); ++c)
    for (std::uint32_t d : pairs[c]) {
      ++length[c];
      if (d != c) ++length[d];
    }
  for (std::uint32_t n : length) rows.starts.push_back(rows.starts.back() + n);
  rows.items.resize(rows.starts.back());
  std::vector<std::uint32_t> end(rows.starts.begin(), rows.starts.end() - 1);
  for (std::uint32_t c = 0; c < pairs.size(); ++c)
    for (std::uint32_t d : pairs[c])
      if (d != c) rows.items[end[d]++] = ClusterId(c);
  for (std::uint32_t c = 0; c < pairs.size(); ++c)
    for (std::uint32_t d : pairs[c]) rows.items[end[c]++] = ClusterId(d);
  return rows;
}

}  // namespace

Rows<ClusterId> find_visible(const Bsp& bsp, const std::vector<CellPortal>& lit_portals,
                             const Model& model, std::vector<ClusterInCell> places) {
  const PortalGraph graph = make_graph(bsp, lit_portals);
  const CellVisibility sight(graph, bsp.frame, std::move(places), model.clusters.size());
  PairRows pairs = sight.seen_pairs();
  const Facing facing(model);
  tbb::enumerable_thread_specific<CellVisibility::PairJudge> judges(sight);
  tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t i) {
    const auto c = static_cast<std::uint32_t>(i);
    std::erase_if(pairs[c], [&](std::uint32_t d) { return !facing.may_see(c, d); });
    judges.local().keep_joined(c, pairs[c]);
  });
  return both_ways(pairs);
}

}  // namespace atrium
