#include "pagestore/policy.h"

#include <charconv>

#include "engine/check.h"
#include "pagestore/policies/policies.h"

namespace atrium {

namespace {

enum Foresight { kNone, kAll, kGiven };

struct NamedPolicy {
  const char* name;
  std::unique_ptr<Policy> (*make)(std::uint64_t capacity);
  Foresight foresight;
};

constexpr NamedPolicy kPolicies[] = {
#define ATRIUM_POLICY(NAME, MAKER, FORESIGHT) {NAME, MAKER, FORESIGHT},
#include "pagestore/policies/table.inc"
#undef ATRIUM_POLICY
};

Status no_such_policy(const std::string& name) {
  std::string known;
  for (const std::string& n : policy_names()) known += (known.empty() ? "" : ", ") + n;
  return Status(Code::kUsage, "policy", name, "there is no such policy", "one of: " + known);
}

// "W" of "lookahead:W": how many requests, at least one.
std::uint64_t given_foresight(const std::string& text) {
  std::uint64_t requests = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, requests);
  return error == std::errc() && stopped == end ? requests : 0;
}

}  // namespace

Result<PolicyChoice> parse_policy(const std::string& name) {
  const std::size_t colon = name.find(':');
  const std::string algorithm = name.substr(0, colon);
  for (const NamedPolicy& policy : kPolicies) {
    if (algorithm != policy.name || (colon == name.npos) == (policy.foresight == kGiven)) continue;
    PolicyChoice choice{name, algorithm, policy.foresight == kAll ? PolicyChoice::kAll : 0};
    if (policy.foresight != kGiven) return choice;
    choice.foresight = given_foresight(name.substr(colon + 1));
    if (choice.foresight > 0) return choice;
  }
  return no_such_policy(name);
}

std::unique_ptr<Policy> make_policy(const PolicyChoice& choice, std::uint64_t capacity) {
  for (const NamedPolicy& policy : kPolicies)
    if (choice.algorithm == policy.name) return policy.make(capacity);
  ATRIUM_CHECK(false);
  return nullptr;
}

std::vector<std::string> policy_names() {
  std::vector<std::string> names;
  for (const NamedPolicy& policy : kPolicies)
    names.push_back(policy.name + std::string(policy.foresight == kGiven ? ":W" : ""));
  return names;
}

}  // namespace atrium
