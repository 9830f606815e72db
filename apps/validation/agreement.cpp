#include "apps/validation/agreement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "engine/check.h"

namespace atrium {

double nrmse(std::span<const double> found, std::span<const double> expected) {
  ATRIUM_CHECK(found.size() == expected.size());
  const double n = double(expected.size());
  const double mean = std::accumulate(expected.begin(), expected.end(), 0.0) / n;
  if (!(mean > 0)) return std::numeric_limits<double>::quiet_NaN();
  double squares = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double error = (found[i] - expected[i]) / std::max(expected[i], mean);
    squares += error * error;
  }
  return std::sqrt(squares / n);
}

}  // namespace atrium
