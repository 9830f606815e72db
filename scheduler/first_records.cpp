#include "scheduler/first_records.h"

#include <type_traits>
#include <vector>

#include "scheduler/run_model.h"
#include "solver/element_tree.h"
#include "solver/face_groups.h"

namespace atrium {

namespace {

RunModel run_model(const Prepared& prepared, int basis) {
  RunModel run;
  run.frame = prepared.scene.frame;
  run.bounds = prepared.scene.bounds;
  run.tolerance = prepared.scene.tolerance;
  run.order = basis;
  run.files = prepared.scene.files;
  for (const Object& o : prepared.scene.objects) run.object_names.push_back(o.name);
  for (const Material& m : prepared.scene.materials) run.material_names.push_back(m.name);
  run.model = prepared.model;
  return run;
}

std::vector<PatchTree> plant_all(const Prepared& prepared, ClusterId id, int basis) {
  const Cluster& cluster = prepared.model.clusters[id.value];
  std::vector<PatchTree> trees;
  for (std::uint32_t i = 0; i < cluster.patch_count; ++i)
    trees.push_back(
        plant(prepared.model, prepared.scene, PatchId(cluster.first_patch + i), basis));
  return trees;
}

static_assert(std::has_unique_object_representations_v<ClusterId>);
static_assert(sizeof(Spectrum) == kChannels * sizeof(double) && sizeof(Vec3) == 3 * sizeof(double));

}  // namespace

Status write_first_records(const Prepared& prepared, int basis, ClusterStore& store,
                           const TreesOf& trees_of) {
  const Model& model = prepared.model;
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    Result<std::vector<PatchTree>> trees =
        trees_of ? trees_of(ClusterId(c)) : plant_all(prepared, ClusterId(c), basis);
    if (!trees.ok()) return trees.status();
    GroupTree groups = plant_groups(*trees, prepared.plan.dense);
    if (trees_of) pull_groups(*trees, groups);
    std::vector<std::byte> bytes(record_bytes(*trees, groups));
    write_record(static_cast<std::uint32_t>(c), *trees, bytes, groups);
    ATRIUM_RETURN_IF_ERROR(store.create_record(record_id(RecordKind::kCluster, c), bytes));
  }
  return store_run_model(to_bytes(run_model(prepared, basis)), store);
}

// Of what has no padding, so that equal scenes have equal ones.
std::uint64_t fingerprint(const Scene& scene, const Model& model) {
  std::vector<std::uint64_t> parts{model.clusters.size(), model.patches.size(), model.cells.size()};
  const auto add = [&](const auto& items) {
    parts.push_back(hash_bytes(std::as_bytes(std::span(items))));
  };
  add(model.vertices);
  add(model.portal_vertices);
  add(model.visible.starts);
  add(model.visible.items);
  std::vector<Spectrum> paint;
  for (const Patch& p : model.patches) {
    const Material& m = scene.materials[p.material.value];
    paint.push_back(m.reflectance);
    paint.push_back(m.exitance);
  }
  add(paint);
  return hash_bytes(std::as_bytes(std::span(parts)));
}

}  // namespace atrium
