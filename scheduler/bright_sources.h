// Bright sources: what is so much brighter than all else that rays sent out by the cosine alone,
// which would seldom meet it, would drown in noise. Lamps are: patches that emit much more than the
// scene's mean; and so are elements that reflect much more, as a ceiling does an inch above a lamp.
// Their light is their form factor times what shadow rays to them say. Surfaces that glow as all
// others do are none.
//
// How many shadow rays a source gets goes by a rough guess of what it would bring if nothing stood
// between; its form factor is found where it gets one. To a source that is near for its size they
// go by what its parts would bring, so that the kernel hardly varies over what each stands for.
// Immutable once found, of the solution that was stored then; any number of threads may ask.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/model.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "visibility/occlusion.h"

namespace atrium {

struct BrightSource {
  PatchId patch;
  std::int32_t element = 0;  // kLamp: the patch, for what it emits; else for what it reflects
  Polygon polygon;
  Vec3 normal{0};  // unit
  Vec3 center{0};  // of the ball about the polygon
  double radius = 0, area = 0;
  Spectrum radiosity{0};  // lm/m², mean

  static constexpr std::int32_t kLamp = -1;
  bool lamp() const { return element == kLamp; }
};

// What a guess goes by: a cache line's worth, since most sources are no more than guessed at.
struct SourceOutline {
  Vec3 center{0};
  double radius = 0;
  Vec3 normal{0};
  double flux = 0;  // lm, luminance of what it sends out
};
static_assert(sizeof(SourceOutline) == 64);

// A source as a point may see it.
struct Glance {
  const BrightSource* source = nullptr;
  double weight = 0;        // lx, luminance of what it would bring, roughly
  double form_factor = -1;  // were nothing between; -1: not known
};

// What a replicate gets: about so many rays, by random numbers of this key.
struct Due {
  int rays = 0;
  std::uint64_t key = 0;
};

struct ShadowRay {
  const BrightSource* source = nullptr;
  std::uint32_t replicate = 0;
  Vec3 x{0};          // where it ends
  double weight = 0;  // times the radiosity there, lx
};

class BrightSources {
 public:
  // Reads every cluster's record.
  static Result<BrightSources> find(const Model& model, ClusterStore& store);

  bool is_lamp(PatchId patch) const { return is_lamp_[patch.value]; }
  // Is the leaf of this patch, or an element above it, one of the sources?
  bool reflects_brightly(const PatchView& patch, std::int32_t leaf) const;
  std::size_t size() const { return sources_.items.size(); }
  std::size_t bytes() const;  // of memory

  // What a point of a cluster, or one in the air, may see of them.
  void look(const Vec3& x, const Vec3& normal, ClusterId cluster,
            std::vector<Glance>& glances) const;

 private:
  explicit BrightSources(const Model& model) : model_(&model) {}
  void look(const Vec3& x, const Vec3& normal, std::size_t row,
            std::vector<Glance>& glances) const;

  const Model* model_;
  Rows<BrightSource> sources_;                       // a row a cluster, by patch and element
  std::vector<SourceOutline> outlines_;              // in the sources' order
  std::vector<bool> is_lamp_, has_bright_elements_;  // by patch
};

// The shadow rays from x, of all replicates, source by source. Where a source is wholly seen, a
// replicate's rays bring its form factor times its radiosity exactly. Unbiased but for the kernel's
// variation over what a ray stands for, times the inverse number of the source's rays.
void deal_shadow_rays(const Vec3& x, const Vec3& normal, std::span<const Glance> glances,
                      std::span<const Due> due, std::vector<ShadowRay>& shadow);

// Leaves those that meet nothing.
void keep_seen(const Vec3& x, const RayScene& scene, std::vector<ShadowRay>& shadow);

}  // namespace atrium
