// A solved scene's store, opened for tests to look at and to disturb. What they change stays in the
// arena: nothing is checkpointed.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "scheduler/fresh_gather.h"
#include "scheduler/run_model.h"
#include "test/agree/run.h"

namespace atrium::testing {

// Solves a scene; for opening what came of it.
inline SolveOptions solved(Bench& bench, double error = 0.05) {
  SolveOptions options = bench.options();
  options.error = error;
  const Result<SolveSummary> summary = solve(options, {}, {});
  EXPECT_TRUE(summary.ok()) << summary.status().message();
  return options;
}

class SolvedStore {
 public:
  SolvedStore(const SolveOptions& solved, std::size_t arena) {
    StoreOptions options;
    options.arena_bytes = arena;
    auto opened = ClusterStore::open(solved.run_directory, options, OpenMode::kReadWrite);
    EXPECT_TRUE(opened.ok()) << opened.status().message();
    store_ = std::move(opened).value();
    Result<RunModel> run = load_run_model(*store_, solved.run_directory);
    EXPECT_TRUE(run.ok()) << run.status().message();
    run_ = std::move(run).value();
    worlds_.emplace(run_.model, RayUse::kWhereSomethingMayBlock);
    fresh_.emplace(run_.model, *store_, *worlds_);
  }

  ClusterStore& store() { return *store_; }
  const Model& model() const { return run_.model; }
  FreshGather& fresh() { return *fresh_; }

  // Calls `change` with every patch's tree and writes what it leaves.
  void change(const std::function<void(PatchTree&)>& change) {
    for (std::size_t c = 0; c < model().clusters.size(); ++c) {
      Result<ClusterEdit> edit = store_->edit(record_id(RecordKind::kCluster, c));
      ASSERT_TRUE(edit.ok()) << edit.status().message();
      std::vector<PatchTree> trees = read_record(ClusterView::parse(edit->bytes()).value());
      for (PatchTree& tree : trees) change(tree);
      ASSERT_TRUE(edit->resize(record_bytes(trees)).ok());
      write_record(static_cast<std::uint32_t>(c), trees, edit->bytes());
    }
  }

  // A point of a patch at its centroid, moved towards its first corner by a share of the way.
  GatherPoint point_on(PatchId id, double share) const {
    const Patch& patch = model().patches[id.value];
    const PolygonView polygon = model().polygon(patch);
    const Vec3 middle = centroid(polygon);
    return {middle + share * (polygon[0] - middle), plane_of(polygon).normal, patch.cluster};
  }

  // What stands at a point given in the file's frame.
  GatherPoint point_at(const Vec3& x, const Vec3& normal) const {
    const Vec3 at = run_.frame.to_internal(x);
    const PatchGrid grid(run_.model, run_.bounds, run_.tolerance);
    const std::optional<PatchId> patch = grid.find(at, normal, run_.tolerance);
    EXPECT_TRUE(patch.has_value());
    return {at, normal, run_.model.patches[patch.value_or(PatchId(0u)).value].cluster};
  }

  std::vector<FreshIrradiance> gather(std::span<const GatherPoint> points,
                                      const FreshSettings& settings) {
    const Result<BrightSources> bright = BrightSources::find(model(), *store_);
    EXPECT_TRUE(bright.ok());
    Result<std::vector<FreshIrradiance>> e = fresh_->gather(*bright, points, settings);
    EXPECT_TRUE(e.ok());
    return e.ok() ? std::move(e).value() : std::vector<FreshIrradiance>();
  }

 private:
  std::unique_ptr<ClusterStore> store_;
  RunModel run_;
  std::optional<RayWorlds> worlds_;
  std::optional<FreshGather> fresh_;
};

// Every element's E the same.
inline void set_even(PatchTree& tree, double e) {
  const std::size_t k = static_cast<std::size_t>(tree.view().k()) * kChannels;
  std::fill(tree.e.begin(), tree.e.end(), 0.0);
  for (std::size_t i = 0; i < tree.elements.size(); ++i)
    for (int c = 0; c < kChannels; ++c) tree.e[i * k + static_cast<std::size_t>(c)] = e;
}

}  // namespace atrium::testing
