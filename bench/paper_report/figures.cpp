#include "bench/paper_report/figures.h"

#include <algorithm>
#include <array>

namespace atrium {
namespace {

constexpr double kMega = 1e6, kHour = 3600;

struct Name {
  const char *kind, *name;
};
constexpr std::array<Name, 5> kNames{{{"office", "Office"},
                                      {"office-low", "Office Low"},
                                      {"office-high", "Office High"},
                                      {"floor", "Floor"},
                                      {"building", "Building"}}};

Figure quotient(const Figure& a, const Figure& b) {
  if (!a || !b || *b == 0) return std::nullopt;
  return *a / *b;
}

Figure in_mega(const Figure& bytes) { return quotient(bytes, kMega); }

IterationFigures in_hours(const Figure& iteration, const Figure& elements, const Figure& links,
                          const Figure& set_mb, double solver, double io, double total) {
  return {iteration, elements, links, set_mb, solver * kHour, io * kHour, total * kHour};
}

Figure difference(const Figure& a, const Figure& b) {
  if (!a || !b) return std::nullopt;
  return *a - *b;
}

}  // namespace

std::span<const ModelFigures> paper_models() {
  static const std::array<ModelFigures, 5> kModels{
      {{"Office", 36, 127, 18, 1.3, 9.5, 3914, 36186, 285, 1445, 3142, 24.7, 180, 1.4},
       {"Office Low", 70, 1418, 21, 11.1, 239.9, 38593, 960432, 677, 7081, 36377, 25.7, 7111, 5.0},
       {"Office High", 70, 3466, 21, 14.1, 414.4, 48784, 1678105, 484, 8975, 42400, 12.2, 13051,
        3.8},
       {"Floor", 1761, 7054, 788, 3.7, 1116.1, 12532, 4307705, 611, 2686, 250933, 35.6, 56712, 8.0},
       {"Building", 9625, 39979, 7826, 14.5, 6063.0, 52454, 23528943, 589, 7104, 1265843, 31.7,
        491040, 12.2}}};
  return kModels;
}

std::span<const OrderFigures> paper_orders() {
  static const std::array<OrderFigures, 4> kOrders{{{"random", 77916, 4374, .354, 23330, 49111},
                                                    {"model", 44163, 2376, .634, 12806, 43685},
                                                    {"source", 30798, 1708, .744, 8912, 33815},
                                                    {"cell", 11312, 617, .906, 3180, 26454}}};
  return kOrders;
}

std::span<const IterationFigures> paper_iterations() {
  static const std::array<IterationFigures, 5> kIterations{
      {{0, 39979, {}, {}, {}, {}, {}},
       in_hours(1, 295039, 2649521, 2.0, 3.3, 0.2, 5.1),
       in_hours(2, 884905, 15860111, 11.2, 40.6, 3.2, 47.0),
       in_hours(3, 1265843, 23528943, 14.5, 69.9, 10.8, 84.3),
       in_hours({}, 1265843, 23528943, 14.5, 113.8, 14.2, 136.4)}};
  return kIterations;
}

std::vector<std::string> model_kinds() {
  std::vector<std::string> kinds;
  for (const Name& n : kNames) kinds.push_back(n.kind);
  return kinds;
}

std::string paper_name(const std::string& kind) {
  for (const Name& n : kNames)
    if (kind == n.kind) return n.name;
  return kind;
}

ModelFigures model_figures(const std::string& model, const SceneReport& scene, const RunData& run) {
  ModelFigures f;
  f.model = model;
  f.clusters = double(scene.clusters);
  f.patches = double(scene.patches);
  f.lights = double(scene.lights);
  if (!run.summary) return f;
  const RunSummary& s = *run.summary;
  f.set_mb = in_mega(s.max_working_set_bytes);
  f.total_mb = in_mega(s.total_data_bytes);
  f.set_links = s.max_working_set_links;
  f.links = s.links;
  f.links_a_patch = quotient(f.links, f.patches);
  f.set_elements = s.max_working_set_elements;
  f.elements = s.elements;
  f.elements_a_patch = quotient(f.elements, f.patches);
  f.seconds = s.total_seconds;
  f.seconds_a_patch = quotient(f.seconds, f.patches);
  return f;
}

OrderFigures order_figures(const std::string& order, const RunData& run) {
  OrderFigures f;
  f.order = order;
  const std::vector<HistoryEntry> iterations = complete_iterations(run);
  if (iterations.empty()) return f;
  const HistoryEntry& last = iterations.back();
  f.reads = last.reads;
  f.read_mb = in_mega(last.bytes_read);
  f.hit_ratio = last.hit_ratio;
  f.io_seconds = last.io_seconds;
  if (iterations.size() > 1)
    f.seconds = difference(last.seconds, iterations[iterations.size() - 2].seconds);
  return f;
}

std::vector<IterationFigures> iteration_figures(const ModelFigures& model, const RunData& run) {
  std::vector<IterationFigures> rows{{0, model.patches, {}, {}, {}, {}, {}}};
  Figure before = 0;
  for (const HistoryEntry& e : complete_iterations(run)) {
    rows.push_back({e.iteration, e.elements, e.links, in_mega(e.max_working_set_bytes),
                    e.solver_seconds, e.io_seconds, difference(e.seconds, before)});
    before = e.seconds;
  }
  if (run.summary)
    rows.push_back({{},
                    run.summary->elements,
                    run.summary->links,
                    in_mega(run.summary->max_working_set_bytes),
                    run.summary->solver_seconds,
                    run.summary->io_seconds,
                    run.summary->total_seconds});
  return rows;
}

std::optional<HistoryEntry> fullest_iteration(const RunData& run) {
  std::optional<HistoryEntry> fullest;
  for (const HistoryEntry& e : complete_iterations(run)) {
    if (e.largest_working_sets.empty()) continue;
    if (!fullest || e.max_working_set_bytes > fullest->max_working_set_bytes) fullest = e;
  }
  return fullest;
}

Figure spread_of_seconds_a_patch(std::span<const ModelFigures> models) {
  Figure least, most;
  for (const ModelFigures& m : models) {
    if (!m.seconds_a_patch) continue;
    least = least ? std::min(*least, *m.seconds_a_patch) : *m.seconds_a_patch;
    most = most ? std::max(*most, *m.seconds_a_patch) : *m.seconds_a_patch;
  }
  return quotient(most, least);
}

}  // namespace atrium
