// paper_report RUNS ORDERS OUT: the paper's tables and figures of what bench/paper has solved, as
// Markdown on stdout; the tables as OUT/*.csv, the pictures as OUT/*.svg.
//   RUNS     a run directory for each model, named as `atrium gen` does: office, floor, …
//   ORDERS   a run directory for each gather order, named as `atrium solve --order` does
// What is not there is left out.
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "apps/command.h"
#include "apps/output.h"
#include "apps/report/number_text.h"
#include "apps/solve_options.h"
#include "bench/paper_report/pictures.h"
#include "bench/paper_report/tables.h"
#include "engine/import/import.h"
#include "scheduler/order.h"
#include "scheduler/run_files.h"
#include "scheduler/solution.h"

namespace atrium {
namespace {

namespace fs = std::filesystem;

struct Places {
  fs::path runs, orders, out;
};

bool is_solved(const fs::path& run) { return fs::exists(run / RunFiles::name(RunFile::kSummary)); }

Result<SolvedModel> read_model(const std::string& kind, const fs::path& run) {
  Result<RunData> data = read_run(run.string());
  if (!data.ok()) return data.status();
  SolveOptions options;
  ATRIUM_RETURN_IF_ERROR(read_run_toml((run / RunFiles::name(RunFile::kToml)).string(), options));
  const Result<Scene> scene = import_scene(options.scene);
  if (!scene.ok()) return scene.status();
  SolvedModel model;
  model.figures = model_figures(paper_name(kind), inspect(*scene), *data);
  model.run = std::move(*data);
  return model;
}

Result<std::vector<SolvedModel>> read_models(const fs::path& runs) {
  std::vector<SolvedModel> models;
  for (const std::string& kind : model_kinds()) {
    if (!is_solved(runs / kind)) continue;
    Result<SolvedModel> model = read_model(kind, runs / kind);
    if (!model.ok()) return model.status();
    models.push_back(std::move(*model));
  }
  return models;
}

Result<std::vector<OrderFigures>> read_orders(const fs::path& orders) {
  std::vector<OrderFigures> found;
  for (const std::string& order : order_names()) {
    if (!is_solved(orders / order)) continue;
    const Result<RunData> run = read_run((orders / order).string());
    if (!run.ok()) return run.status();
    found.push_back(order_figures(order, *run));
  }
  return found;
}

const SolvedModel* find(const std::vector<SolvedModel>& models, const char* kind) {
  for (const SolvedModel& m : models)
    if (m.figures.model == paper_name(kind)) return &m;
  return nullptr;
}

Status put(const Places& places, const std::string& name, const std::string& text) {
  return write_output((places.out / name).string(), {text});
}

void show_picture(const std::string& title, const std::string& file) {
  std::cout << "![" << title << "](" << file << ")\n\n";
}

Status show_table(const Places& places, const std::string& heading, const std::string& file,
                  const TextTable& table) {
  if (table.rows.empty()) return {};
  std::cout << "## " << heading << "\n\n" << markdown(table) << '\n';
  return put(places, file, csv(table));
}

Status show_models(const Places& places, const std::vector<SolvedModel>& models) {
  ATRIUM_RETURN_IF_ERROR(
      show_table(places, "The models, solved", "results.csv", results_table(models)));
  const std::vector<std::string> local{"Office", "Office Low", "Office High"};
  const std::vector<std::string> global{"Office", "Floor", "Building"};
  ATRIUM_RETURN_IF_ERROR(show_table(places, "Table 2: models of increasing local complexity",
                                    "table2.csv", models_table(local, models)));
  ATRIUM_RETURN_IF_ERROR(show_table(places, "Table 3: models of increasing global complexity",
                                    "table3.csv", models_table(global, models)));
  std::vector<ModelFigures> paper, ours;
  for (const ModelFigures& m : paper_models())
    for (const SolvedModel& own : models)
      if (own.figures.model == m.model && std::ranges::count(global, m.model) > 0) {
        paper.push_back(m);
        ours.push_back(own.figures);
      }
  const Figure theirs = spread_of_seconds_a_patch(paper), own = spread_of_seconds_a_patch(ours);
  if (theirs && own && ours.size() > 1)
    std::cout << "Most seconds a patch ÷ fewest: " << number_text(*theirs) << " in the paper, "
              << number_text(*own) << " here.\n\n";
  std::cout
      << "WS: the largest working set, its links, elements and blockers. Total links and elements "
         "are those of the last iteration. Ours of all data is what was processed in all of them, "
         "an element once for each gather that read it. Clusters are the input's, before the "
         "partition cuts them by rooms.\n\n";
  return {};
}

Status show_iterations(const Places& places, const SolvedModel& building) {
  const auto rows = iteration_figures(building.figures, building.run);
  ATRIUM_RETURN_IF_ERROR(show_table(places, "Table 5: Building, iteration by iteration",
                                    "table5.csv", iterations_table(rows)));
  std::cout << "Import and partition are in the first iteration's total time, a look at the error "
               "in that of the iteration after it. I/O time is that of all calls, waited for or "
               "not; in the total are those of the first records and of checkpoints too.\n\n";
  return {};
}

Status show_working_sets(const Places& places, const SolvedModel& building) {
  const std::optional<HistoryEntry> iteration = fullest_iteration(building.run);
  if (!iteration) return {};
  constexpr double kMega = 1e6;
  TextTable table{{{"Clusters gathered to", "gathered"},
                   {"Largest (MB)", "largest_mb"},
                   {"Mean (MB)", "mean_mb"}},
                  {}};
  const auto& largest = iteration->largest_working_sets;
  for (std::size_t i = 0; i < largest.size(); ++i)
    table.rows.push_back({number_entry(iteration->clusters_gathered.value_or(0) * double(i + 1) /
                                       double(largest.size())),
                          number_entry(largest[i] / kMega),
                          number_entry(iteration->mean_working_sets[i] / kMega)});
  ATRIUM_RETURN_IF_ERROR(put(places, "figure4.csv", csv(table)));
  ATRIUM_RETURN_IF_ERROR(
      put(places, "figure4.svg", working_set_picture(building.figures.model, *iteration)));
  std::cout << "## Figure 4: working set size while solving Building\n\n";
  show_picture("Working sets", "figure4.svg");
  return {};
}

Status show_matrices(const Places& places, const fs::path& floor) {
  const auto solution = Solution::open(floor.string(), kReadingArena);
  if (!solution.ok()) return solution.status();
  const Model& model = (*solution)->run().model;
  constexpr std::uint64_t kSeed = 1;
  std::vector<OrderedMatrix> matrices;
  TextTable table{{{"Order", "order"},
                   {"Clusters", "clusters"},
                   {"Pairs that may see each other", "pairs"},
                   {"Share that the gather before saw too", "common"}},
                  {}};
  for (const OrderFigures& paper : paper_orders()) {
    const auto order = make_order(paper.order, {model, {}, kSeed});  // none of them by light
    if (!order.ok()) return order.status();
    matrices.push_back({paper.order, interaction_matrix(model.visible, *order)});
    const InteractionMatrix& m = matrices.back().matrix;
    table.rows.push_back({word_entry(paper.order), number_entry(double(m.clusters)),
                          number_entry(double(m.pairs)), number_entry(m.common, 1, .01, "%")});
  }
  const Result<std::string> picture = matrices_picture(matrices);
  if (!picture.ok()) return picture.status();
  ATRIUM_RETURN_IF_ERROR(put(places, "figure5.svg", *picture));
  ATRIUM_RETURN_IF_ERROR(
      show_table(places, "Figure 5: interaction matrices of Floor", "figure5.csv", table));
  show_picture("Interaction matrices", "figure5.svg");
  return {};
}

Status show_orders(const Places& places, const std::vector<OrderFigures>& orders) {
  ATRIUM_RETURN_IF_ERROR(
      show_table(places, "Table 4: I/O of the gather orders, Floor, a cache of a third of its data",
                 "table4.csv", orders_table(orders)));
  TextTable table{{{"Order", "order"}, {"I/O, share of the time", "io_share"}}, {}};
  for (const OrderFigures& o : orders)
    table.rows.push_back({word_entry(o.order), number_entry(io_share(o), 1, .01, "%")});
  ATRIUM_RETURN_IF_ERROR(put(places, "figure6.csv", csv(table)));
  ATRIUM_RETURN_IF_ERROR(put(places, "figure6.svg", time_picture(orders)));
  std::cout << "## Figure 6: time distributions for various gather orders\n\n";
  show_picture("Time distributions", "figure6.svg");
  return {};
}

Status report(const Places& places) {
  const Result<std::vector<SolvedModel>> models = read_models(places.runs);
  if (!models.ok()) return models.status();
  if (!models->empty()) ATRIUM_RETURN_IF_ERROR(show_models(places, *models));
  const Result<std::vector<OrderFigures>> orders = read_orders(places.orders);
  if (!orders.ok()) return orders.status();
  const SolvedModel* building = find(*models, "building");
  if (building) ATRIUM_RETURN_IF_ERROR(show_working_sets(places, *building));
  if (is_solved(places.runs / "floor"))
    ATRIUM_RETURN_IF_ERROR(show_matrices(places, places.runs / "floor"));
  if (!orders->empty()) ATRIUM_RETURN_IF_ERROR(show_orders(places, *orders));
  return building ? show_iterations(places, *building) : Status();
}

}  // namespace
}  // namespace atrium

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: paper_report RUNS ORDERS OUT\n";
    return 2;
  }
  const atrium::Status status = atrium::report({argv[1], argv[2], argv[3]});
  if (status.ok()) return 0;
  std::cerr << "paper_report: " << status.message() << '\n';
  return static_cast<int>(status.code());
}
