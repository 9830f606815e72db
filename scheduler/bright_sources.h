// Bright sources: what is so much brighter than all else that rays sent out by the cosine alone,
// which would seldom meet it, would drown in noise. Lamps are: patches that emit much more than the
// scene's mean; and so are elements that reflect much more, as a ceiling does an inch above a lamp.
// Their light is their form factor times what shadow rays to them say. Surfaces that glow as all
// others do are none.
//
// A source that is near for its size is taken in pieces, so that over each the kernel hardly
// varies; how many shadow rays a piece gets goes by the light it would bring if nothing stood
// between. Immutable once found, of the solution that was stored then; any number of threads may
// ask.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/model.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "solver/basis.h"
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
  // A quadrature over it, solver/basis.h: weights sum to 1.
  std::array<Vec3, kMaxNodes> node;
  std::array<double, kMaxNodes> node_weight{};
  int nodes = 0;

  static constexpr std::int32_t kLamp = -1;
  bool lamp() const { return element == kLamp; }
};

// A piece of a source as a point sees it; of itself, or of the source's own polygon where it is
// whole.
struct SourcePiece {
  const BrightSource* source = nullptr;
  Polygon part;            // empty: the whole
  double form_factor = 0;  // were nothing between
  double weight = 0;       // lx, luminance of what it would bring
  PolygonView polygon() const { return part.empty() ? PolygonView(source->polygon) : part; }
};

// A shadow ray that met nothing.
struct SeenSource {
  const BrightSource* source = nullptr;
  Vec3 x{0};
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

  // What a point of a cluster, or one in the air, may see of them.
  void look(const Vec3& x, const Vec3& normal, ClusterId cluster,
            std::vector<SourcePiece>& pieces) const;

 private:
  explicit BrightSources(const Model& model) : model_(&model) {}

  const Model* model_;
  Rows<BrightSource> sources_;                       // a row a cluster, by patch and element
  std::vector<bool> is_lamp_, has_bright_elements_;  // by patch
};

// About `rays` shadow rays from x to the pieces; appended are those that see their piece. A piece
// that is wholly seen brings its form factor times its radiosity exactly. Unbiased but for the
// kernel's variation over a piece times the inverse number of its rays.
void cast_shadow_rays(const Vec3& x, const Vec3& normal, std::span<const SourcePiece> pieces,
                      const RayScene& scene, int rays, std::uint64_t key,
                      std::vector<SeenSource>& seen);

}  // namespace atrium
