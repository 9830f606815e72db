// Fresh gather: irradiance at points, gathered anew with rays from a solution as the store holds
// it, past all links and elements of the receiver. Light comes by cosine-weighted rays, which read
// the solution off the element that they meet; that of lamps and whatever else is bright by shadow
// rays.
//
// Invariants:
//  1. What is gathered is the transport equation's right side of the solution that is stored, its
//     polynomials as they are: without bias but for what bright_sources.h says, and with a standard
//     error from replicates that are independent.
//  2. Works within bounds, whatever the scene's size: points go room by room, in batches of rays; a
//     source's record is pinned once a batch.
//  3. A point's rays follow from the settings and its own number alone; its result is the same bits
//     for any number of threads and any arena. Rays of points that follow one another on a plane go
//     out together, sorted by where they go: where one meets two surfaces at once, in an edge, its
//     company may decide which of them it is.
//
// One caller at a time; inside, points are shared by all threads. The store, the model and the ray
// worlds outlive it. Where the store is written to meanwhile, a gather is of what stands there
// then.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/model.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "scheduler/bright_sources.h"
#include "scheduler/patch_grid.h"
#include "scheduler/working_set.h"

namespace atrium {

struct GatherPoint {
  Vec3 x{0};          // m, internal frame
  Vec3 normal{0};     // unit
  ClusterId cluster;  // on whose surface it lies; none: in the air
};

struct FreshSettings {
  int directions = 1024;  // a point, in all; about as many shadow rays where anything is bright
  int replicates = 2;     // independent parts of them, which tell the standard error
  std::uint64_t seed = 1;
};

struct FreshIrradiance {
  Spectrum mean{0};            // lx
  Spectrum standard_error{0};  // lx, of the mean; 0 where one replicate does not tell
  double escaped = 0;          // share of the directions that leave the scene
  double black = 0;            // that meet black backs, or nothing that light reaches
};

// Where a point's light comes from, group of clusters by group: the share of its directions that
// meet even elements of them, and after it, at the next number, the luminance in lx of what their
// bright elements reflect to it.
struct RayShares {
  std::span<const std::uint32_t> group_of_cluster;  // even numbers
  std::size_t groups = 0;
  std::vector<double> of_point;  // points × groups

  std::span<const double> row(std::size_t point) const {
    return std::span(of_point).subspan(point * groups, groups);
  }
};

class FreshGather {
 public:
  FreshGather(const Model& model, ClusterStore& store, RayWorlds& worlds);
  ~FreshGather();

  // In the points' order. bright: of the solution as it is stored now. shares: filled where it is
  // asked for.
  Result<std::vector<FreshIrradiance>> gather(const BrightSources& bright,
                                              std::span<const GatherPoint> points,
                                              const FreshSettings& settings,
                                              RayShares* shares = nullptr);

 private:
  struct RayEnd;
  struct ShadowEnd;
  struct LitEnd;
  struct Batch;
  struct Scratch;

  const RayWorld& world_of(ClusterId cluster);
  void trace(Batch& batch);
  void trace_room(const RayScene& scene, std::size_t first, std::size_t last, Batch& batch) const;
  void send_out(const RayScene& scene, std::size_t first, std::size_t last, Batch& batch,
                Scratch& scratch) const;
  void send_shadow_rays(const RayScene& scene, std::size_t i, Batch& batch,
                        Scratch& scratch) const;
  PatchId facing_side(const Hit& hit, const Vec3& direction) const;
  Status read_off(Batch& batch);
  void conclude(Batch& batch, std::size_t i, FreshIrradiance& result,
                RayShares* shares) const;

  const Model& model_;
  ClusterStore& store_;
  RayWorlds& worlds_;
  PatchGrid grid_;                        // what faces a ray that met a surface from behind
  Rows<PatchId> other_sides_;             // a row a patch: the other sides of its surface
  std::unique_ptr<RayWorld> everything_;  // for points in the air, made when there is one
  std::unique_ptr<Batch> batch_;          // its memory is kept from gather to gather
};

}  // namespace atrium
