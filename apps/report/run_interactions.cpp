#include "apps/report/run_interactions.h"

#include <vector>

#include "apps/command.h"
#include "apps/solve_options.h"
#include "scheduler/order.h"
#include "scheduler/run_files.h"
#include "scheduler/solution.h"

namespace atrium {
namespace {

// As the patches bear them; of those with inert patches alone nothing is known, nor asked.
Status read_materials(Solution& solution, std::vector<Material>& materials) {
  const RunModel& run = solution.run();
  materials.resize(run.material_names.size());
  return solution.for_each_cluster([&](ClusterId, const ClusterView& cluster) {
    for (std::size_t p = 0; p < cluster.size(); ++p) {
      const PatchHead& head = cluster.patch_head(p);
      if (head.inert) continue;
      Material& material = materials[run.model.patches[head.patch].material.value];
      material.reflectance = head.reflectance;
      material.exitance = head.exitance;
    }
  });
}

Status look(const std::string& directory, RunInteractions& found) {
  SolveOptions options;
  ATRIUM_RETURN_IF_ERROR(read_run_toml(directory + "/" + RunFiles::name(RunFile::kToml), options));
  found.order = options.order;
  const Result<std::unique_ptr<Solution>> solution = Solution::open(directory, kReadingArena);
  if (!solution.ok()) return solution.status();
  const Model& model = (*solution)->run().model;
  std::vector<Material> materials;
  ATRIUM_RETURN_IF_ERROR(read_materials(**solution, materials));
  const auto order = make_order(options.order, {model, materials, options.seed});
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
