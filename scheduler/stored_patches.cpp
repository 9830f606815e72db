#include "scheduler/stored_patches.h"

namespace atrium {

Status each_receiver(ClusterStore& store, ClusterId cluster,
                     const std::function<void(const PatchView&)>& visit) {
  const Result<ClusterPin> pin = store.read(record_id(RecordKind::kCluster, cluster.value));
  if (!pin.ok()) return pin.status();
  const Result<ClusterView> view = ClusterView::parse(pin->bytes());
  if (!view.ok()) return view.status();
  for (std::size_t p = 0; p < view->size(); ++p)
    if (!view->patch_head(p).inert) visit(view->patch(p));
  return {};
}

void foresee(ClusterStore& store, std::span<const ClusterId> clusters) {
  std::vector<RecordId> records;
  for (const ClusterId c : clusters) records.push_back(record_id(RecordKind::kCluster, c.value));
  store.foresee(records);
}

Status each_receiver(ClusterStore& store, std::span<const ClusterId> clusters,
                     const std::function<void(ClusterId, const PatchView&)>& visit) {
  foresee(store, clusters);
  for (const ClusterId c : clusters)
    ATRIUM_RETURN_IF_ERROR(
        each_receiver(store, c, [&](const PatchView& patch) { visit(c, patch); }));
  return {};
}

std::vector<ClusterId> all_clusters(const Model& model) {
  std::vector<ClusterId> all;
  for (std::size_t c = 0; c < model.clusters.size(); ++c) all.push_back(ClusterId(c));
  return all;
}

// The basis' first function is 1, the others' means are 0.
Spectrum mean_irradiance(const PatchView& patch, std::size_t element) {
  const std::span<const double> e = patch.e_of(element);
  return {e[0], e[1], e[2]};
}

}  // namespace atrium
