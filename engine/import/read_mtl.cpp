#include "engine/import/read_mtl.h"

#include <charconv>
#include <limits>

#include "engine/import/text.h"

namespace atrium {
namespace {

// Any number that the format can write, NaN and infinities too: those are refused later, with the
// material's name, like every other value out of range.
bool parse_any(std::string_view token, double& value) {
  if (parse_finite(token, value)) return true;
  if (token.starts_with('+')) token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [rest, error] = std::from_chars(token.data(), end, value);
  if (rest != end) return false;
  if (error == std::errc::result_out_of_range) value = std::numeric_limits<double>::infinity();
  return true;
}

class MtlReader {
 public:
  MtlReader(const std::string& path, std::uint32_t file, RawModel& model,
            std::unordered_map<std::string, std::uint32_t>& by_name, WarningLog& warnings)
      : path_(path), file_(file), model_(model), by_name_(by_name), warnings_(warnings) {}

  Status read() {
    const Result<std::string> text = read_whole_file(path_);
    if (!text.ok()) return text.status();
    for (Statements s(*text); s.next();) {
      line_ = s.line();
      ATRIUM_RETURN_IF_ERROR(statement(s));
    }
    return {};
  }

 private:
  Status broken(const std::string& cause, const std::string& remedy) const {
    std::string place = "line " + std::to_string(line_);
    if (current_ != kNone) place += ", material '" + model_.materials[current_].name + "'";
    return Status(Code::kScene, path_, place, cause, remedy);
  }

  Status statement(const Statements& s) {
    const std::string_view word = s.keyword();
    if (word == "newmtl") return start(std::string(s.remainder()));
    if (current_ == kNone) {
      if (word == "Kd" || word == "Ke" || word == "d" || word == "Tr")
        return broken(std::string(word) + " stands before any newmtl", "name its material first");
      return {};
    }
    RawMaterial& m = model_.materials[current_];
    if (word == "Ke") return colour(s, m.emission);
    if (word == "Kd") {
      m.has_reflectance = true;
      return colour(s, m.reflectance);
    }
    if (word == "d")
      return opacity(s, [&](double d) {
        m.opacity = d;
        opacity_given_ = true;
      });
    if (word == "Tr")
      return opacity(s, [&](double t) {
        if (!opacity_given_) m.opacity = 1 - t;
      });
    if (word == "map_Kd" || word == "map_Ke") m.textured = true;
    return {};
  }

  Status start(std::string name) {
    RawMaterial m = undefined_material(name, file_);
    m.library = path_;
    m.place = "line " + std::to_string(line_);
    opacity_given_ = false;
    const auto [at, added] =
        by_name_.try_emplace(name, static_cast<std::uint32_t>(model_.materials.size()));
    current_ = at->second;
    if (added) {
      model_.materials.push_back(std::move(m));
      return {};
    }
    warnings_.add("materials defined twice, the last definition counts",
                  "'" + name + "' in " + path_ + ", line " + std::to_string(line_));
    model_.materials[current_] = std::move(m);
    return {};
  }

  // One number for all channels or three.
  Status colour(const Statements& s, Spectrum& value) {
    const std::vector<std::string_view>& words = s.words();
    if (words.size() == 2 || words.size() == 4) {
      double v[3];
      bool ok = true;
      for (std::size_t i = 1; i < words.size(); ++i) ok = ok && parse_any(words[i], v[i - 1]);
      if (ok) {
        value = words.size() == 2 ? Spectrum{v[0]} : Spectrum{v[0], v[1], v[2]};
        return {};
      }
    }
    return broken("'" + std::string(words[0]) + " " + std::string(s.remainder()) +
                      "' is not one number or three",
                  "write linear RGB");
  }

  template <class Take>
  Status opacity(const Statements& s, Take take) {
    // "d -halo 0.5": the dissolve at grazing angles; its number is the last word.
    double value = 0;
    const std::size_t expected = s.words().size() > 1 && s.words()[1] == "-halo" ? 3 : 2;
    if (s.words().size() != expected || !parse_finite(s.words().back(), value) || value < 0 ||
        value > 1)
      return broken("'" + std::string(s.keyword()) + " " + std::string(s.remainder()) +
                        "' is not a number from 0 to 1",
                    "write 1 for opaque");
    take(value);
    return {};
  }

  static constexpr std::uint32_t kNone = RawFace::kNoMaterial;
  const std::string& path_;
  const std::uint32_t file_;
  RawModel& model_;
  std::unordered_map<std::string, std::uint32_t>& by_name_;
  WarningLog& warnings_;
  std::uint32_t current_ = kNone;
  std::uint32_t line_ = 0;
  bool opacity_given_ = false;
};

}  // namespace

RawMaterial undefined_material(std::string name, std::uint32_t file) {
  RawMaterial m;
  m.name = std::move(name);
  m.file = file;
  return m;
}

Status read_mtl(const std::string& path, std::uint32_t file, RawModel& model,
                std::unordered_map<std::string, std::uint32_t>& by_name, WarningLog& warnings) {
  return MtlReader(path, file, model, by_name, warnings).read();
}

}  // namespace atrium
