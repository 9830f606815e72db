#include "scheduler/plan.h"

#include <algorithm>
#include <cmath>

#include "engine/cluster_record.h"
#include "engine/quantity.h"
#include "scheduler/order.h"
#include "scheduler/run_model.h"
#include "scheduler/warm_start.h"
#include "scheduler/working_set.h"
#include "visibility/partition.h"

namespace atrium {

namespace {

// A bright closed room multiplies its light by 1/(1-ρ); no guess goes beyond this.
constexpr double kMostInterreflection = 1000;

LightScale measure_light(const Scene& scene, const Model& model) {
  LightScale s;
  std::vector<double> lit(model.clusters.size(), 0);
  double reflected = 0, norm2 = 0;
  for (const Patch& p : model.patches) {
    if (p.inert) continue;
    const Material& m = scene.materials[p.material.value];
    const double a = area(model.polygon(p)), exitance = luminance(m.exitance);
    s.area += a;
    s.flux += a * exitance;
    norm2 += a * exitance * exitance;
    reflected += a * luminance(m.reflectance);
    lit[p.cluster.value] += a;
  }
  for (std::size_t c = 0; c < lit.size(); ++c)
    for (const ClusterId v : model.visible[c]) s.reference_area += lit[c] * lit[v.value];
  if (!(s.area > 0)) return s;
  s.reference_area /= s.area;
  s.reflectance = reflected / s.area;
  s.exitance_norm = std::sqrt(norm2);
  s.radiosity = s.flux / s.area * std::min(kMostInterreflection, 1 / (1 - s.reflectance));
  s.irradiance = s.radiosity;
  return s;
}

// One record of a cluster before any element is split: what an arena must hold at the least.
std::size_t first_record_bytes(const Model& model, const Cluster& c, int order,
                               std::uint64_t dense) {
  std::size_t bytes = sizeof(ClusterHead);
  if (c.patch_count >= dense) bytes += c.patch_count * (sizeof(FaceGroup) + sizeof(GroupMember));
  for (std::uint32_t i = 0; i < c.patch_count; ++i) {
    const std::uint32_t id = c.first_patch + i;
    bytes += sizeof(PatchHead) + sizeof(Element) +
             model.patches[id].vertex_count * sizeof(Vec2) +
             model.contacts[id].size() * sizeof(Segment2) +
             sizeof(double) * (coefficient_count(order) * kChannels + triangle_count(order));
  }
  return bytes;
}

// Small patches from which on a cluster is dense: fewer make about as many links by themselves.
constexpr std::uint64_t kDense = 24;
// Where groups are asked for: any two patches.
constexpr std::uint64_t kFewest = 2;

// As solver/face_groups.cpp will find them.
std::uint64_t small_patches(const Prepared& p, const Cluster& c) {
  double whole = 0;
  for (std::uint32_t i = 0; i < c.patch_count; ++i) {
    const Patch& patch = p.model.patches[c.first_patch + i];
    whole += patch.inert ? 0 : area(p.model.polygon(patch));
  }
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < c.patch_count; ++i) {
    const Patch& patch = p.model.patches[c.first_patch + i];
    const bool dark = p.scene.materials[patch.material.value].exitance == Spectrum{0};
    count += dark && !patch.inert && area(p.model.polygon(patch)) < kLargeShare * whole;
  }
  return count;
}

void plan_groups(const SolveOptions& options, const Prepared& p, Plan& plan) {
  plan.dense = forces(options, kGroups) ? kFewest : kDense;
  for (const Cluster& c : p.model.clusters)
    if (small_patches(p, c) >= plan.dense) return;
  plan.left_out.push_back(
      {kGroups, "no cluster has " + std::to_string(plan.dense) +
                    " small patches or more that could stand for one another"});
}

// The largest cluster's record, one of many small patches, grows by less than this factor from its
// first form to a solution of a few percent. Where it grows by more, the store says so and what
// would do.
constexpr std::size_t kGrowth = 3;

void plan_memory(const SolveOptions& options, const Model& model, Plan& plan) {
  std::size_t largest = kRunModelPiece;
  for (const Cluster& c : model.clusters)
    largest = std::max(largest, first_record_bytes(model, c, options.basis, plan.dense) * kGrowth);
  std::size_t in_core = model.vertices.size() * sizeof(Vec3) +
                        model.patches.size() * sizeof(Patch) +
                        model.visible.items.size() * sizeof(ClusterId) +
                        model.contacts.items.size() * sizeof(Contact);
  // The receiver and one source.
  plan.smallest_arena = 2 * ClusterStore::arena_cost(largest);
  plan.smallest_memory = 4 * plan.smallest_arena + 4 * in_core;
  plan.memory = options.memory;
  plan.arena = options.arena ? options.arena
                             : std::max<std::uint64_t>(options.memory / 4, plan.smallest_arena);
}

// A solution is on disk as the last root has it and as the next one will. What an element tree
// grows to goes with one over the error: measured at most .2 ÷ error times its first form.
void plan_disk(const SolveOptions& options, const Model& model, Plan& plan) {
  constexpr double kGrowthByError = 0.2;
  constexpr double kCopies = 2;
  std::uint64_t first = model.vertices.size() * sizeof(Vec3) +
                        model.patches.size() * sizeof(Patch) +
                        model.visible.items.size() * sizeof(ClusterId);
  for (const Cluster& c : model.clusters)
    first += ClusterStore::arena_cost(first_record_bytes(model, c, options.basis, plan.dense)) +
             kGranule;
  plan.smallest_disk = first;
  plan.disk = static_cast<std::uint64_t>(
      static_cast<double>(plan.smallest_disk) +
      static_cast<double>(first) * kCopies * kGrowthByError / options.error);
}

void plan_left_out(const SolveOptions& options, const Prepared& p, Plan& plan) {
  const Model& m = p.model;
  if (m.cells.size() <= 1)
    plan.left_out.push_back(
        {"portals", "the scene is one cell: everything in it may see everything"});
  const std::uint32_t empty = forces(options, kRays) ? 0 : count_rooms_without_rays(m);
  if (empty > 0)
    plan.left_out.push_back({kRays, std::to_string(empty) + " of " + std::to_string(m.rooms) +
                                        " rooms are convex and empty: nothing can stand between"});
  if (m.dark_surfaces > 0)
    plan.left_out.push_back({"dark surfaces", std::to_string(m.dark_surfaces) +
                                                  " surfaces stand where no light reaches"});
  bool grey = true;
  for (const Material& x : p.scene.materials)
    grey &= x.reflectance.x == x.reflectance.y && x.reflectance.y == x.reflectance.z &&
            x.exitance.x == x.exitance.y && x.exitance.y == x.exitance.z;
  std::uint64_t inert = 0;
  for (const Patch& x : m.patches) inert += x.inert;
  if (inert > 0)
    plan.left_out.push_back({"black backs", std::to_string(inert) +
                                                " backs of one-sided surfaces only block"});
  if (grey) plan.warnings.push_back("all materials are grey: the three channels are equal");
}

void plan_gaps(const Prepared& p, Plan& plan) {
  plan.closed_gaps = named_gaps(p.scene, p.model.closed_gaps);
  const std::size_t n = plan.closed_gaps.size();
  if (n == 0) return;
  plan.warnings.push_back("closed " + std::to_string(n) + (n == 1 ? " gap" : " gaps") + " up to " +
                          format_length(plan.closed_gaps.front().width) + " wide");
}

Status budget_too_small(const char* option, std::uint64_t given, std::uint64_t smallest) {
  return Status(Code::kUsage, "", option,
                std::to_string(given) + " bytes are too small for this scene",
                "the smallest that will do is " + std::to_string(smallest) + " bytes");
}

}  // namespace

bool forces(const SolveOptions& options, const std::string& feature) {
  return std::find(options.force.begin(), options.force.end(), feature) != options.force.end();
}

Status validate(const SolveOptions& o) {
  const auto refuse = [](const char* option, const std::string& why, const std::string& remedy) {
    return Status(Code::kUsage, "", option, why, remedy);
  };
  if (o.scene.files.empty()) return refuse("SCENE", "no scene file", "name at least one");
  if (!(o.error > 0 && o.error < 1))
    return refuse("--error", "not above 0% and below 100%", "try 2%");
  if (o.basis < 1 || o.basis > kMaxOrder)
    return refuse("--basis", "order " + std::to_string(o.basis) + " is not built",
                  "use 1 to " + std::to_string(kMaxOrder));
  if (o.links != "auto" && o.links != "keep" && o.links != "discard")
    return refuse("--links", "unknown choice " + o.links, "use keep, discard or auto");
  ATRIUM_RETURN_IF_ERROR(check_order(o.order));
  if (o.io != "mmap" && o.io != "direct")
    return refuse("--io", "unknown way to the disk " + o.io, "use mmap or direct");
  if (!(o.checkpoint_every > 0))
    return refuse("--checkpoint-every", "not above 0", "try 10min");
  if (!o.from.empty() && o.from == o.run_directory)
    return refuse("--from", "it is the directory to be made", "give another one with -o");
  for (const std::string& feature : o.force)
    if (feature != kRays && feature != kGroups)
      return refuse("--force", feature + " can not be forced",
                    "use rays, which are left out in convex empty rooms, or groups, where no "
                    "cluster has many small patches");
  return {};
}

Result<Prepared> prepare(const SolveOptions& options) {
  Result<Scene> scene = import_scene(options.scene);
  if (!scene.ok()) return scene.status();
  Result<Model> model = partition(*scene, options.partition);
  if (!model.ok()) return model.status();
  Prepared p{std::move(scene).value(), std::move(model).value(), {}, {}};
  p.light = measure_light(p.scene, p.model);
  const std::string& first = options.scene.files[0];
  if (!(p.light.flux > 0))
    return Status(Code::kScene, first, "", "no light: no material emits",
                  "add lamps (Ke in the MTL, emissiveFactor in glTF), a lamps file, or --assign");

  Plan& plan = p.plan;
  plan.clusters = p.model.clusters.size();
  plan.patches = p.model.patches.size();
  plan.cells = p.model.cells.size();
  plan.portals = p.model.portals.size();
  plan.rooms = p.model.rooms;
  plan.lights = p.scene.lights;
  const double pairs = double(plan.clusters) * double(plan.clusters);
  plan.visible_share = pairs > 0 ? p.model.visible.items.size() / pairs : 0;
  plan.mean_irradiance_guess = p.light.irradiance;
  // No element need be smaller than this share of what a surface sees: 3 mm where rooms have
  // 100 m².
  constexpr double kSmallestEdge = 1.0 / 3000;
  plan.min_edge =
      options.min_edge > 0 ? options.min_edge : kSmallestEdge * std::sqrt(p.light.reference_area);
  plan_groups(options, p, plan);
  plan_memory(options, p.model, plan);
  plan_disk(options, p.model, plan);
  plan_left_out(options, p, plan);
  for (const Warning& w : p.scene.warnings)
    plan.warnings.push_back(w.what + " (" + std::to_string(w.count) + ")");
  plan_gaps(p, plan);
  if (plan.arena < plan.smallest_arena)
    return budget_too_small("--arena", plan.arena, plan.smallest_arena);
  if (plan.memory < plan.smallest_memory)
    return budget_too_small("--memory", plan.memory, plan.smallest_memory);
  return p;
}

Result<Plan> plan(const SolveOptions& options) {
  ATRIUM_RETURN_IF_ERROR(validate(options));
  Result<Prepared> p = prepare(options);
  if (!p.ok()) return p.status();
  if (!options.from.empty()) {
    const Result<std::unique_ptr<WarmStart>> warm = WarmStart::open(options, *p);
    if (!warm.ok()) return warm.status();
    Equilibrium equilibrium(p->model, {});
    Cursor cursor;
    (*warm)->begin(equilibrium, cursor);
    p->plan.warm = (*warm)->figures(equilibrium);
  }
  return p->plan;
}

}  // namespace atrium
