// atrium gen KIND: procedural scenes.
#include <iostream>
#include <memory>

#include "apps/command.h"
#include "apps/report_json.h"
#include "data/generate.h"

namespace atrium {
namespace {

constexpr std::uint64_t kMost =
    1000000;  // of rooms, storeys, ...: the generator has its own limits

struct Gen {
  std::vector<std::string> kind;
  std::string output;
  GenerateOptions options;
};

OptionSet gen_options(Gen& gen) {
  OptionSet o;
  o.argument("KIND", "what to make: " + joined(generator_kinds()), 1, 1, gen.kind);
  o.output("the OBJ to write, its materials beside it (KIND.obj)", gen.output);
  o.count("seed", "moves furniture, partitions and colours about", 0, UINT64_MAX,
          [&](std::uint64_t n) { gen.options.seed = n; });
  const auto number = [&](const char* name, const char* help, std::optional<double>& target) {
    o.custom(name, help, "NUMBER", [&target](const std::string& text) -> Status {
      const Result<double> value = parse_number(text);
      if (!value.ok()) return value.status();
      target = *value;
      return {};
    });
  };
  const auto word = [&](const char* name, const char* help, std::optional<std::string>& target) {
    o.custom(name, help, "NAME", [&target](const std::string& text) -> Status {
      target = text;
      return {};
    });
  };
  const auto count = [&](const char* name, const char* help, std::optional<int>& target) {
    o.count(name, help, 1, kMost, [&target](std::uint64_t n) { target = static_cast<int>(n); });
  };
  number("rho", "furnace, rooms: every surface's reflectance", gen.options.rho);
  number("emit", "furnace: every surface's exitance, lm/m2", gen.options.exitance);
  word("shape", "furnace: cube, l-room, two-rooms, grid3x3", gen.options.shape);
  count("grid", "rooms: K of K x K", gen.options.grid);
  word("furnish", "none, low, high", gen.options.furnish);
  count("storeys", "building, campus: how many", gen.options.storeys);
  count("rooms", "floor, building, campus: at least so many on a storey", gen.options.rooms);
  count("buildings", "campus: how many", gen.options.buildings);
  return o;
}

Result<int> run_gen(Gen& gen, const Global& global, Console& console) {
  gen.options.kind = gen.kind.front();
  const Result<GeneratedModel> model = generate(gen.options);
  if (!model.ok()) return model.status();
  const std::string path = gen.output.empty() ? gen.options.kind + ".obj" : gen.output;
  ATRIUM_RETURN_IF_ERROR(write_obj(*model, path));
  const ModelCounts counts = model->counts();
  if (global.json)
    std::cout << generated_json(path, counts.clusters, counts.patches, counts.lights);
  console.say(path + ": " + std::to_string(counts.clusters) + " clusters, " +
              std::to_string(counts.patches) + " patches, " + std::to_string(counts.lights) +
              " lights");
  return 0;
}

}  // namespace

Command gen_command() {
  auto gen = std::make_shared<Gen>();
  return {"gen", "make a procedural scene", gen_options(*gen),
          [gen](const Global& global, Console& console) { return run_gen(*gen, global, console); }};
}

}  // namespace atrium
