#include "apps/report/run_interactions.h"

#include "apps/command.h"
#include "apps/solve_options.h"
#include "scheduler/order.h"
#include "scheduler/run_files.h"
#include "scheduler/solution.h"

namespace atrium {
namespace {

Status look(const std::string& directory, RunInteractions& found) {
  SolveOptions options;
  ATRIUM_RETURN_IF_ERROR(read_run_toml(directory + "/" + RunFiles::name(RunFile::kToml), options));
  found.order = options.order;
  const Result<std::unique_ptr<Solution>> solution = Solution::open(directory, kReadingArena);
  if (!solution.ok()) return solution.status();
  const Model& model = (*solution)->run().model;
  const auto order = make_order(options.order, model, options.seed);
  if (!order.ok()) return order.status();
  found.matrix = interaction_matrix(model.visible, *order);
  return {};
}

}  // namespace

RunInteractions read_interactions(const std::string& run_directory) {
  RunInteractions found;
  const Status looked = look(run_directory, found);
  if (!looked.ok()) found.why_not = looked.cause();
  return found;
}

}  // namespace atrium
