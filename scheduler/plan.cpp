#include "scheduler/plan.h"

#include <algorithm>
#include <cmath>

#include "engine/cluster_record.h"
#include "engine/quantity.h"
#include "pagestore/page_file.h"
#include "scheduler/equilibrium.h"
#include "scheduler/levels.h"
#include "scheduler/memory.h"
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

// Memory of what stays in the store's directory, and of the ray world of the room that sees most: a
// record's row and its copy at a checkpoint; a polygon's outline, its place in the index, and
// Embree's triangles and tree. Both measured, rounded up.
constexpr std::uint64_t kDirectoryOfRecord = 512, kRayWorldOfPolygon = 1536;
// For the grid and the rows of fresh gathers, of a patch.
constexpr std::uint64_t kFreshOfPatch = 64;

std::uint64_t largest_ray_world(const Model& model) {
  const Rows<ClusterId> seen = seen_from_rooms(model);
  std::uint64_t most = 0;
  for (std::size_t room = 0; room < seen.size(); ++room) {
    std::uint64_t polygons = 0;
    for (const ClusterId c : seen[room]) polygons += model.clusters[c.value].patch_count;
    most = std::max(most, polygons * kRayWorldOfPolygon);
  }
  return most;
}

// What must be there beside arena and links, at its largest.
std::uint64_t beside_arena(const Prepared& p) {
  const std::uint64_t records = 2 * p.model.clusters.size();  // solution, braids
  return p.bytes + records * kDirectoryOfRecord + largest_ray_world(p.model) +
         expected_coarse_bytes(p.model);
}

void plan_memory(const SolveOptions& options, const Prepared& p, Plan& plan) {
  std::size_t largest = kRunModelPiece;
  for (const Cluster& c : p.model.clusters)
    largest =
        std::max(largest, first_record_bytes(p.model, c, options.basis, plan.dense) * kGrowth);
  // The receiver and one source.
  plan.smallest_arena = 2 * ClusterStore::arena_cost(largest);
  const std::uint64_t beside = beside_arena(p);
  plan.smallest_memory =
      beside + ClusterStore::arena_memory(std::max(options.arena, plan.smallest_arena));
  plan.memory = options.memory;
  // A quarter, or what is beside it leaves of a small budget, holes and read ahead included.
  const std::uint64_t left = options.memory - std::min(options.memory, beside);
  const std::uint64_t share = std::min(options.memory / 4, left / 3 * 2);
  plan.arena = options.arena ? options.arena : std::max(share, plan.smallest_arena);
}

// Rates of what a solve takes: from cornell, rooms, office and floor at 10 and 2%, which they meet
// within a factor of two and a half.

// Patches that are refined: those of groups are few, and count for a tenth.
double refined_patches(const Prepared& p, const Plan& plan) {
  constexpr double kGrouped = 0.1;
  double patches = 0;
  for (const Cluster& c : p.model.clusters) {
    const double small = double(small_patches(p, c));
    double lit = 0;
    for (std::uint32_t i = 0; i < c.patch_count; ++i)
      lit += !p.model.patches[c.first_patch + i].inert;
    patches += small >= double(plan.dense) ? lit - small * (1 - kGrouped) : lit;
  }
  return patches;
}

// Of the last level.
struct Refined {
  double elements = 0, links = 0;
};

// They go by the patches, and with about one over the error.
Refined estimate_refined(const SolveOptions& options, const Prepared& p, const Plan& plan) {
  constexpr double kAt = 0.1;  // the error that the rates are of
  constexpr double kElementsOfPatch = 12, kLinksOfPatch = 50, kByError = 0.95;
  const double patches = refined_patches(p, plan);
  const double finer = std::pow(kAt / options.error, kByError);
  return {kElementsOfPatch * patches * finer, kLinksOfPatch * patches * finer};
}

// What is made in all levels, with its rays, and gathered across a dozen times; and the rays of
// estimates.
double estimate_seconds(double links) {
  constexpr double kLevelsMade = 1.6, kGathers = 12;  // of the last level's links
  constexpr double kMade = 40e-6, kAcross = 0.3e-6, kRay = 1e-6;  // s
  double rays = 0;
  for (const EstimateSettings& look : kLooks) {
    rays += double(look.points) * look.directions;
    if (links < double(kFewLinks)) break;  // the first look mostly does
  }
  return links * (kLevelsMade * kMade + kGathers * kAcross) + rays * kRay;
}

constexpr double kBytesOfLink = 63;  // in memory, and on disk

double estimate_records(double elements, const Plan& plan) {
  constexpr double kBytesOfElement = 260;
  return elements * kBytesOfElement + double(plan.smallest_disk);
}

// Of the budget what there is use for, and the code.
std::uint64_t estimate_memory(const SolveOptions& options, const Prepared& p, const Plan& plan,
                              const Refined& refined) {
  constexpr double kCode = 20 << 20;  // bytes: code and libraries
  const double records = estimate_records(refined.elements, plan);
  const double in_arena = std::min(records, double(ClusterStore::arena_memory(plan.arena)));
  return std::uint64_t(kCode + std::min(double(options.memory), double(beside_arena(p)) + in_arena +
                                                                    refined.links * kBytesOfLink));
}

std::uint64_t estimate_disk(const Plan& plan, const Refined& refined) {
  constexpr double kCopies = 2;  // of records: as the last root has them and as the next one will
  return PageFile::file_bytes_for(std::uint64_t(
      kCopies * estimate_records(refined.elements, plan) + refined.links * kBytesOfLink));
}

CostEstimate estimate_cost(const SolveOptions& options, const Prepared& p, const Plan& plan) {
  const Refined refined = estimate_refined(options, p, plan);
  return {.elements = std::uint64_t(refined.elements),
          .links = std::uint64_t(refined.links),
          .memory_bytes = estimate_memory(options, p, plan, refined),
          .disk_bytes = estimate_disk(plan, refined),
          .cpu_seconds = estimate_seconds(refined.links)};
}

// The first records, before any element is split.
std::uint64_t first_records_bytes(const SolveOptions& options, const Model& model,
                                  const Plan& plan) {
  std::uint64_t first = model.vertices.size() * sizeof(Vec3) +
                        model.patches.size() * sizeof(Patch) +
                        model.visible.items.size() * sizeof(ClusterId);
  for (const Cluster& c : model.clusters)
    first += ClusterStore::arena_cost(first_record_bytes(model, c, options.basis, plan.dense)) +
             kGranule;
  return first;
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

}  // namespace

bool forces(const SolveOptions& options, const std::string& feature) {
  return std::find(options.force.begin(), options.force.end(), feature) != options.force.end();
}

Status budget_too_small(const char* option, std::uint64_t given, std::uint64_t smallest) {
  return Status(Code::kUsage, "", option,
                std::to_string(given) + " bytes are too small for this scene",
                "the smallest that will do is " + std::to_string(smallest) + " bytes");
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
  p.bytes = bytes_of(p.scene) + bytes_of(p.model) + plan.patches * kFreshOfPatch;
  plan_memory(options, p, plan);
  plan.smallest_disk = first_records_bytes(options, p.model, plan);
  plan.estimated = estimate_cost(options, p, plan);
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
    ATRIUM_RETURN_IF_ERROR((*warm)->begin(equilibrium, cursor));
    p->plan.warm = (*warm)->figures(equilibrium);
    p->plan.smallest_memory = (*warm)->smallest_memory();
  }
  return p->plan;
}

}  // namespace atrium
