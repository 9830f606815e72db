#include "pagestore/policy.h"

#include "pagestore/policies/policies.h"

namespace atrium {

namespace {

struct NamedPolicy {
  const char* name;
  std::unique_ptr<Policy> (*make)(std::size_t capacity);
};

constexpr NamedPolicy kPolicies[] = {
#define ATRIUM_POLICY(NAME) {#NAME, make_##NAME},
#include "pagestore/policies/table.inc"
#undef ATRIUM_POLICY
};

}  // namespace

Result<std::unique_ptr<Policy>> make_policy(const std::string& name, std::size_t capacity) {
  std::string known;
  for (const NamedPolicy& policy : kPolicies) {
    if (name == policy.name) return policy.make(capacity);
    known += std::string(known.empty() ? "" : ", ") + policy.name;
  }
  return Status(Code::kUsage, "policy", name, "there is no such policy", "one of: " + known);
}

std::vector<std::string> policy_names() {
  std::vector<std::string> names;
  for (const NamedPolicy& policy : kPolicies) names.emplace_back(policy.name);
  return names;
}

}  // namespace atrium
